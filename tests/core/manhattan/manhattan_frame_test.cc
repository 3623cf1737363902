// SPDX-License-Identifier: Apache-2.0
#include "core/manhattan/manhattan_frame.h"
#include "core/geometry/rotation.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <numbers>

#include "core/base/error.h"
#include "core/base/random.h"
#include "core/geometry/angle.h"
#include "core/manhattan/cube_rotations.h"
#include "tests/world/test_worlds.h"

namespace waystone {
namespace {

Eigen::Vector3d RandomUnit(Random& random) {
  return Eigen::Vector3d(random.Normal(), random.Normal(), random.Normal()).normalized();
}

Eigen::Matrix3d RandomRotation(Random& random) {
  return Eigen::AngleAxisd(random.Uniform(0, std::numbers::pi), RandomUnit(random))
      .toRotationMatrix();
}

// The arc of a line of a direction, its ends seen with errors of `sigma_rad` across.
GreatCircle Arc(const Eigen::Vector3d& direction, double sigma_rad, Random& random) {
  GreatCircle arc;
  Eigen::Vector3d middle = RandomUnit(random);
  while (std::abs(middle.dot(direction)) > 0.95) middle = RandomUnit(random);
  const Eigen::Vector3d normal = middle.cross(direction).normalized();
  const Eigen::Vector3d along = normal.cross(middle);
  arc.length_rad = random.Uniform(0.05, 0.4);
  const double half = 0.5 * arc.length_rad;
  const Eigen::Vector3d a =
      std::cos(half) * middle - std::sin(half) * along + sigma_rad * random.Normal() * normal;
  const Eigen::Vector3d b =
      std::cos(half) * middle + std::sin(half) * along + sigma_rad * random.Normal() * normal;
  arc.normal = a.cross(b).normalized();
  arc.middle = (a + b).normalized();
  arc.along = arc.normal.cross(arc.middle);
  arc.end_sigma_rad = sigma_rad;
  return arc;
}

// Lines of each axis of a frame and lines of no common direction.
std::vector<GreatCircle> Lines(const Eigen::Matrix3d& frame, const std::array<int, 3>& counts,
                               int others, double sigma_rad, Random& random) {
  std::vector<GreatCircle> lines;
  for (int axis = 0; axis < 3; ++axis) {
    for (int i = 0; i < counts[axis]; ++i) {
      lines.push_back(Arc(frame.col(axis), sigma_rad, random));
    }
  }
  for (int i = 0; i < others; ++i) lines.push_back(Arc(RandomUnit(random), sigma_rad, random));
  return lines;
}

TEST(ManhattanFrame, FindsAnyRotationAmongStrayLines) {
  Random random(3);
  for (int trial = 0; trial < 30; ++trial) {
    const Eigen::Matrix3d truth = RandomRotation(random);
    const auto lines = Lines(truth, {40, 25, 15}, 60, 0.001, random);
    const ManhattanFrame frame = FindManhattanFrame(lines);
    EXPECT_LT(WorstAxisAngle(frame.rig_from_axes, truth), 0.3 * kDegree) << trial;
    EXPECT_TRUE(frame.reliable()) << NameOf(frame.error);
    EXPECT_TRUE((frame.rig_from_axes.transpose() * frame.rig_from_axes).isIdentity(1e-12));
    EXPECT_GT(frame.rig_from_axes.determinant(), 0);
  }
}

TEST(ManhattanFrame, TwoDirectionsAreEnough) {
  Random random(4);
  const Eigen::Matrix3d truth = RandomRotation(random);
  const ManhattanFrame frame = FindManhattanFrame(Lines(truth, {20, 20, 0}, 5, 0.0005, random));
  EXPECT_LT(WorstAxisAngle(frame.rig_from_axes, truth), 0.3 * kDegree);
  EXPECT_TRUE(frame.reliable());
}

TEST(ManhattanFrame, ExactLinesGiveTheExactFrame) {
  Random random(5);
  const Eigen::Matrix3d truth = RandomRotation(random);
  const ManhattanFrame frame = FindManhattanFrame(Lines(truth, {10, 10, 10}, 0, 0, random));
  EXPECT_LT(WorstAxisAngle(frame.rig_from_axes, truth), 1e-6);
  EXPECT_EQ(frame.lines, (std::array{10, 10, 10}));
  EXPECT_NEAR(frame.support[0] + frame.support[1] + frame.support[2], 1, 1e-9);
}

TEST(ManhattanFrame, CountsTheLinesOfEachAxis) {
  Random random(6);
  const auto lines = Lines(RandomRotation(random), {30, 20, 10}, 0, 0.0005, random);
  const ManhattanFrame frame = FindManhattanFrame(lines);
  ASSERT_EQ(frame.axis_of_line.size(), lines.size());
  std::array<int, 3> sorted = frame.lines;
  std::ranges::sort(sorted);
  EXPECT_EQ(sorted, (std::array{10, 20, 30}));
  std::array<int, 3> counted{};
  for (const int axis : frame.axis_of_line) {
    if (axis >= 0) ++counted[axis];
  }
  EXPECT_EQ(counted, frame.lines);
}

// Errors within what is stated: the axes' own errors are drawn as the options have them.
TEST(ManhattanFrame, CovarianceCoversTheErrors) {
  Random random(7);
  const ManhattanOptions options;
  double sum = 0;
  constexpr int kTrials = 60;
  for (int trial = 0; trial < kTrials; ++trial) {
    const Eigen::Matrix3d truth = RandomRotation(random);
    Eigen::Matrix3d bent = truth;
    for (int axis = 0; axis < 3; ++axis) {
      const Eigen::Vector3d error(random.Normal(), random.Normal(), random.Normal());
      bent.col(axis) += options.axis_sigma_rad * error.cross(truth.col(axis));
      bent.col(axis).normalize();
    }
    const ManhattanFrame frame = FindManhattanFrame(Lines(bent, {40, 30, 20}, 20, 0.001, random));
    const Eigen::AngleAxisd turn(truth * NearestOfCube(frame.rig_from_axes, truth).transpose());
    const Eigen::Vector3d w = turn.angle() * turn.axis();
    sum += w.dot(frame.covariance.ldlt().solve(w)) / 3;
  }
  EXPECT_GT(sum / kTrials, 0.5);
  EXPECT_LT(sum / kTrials, 1.6);
}

TEST(ManhattanFrame, SaysWhyItIsNotReliable) {
  Random random(8);
  const Eigen::Matrix3d truth = RandomRotation(random);
  EXPECT_EQ(FindManhattanFrame({}).error, FrameError::kFewLines);
  EXPECT_EQ(FindManhattanFrame({}).sigma_rad(), 1) << "nothing is known";
  EXPECT_EQ(FindManhattanFrame(Lines(truth, {1, 1, 0}, 0, 0.001, random)).error,
            FrameError::kFewLines);
  EXPECT_EQ(FindManhattanFrame(Lines(truth, {30, 0, 0}, 0, 0.0002, random)).error,
            FrameError::kOneDirection);
  EXPECT_FALSE(FindManhattanFrame(Lines(truth, {0, 0, 0}, 200, 0.001, random)).reliable());
  // Two buildings at 30 degrees to each other.
  auto lines = Lines(truth, {30, 20, 20}, 0, 0.0005, random);
  const Eigen::Matrix3d other =
      truth * Eigen::AngleAxisd(30 * kDegree, Eigen::Vector3d::UnitX()).toRotationMatrix();
  const auto more = Lines(other, {0, 20, 20}, 0, 0.0005, random);
  lines.insert(lines.end(), more.begin(), more.end());
  EXPECT_EQ(FindManhattanFrame(lines).error, FrameError::kRival);
}

TEST(ManhattanFrame, SameSeedSameFrame) {
  Random random(9);
  const auto lines = Lines(RandomRotation(random), {30, 30, 30}, 100, 0.001, random);
  EXPECT_EQ(FindManhattanFrame(lines).rig_from_axes, FindManhattanFrame(lines).rig_from_axes);
}

TEST(ManhattanFrame, RenumberingKeepsWhatBelongsTogether) {
  Random random(10);
  const Eigen::Matrix3d truth = RandomRotation(random);
  const auto lines = Lines(truth, {30, 20, 10}, 10, 0.0005, random);
  for (const Eigen::Matrix3d& c : CubeRotations()) {
    const ManhattanFrame frame = Renumbered(FindManhattanFrame(lines), truth * c);
    EXPECT_LT(RotationAngle(frame.rig_from_axes, truth * c), 0.01);
    for (size_t i = 0; i < 60; ++i) {
      const int axis = frame.axis_of_line[i];
      if (axis < 0) continue;
      EXPECT_LT(std::abs(lines[i].normal.dot(frame.rig_from_axes.col(axis))), 0.05);
    }
    std::array<int, 3> counted{};
    for (const int axis : frame.axis_of_line) {
      if (axis >= 0) ++counted[axis];
    }
    EXPECT_EQ(counted, frame.lines);
  }
}

TEST(ManhattanFrame, OptionsOutOfRangeAreRefused) {
  EXPECT_THROW((ManhattanOptions{.max_pairs = 1}.Check()), MapError);
  EXPECT_THROW((ManhattanOptions{.line_sigma_rad = 0}.Check()), MapError);
  EXPECT_THROW((GreatCircleOptions{.end_sigma_px = 0}.Check()), MapError);
}

// Segments of a strongly distorted camera become the right arcs, and bent ones are left out.
TEST(GreatCircles, UndoDistortion) {
  const Rig rig = RigOfOne({CameraModel::kOpenCv, 640, 480, {400, 400, 320, 240, -0.2, 0, 0, 0}});
  const Camera& camera = rig.cameras[0].camera;
  // A vertical line through the image's right part.
  const auto pixel = [&](double y) { return *Project(camera, {0.5, y, 1}); };
  const std::vector<ImageSegment> segments{{pixel(-0.1), pixel(0.1)}, {pixel(-0.5), pixel(0.5)}};
  const auto arcs = FindGreatCircles(rig, 0, segments, {.end_sigma_px = 0.5, .max_sag_px = 2});
  ASSERT_EQ(arcs.size(), 1u) << "the long one is bent by several pixels";
  EXPECT_NEAR(arcs[0].normal.dot(Eigen::Vector3d::UnitY()), 0, 1e-6);
  EXPECT_NEAR(arcs[0].end_sigma_rad, 0.5 / 400, 0.3 / 400);
}

// A rendered room seen by a tilted six-face rig and by one tilted camera.
TEST(ManhattanFrame, RenderedRoom) {
  const Eigen::Isometry3d pose = WorldFromCamera({1.5, 2.0, 1.4}, 0.5, 0.2, 0.1);
  for (const Rig& rig : {CubeRig(240), RigOfOne(PinholeCamera(480, 360, 1.2))}) {
    std::vector<GreatCircle> lines;
    for (size_t c = 0; c < rig.cameras.size(); ++c) {
      const cv::Mat image =
          Render(TwoRoomWorld(), rig.cameras[c].camera, pose * rig.cameras[c].rig_from_camera).grey;
      const auto found = FindGreatCircles(rig, static_cast<int>(c), DetectSegments(image));
      lines.insert(lines.end(), found.begin(), found.end());
    }
    const ManhattanFrame frame = FindManhattanFrame(lines);
    const Eigen::Matrix3d truth = pose.linear().transpose();
    EXPECT_LT(WorstAxisAngle(frame.rig_from_axes, truth), 0.5 * kDegree) << rig.cameras.size();
    EXPECT_TRUE(frame.reliable()) << NameOf(frame.error);
  }
}

}  // namespace
}  // namespace waystone
