// SPDX-License-Identifier: Apache-2.0
#include "core/panorama/visual_compass.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/base/error.h"
#include "core/base/random.h"
#include "core/geometry/angle.h"
#include "tests/core/panorama/panoramas.h"

namespace waystone {
namespace {

double Error(double angle_rad, double truth_rad) {
  return std::abs(std::remainder(angle_rad - truth_rad, 2 * kPi));
}

// Gain, noise of 10 grey levels and a tenth of the columns covered by something grey.
cv::Mat Disturbed(const cv::Mat& panorama, double gain, Random& random) {
  cv::Mat image = panorama.clone();
  for (int y = 0; y < image.rows; ++y) {
    for (int x = 0; x < image.cols; ++x) {
      const double value = gain * image.at<uint8_t>(y, x) + 10 * random.Normal();
      image.at<uint8_t>(y, x) = cv::saturate_cast<uint8_t>(value);
    }
  }
  const int covered = image.cols / 10;
  const int from = random.Below(image.cols - covered);
  image.colRange(from, from + covered).setTo(random.Below(200));
  return image;
}

void ExpectTurnsFound(const std::vector<cv::Mat>& panoramas) {
  Random random(1);
  std::vector<double> phase_errors;
  std::vector<double> errors;
  for (const cv::Mat& panorama : panoramas) {
    const FourierSignature a = Signature(panorama);
    for (const double gain : {0.6, 1.0, 1.4}) {
      const int columns = random.Below(panorama.cols);
      const FourierSignature b = Signature(Disturbed(Rolled(panorama, columns), gain, random));
      const double truth = 2 * kPi * columns / panorama.cols;
      phase_errors.push_back(Error(TurnByPhases(a, b).best.heading_rad, truth));
      const CompassHeading heading = RelativeHeading(a, b);
      errors.push_back(Error(heading.heading_rad, truth));
      EXPECT_LT(errors.back(), 0.2 * kDegree) << columns << " " << gain;
      EXPECT_LT(phase_errors.back(), 0.2 * kDegree) << columns << " " << gain;
      EXPECT_LT(heading.sigma_rad, 1 * kDegree);
    }
  }
  for (std::vector<double>* each : {&errors, &phase_errors}) {
    std::ranges::sort(*each);
    EXPECT_LT((*each)[each->size() / 2], 0.05 * kDegree);
  }
}

TEST(VisualCompass, FindsTheTurnOfDisturbedPanoramas) {
  ExpectTurnsFound({RenderedPanorama(RoomCentre(), 0.3), RenderedPanorama({2, 10}, 2),
                    RenderedPanorama({6, 8}, -1)});
}

TEST(VisualCompass, FindsTheTurnOfRealDisturbedPanoramas) {
  const std::vector<cv::Mat> panoramas = RealPanoramas(4);
  if (panoramas.empty()) GTEST_SKIP() << "no real panoramas (set WAYSTONE_DATA)";
  ExpectTurnsFound(panoramas);
}

TEST(VisualCompass, HeadingIsCounterClockwise) {
  const FourierSignature a = Signature(RenderedPanorama(RoomCentre(), 0));
  const FourierSignature b = Signature(RenderedPanorama(RoomCentre(), 0.4));
  EXPECT_NEAR(TurnByPhases(a, b).best.heading_rad, 0.4, 0.003);
  EXPECT_NEAR(RelativeHeading(a, b).heading_rad, 0.4, 0.003);
  EXPECT_NEAR(RelativeHeading(b, a).heading_rad, -0.4, 0.003);
}

TEST(VisualCompass, BearsTilt) {
  const FourierSignature a = Signature(RenderedPanorama(RoomCentre(), 0));
  const FourierSignature b = Signature(RenderedPanorama(RoomCentre(), 1.2, 2 * kDegree));
  const CompassHeading heading = RelativeHeading(a, b);
  EXPECT_TRUE(heading.small_motion);
  EXPECT_LT(Error(heading.heading_rad, 1.2), 0.3 * kDegree);
}

// What covers a tenth of the columns misleads coarse stages: a start at the true turn wins over
// one that is off, and one that is off doesn't over a good one.
TEST(VisualCompass, TheStartThatFitsBetterGoesOn) {
  const FourierSignature a = Signature(RenderedPanorama(RoomCentre(), 0));
  const FourierSignature b = Signature(RenderedPanorama(RoomCentre(), 1.2));
  const ElevationBand band = SignatureOptions{}.band;
  const SmallMotion alone = RefineSmallMotion(a, b, band, 2.4, {});
  EXPECT_GT(Error(alone.turn_rad, 1.2), 2 * kDegree);
  const SmallMotion with = RefineSmallMotion(a, b, band, 2.4, {}, StillStart{1.2, 32});
  EXPECT_LT(Error(with.turn_rad, 1.2), 0.1 * kDegree);
  const SmallMotion better = RefineSmallMotion(a, b, band, 1.25, {}, StillStart{2.4, 32});
  EXPECT_LT(Error(better.turn_rad, 1.2), 0.1 * kDegree);
}

TEST(VisualCompass, FewerFrequenciesRefineLessFinely) {
  const FourierSignature a = Signature(RenderedPanorama(RoomCentre(), 0));
  const FourierSignature b = Signature(RenderedPanorama(RoomCentre(), 1.2));
  SmallMotionOptions options;
  for (const int frequencies : {5, 20, 32, 4096}) {  // also some that fill no whole block
    options.fine_frequencies = frequencies;
    const SmallMotion small = RefineSmallMotion(a, b, SignatureOptions{}.band, 1.25, options);
    EXPECT_LT(Error(small.turn_rad, 1.2), 0.5 * kDegree) << frequencies;
    EXPECT_GT(small.correlation, 0.9) << frequencies;
  }
}

// Steps of a robot in a room: heading and direction of motion.
TEST(VisualCompass, TellsWhereTheCameraWent) {
  const FourierSignature a = Signature(RenderedPanorama(RoomCentre(), 0.2));
  for (const double world_direction : {0.0, 1.0, 2.5, -2.0}) {
    const Eigen::Vector2d step(0.2 * std::cos(world_direction), 0.2 * std::sin(world_direction));
    const FourierSignature b = Signature(RenderedPanorama(RoomCentre() + step, 0.5));
    const CompassHeading heading = RelativeHeading(a, b);
    EXPECT_LT(Error(heading.heading_rad, 0.3), 2 * kDegree) << world_direction;
    ASSERT_TRUE(heading.motion.has_value()) << world_direction;
    EXPECT_LT(Error(heading.motion->direction_rad, world_direction - 0.2), 15 * kDegree);
    ASSERT_TRUE(heading.motion->step_per_distance.has_value());
    EXPECT_NEAR(*heading.motion->step_per_distance, 0.1, 0.06);
  }
}

TEST(VisualCompass, SaysWhenItDoesNotKnow) {
  const FourierSignature a = Signature(RenderedPanorama(RoomCentre(), 0));
  const FourierSignature b = Signature(RenderedPanorama({4.5, 1.5}, 0));  // another room
  const CompassHeading heading = RelativeHeading(a, b);
  EXPECT_GT(heading.sigma_rad, 5 * kDegree);
  EXPECT_LT(heading.sharpness, 0.05);
  EXPECT_LT(TurnByPhases(a, b).sharpness, TurnByPhases(a, a).sharpness / 4);
}

TEST(VisualCompass, RunnerUpLiesOff) {
  const FourierSignature a = Signature(RenderedPanorama(RoomCentre(), 0));
  const FourierSignature b = Signature(RenderedPanorama(RoomCentre(), 2));
  const CompassOptions options;
  const CompassHeading heading = RelativeHeading(a, b, options);
  EXPECT_GT(Error(heading.heading_rad, heading.runner_up_rad), options.separation_rad - 0.09);
  EXPECT_GT(heading.sharpness, 0);
  const PhaseCompass phases = TurnByPhases(a, b);
  EXPECT_GT(Error(phases.best.heading_rad, phases.runner_up.heading_rad), 0.3);
  EXPECT_NEAR(phases.sharpness, phases.best.score - phases.runner_up.score, 1e-12);
}

TEST(VisualCompass, SameSignaturesSameAnswer) {
  const FourierSignature a = Signature(RenderedPanorama(RoomCentre(), 0));
  const FourierSignature b = Signature(RenderedPanorama({6.8, 10.4}, 1));
  EXPECT_EQ(RelativeHeading(a, b).heading_rad, RelativeHeading(a, b).heading_rad);
}

// Each panorama's columns are matched in the other.
TEST(VisualCompass, WarpingCostsTheSameBothWays) {
  const FourierSignature a = Signature(RenderedPanorama(RoomCentre(), 0));
  const FourierSignature b = Signature(RenderedPanorama({6.8, 10.4}, 1));
  const SignatureOptions options;
  const std::vector<double> forth = SearchWarping(a, b, options.band, {}).turn_costs;
  const std::vector<double> back = SearchWarping(b, a, options.band, {}).turn_costs;
  ASSERT_EQ(forth.size(), back.size());
  for (size_t turn = 0; turn < forth.size(); ++turn) {
    EXPECT_EQ(forth[turn], back[(back.size() - turn) % back.size()]) << turn;
  }
}

TEST(CompassOptions, RefuseWhatIsOutOfRange) {
  CompassOptions options;
  EXPECT_NO_THROW(options.Check());
  options.cost_per_e = 0;
  EXPECT_THROW(options.Check(), MapError);
  options = {};
  options.warping.scales = 10;
  EXPECT_THROW(options.Check(), MapError);
  options = {};
  options.warping.columns = 71;
  EXPECT_THROW(options.Check(), MapError);
  options = {};
  options.small_motion.steps = 0;
  EXPECT_THROW(options.Check(), MapError);
  options = {};
  options.small_motion.fine_frequencies = 1;
  EXPECT_THROW(options.Check(), MapError);
  PhaseCompassOptions phases;
  phases.power = 2;
  EXPECT_THROW(phases.Check(), MapError);
}

}  // namespace
}  // namespace waystone
