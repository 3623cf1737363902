// SPDX-License-Identifier: Apache-2.0
// Fourier signatures and the phase compass, as properties over generated bands.
#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <cmath>

#include "core/base/error.h"
#include "core/geometry/angle.h"
#include "core/panorama/fourier_signature.h"
#include "core/panorama/visual_compass.h"
#include "tests/core/panorama/panoramas.h"

namespace waystone {
namespace {

constexpr int kColumns = 64;
constexpr int kBandRows = 6;

const SignatureOptions kSmall{.rows = kBandRows, .k1 = 16, .k2 = 16};

// Waves and noise, as float32; often with rows of one value.
cv::Mat DrawBand() {
  cv::Mat band(kBandRows, kColumns, CV_32FC1);
  for (int row = 0; row < band.rows; ++row) {
    const int noise = *rc::gen::inRange(0, 3) * 100;
    const double level = *rc::gen::inRange(-200, 200);
    for (int x = 0; x < band.cols; ++x) {
      const double value = level + (noise == 0 ? 0 : *rc::gen::inRange(-noise, noise)) / 10.0;
      band.at<float>(row, x) = static_cast<float>(value);
    }
  }
  return band;
}

Eigen::MatrixXd Numbers(const HalfMatrix& matrix) { return matrix.cast<double>(); }

bool IsFinite(const FourierSignature& signature) {
  const Eigen::MatrixXd m = Numbers(signature.magnitudes);
  const Eigen::MatrixXd p = Numbers(signature.phases);
  return m.allFinite() && (m.array() >= 0).all() && (p.array().abs() <= kPi + 1e-3).all();
}

template <class Property>
void ExpectForBands(const std::string& what, const Property& property) {
  EXPECT_TRUE(rc::check(what, property));
}

TEST(SignatureProperties, TurningKeepsTheMagnitudesAndShiftsThePhases) {
  ExpectForBands("m_l stays, p_l loses l h (eq. 1)", [] {
    const cv::Mat band = DrawBand();
    const int columns = *rc::gen::inRange(1, kColumns);
    const double turn_rad = 2 * kPi * columns / kColumns;
    const FourierSignature a = DescribeBand(band, kSmall);
    const FourierSignature b = DescribeBand(Rolled(band, columns), kSmall);
    RC_ASSERT(IsFinite(a) && IsFinite(b));
    const Eigen::MatrixXd m = Numbers(a.magnitudes);
    RC_ASSERT((m - Numbers(b.magnitudes)).cwiseAbs().maxCoeff() < 1e-3 * m.maxCoeff() + 1e-3);
    for (int row = 0; row < kBandRows; ++row) {
      for (int l = 1; l < kSmall.k2; ++l) {
        if (m(row, l) < 0.05) continue;  // the phase of nothing
        const double change = Numbers(a.phases)(row, l) - Numbers(b.phases)(row, l) - l * turn_rad;
        RC_ASSERT(std::abs(std::remainder(change, 2 * kPi)) < 0.02);
      }
    }
  });
}

TEST(SignatureProperties, ScaleAndOffsetOfABand) {
  ExpectForBands("s row + c has the magnitudes s m_l for l > 0", [] {
    const cv::Mat band = DrawBand();
    const double scale = *rc::gen::inRange(1, 40) / 10.0;
    const cv::Mat other = scale * band + *rc::gen::inRange(-50, 50);
    const Eigen::MatrixXd a = Numbers(DescribeBand(band, kSmall).magnitudes);
    const Eigen::MatrixXd b = Numbers(DescribeBand(other, kSmall).magnitudes);
    const Eigen::MatrixXd difference = (scale * a - b).rightCols(kSmall.k1 - 1);
    RC_ASSERT(difference.cwiseAbs().maxCoeff() < 2e-3 * b.maxCoeff() + 1e-3);
  });
}

TEST(SignatureProperties, ThePhasesFindTheTurn) {
  ExpectForBands("the heading of a turned band, of a score near 1", [] {
    cv::Mat band(kBandRows, kColumns, CV_32FC1);
    cv::RNG noise(static_cast<uint64_t>(*rc::gen::inRange(1, 1'000'000)));
    noise.fill(band, cv::RNG::NORMAL, 0, 10);
    const int columns = *rc::gen::inRange(1, kColumns);
    const PhaseCompass compass =
        TurnByPhases(DescribeBand(band, kSmall), DescribeBand(Rolled(band, columns), kSmall));
    const double turn_rad = 2 * kPi * columns / kColumns;
    RC_ASSERT(std::abs(std::remainder(compass.best.heading_rad - turn_rad, 2 * kPi)) < 0.02);
    RC_ASSERT(compass.best.score > 0.98);
  });
}

// Black, one grey level, a few specks: a signature without NaN, or an error that says so.
TEST(SignatureProperties, DegenerateImagesNeverGiveNaN) {
  ExpectForBands("kBadImage, or all finite", [] {
    const int height = *rc::gen::inRange(1, 40);
    cv::Mat panorama(height, 2 * height, CV_8UC1, cv::Scalar(*rc::gen::inRange(0, 256)));
    const int specks = *rc::gen::inRange(0, 4);
    for (int i = 0; i < specks; ++i) {
      panorama.at<uint8_t>(*rc::gen::inRange(0, height), *rc::gen::inRange(0, 2 * height)) =
          static_cast<uint8_t>(*rc::gen::inRange(0, 256));
    }
    SignatureOptions options = kSmall;
    options.normalise = *rc::gen::arbitrary<bool>();
    try {
      const FourierSignature signature = Signature(panorama, options);
      RC_ASSERT(IsFinite(signature));
      const PhaseCompass compass = TurnByPhases(signature, signature);
      RC_ASSERT(std::isfinite(compass.best.heading_rad) && std::isfinite(compass.best.score) &&
                std::isfinite(compass.runner_up.heading_rad) && std::isfinite(compass.sharpness));
    } catch (const MapError& error) {
      RC_ASSERT(error.code() == ErrorCode::kBadImage);
    }
  });
}

TEST(SignatureProperties, SignaturesOfNothingHaveAFiniteHeading) {
  const FourierSignature nothing{HalfMatrix::Zero(kBandRows, kSmall.k1),
                                 HalfMatrix::Zero(kBandRows, kSmall.k2)};
  const PhaseCompass compass = TurnByPhases(nothing, nothing);
  EXPECT_TRUE(std::isfinite(compass.best.heading_rad) && std::isfinite(compass.best.score));
  EXPECT_TRUE(std::isfinite(compass.sharpness));
}

}  // namespace
}  // namespace waystone
