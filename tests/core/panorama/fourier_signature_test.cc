// SPDX-License-Identifier: Apache-2.0
#include "core/panorama/fourier_signature.h"

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "core/base/error.h"
#include "core/geometry/angle.h"
#include "core/panorama/row_images.h"
#include "tests/core/panorama/panoramas.h"

namespace waystone {
namespace {

// Magnitudes of a band before they become 16-bit floats.
cv::Mat Magnitudes(const cv::Mat& band, int frequencies) {
  cv::Mat spectrum;
  cv::dft(band, spectrum, cv::DFT_ROWS | cv::DFT_COMPLEX_OUTPUT);
  cv::Mat parts[2];
  cv::split(spectrum.colRange(0, frequencies), parts);
  cv::Mat magnitudes;
  cv::magnitude(parts[0], parts[1], magnitudes);
  return magnitudes / band.cols;
}

void ExpectTurnInvariant(const cv::Mat& panorama) {
  const SignatureOptions options;
  const cv::Mat magnitudes = Magnitudes(ExtractBand({panorama, {}}, options), options.k1);
  const FourierSignature signature = Signature(panorama, options);
  for (const int columns : {1, 17, 255, 511, panorama.cols - 3}) {
    const cv::Mat turned = Rolled(panorama, columns);
    const cv::Mat other = Magnitudes(ExtractBand({turned, {}}, options), options.k1);
    EXPECT_LT(cv::norm(magnitudes, other) / cv::norm(magnitudes), 1e-4 / 10) << columns;
    const FourierSignature half = Signature(turned, options);
    const Eigen::MatrixXf a = signature.magnitudes.cast<float>();
    const Eigen::MatrixXf b = half.magnitudes.cast<float>();
    // Each within a rounding of 16 bits, which is 2^-11 relative, of the other.
    EXPECT_TRUE(((a - b).array().abs() <= 1e-3F * a.array() + 1e-6F).all()) << columns;
  }
}

TEST(FourierSignature, MagnitudesDoNotTurn) {
  ExpectTurnInvariant(RenderedPanorama(RoomCentre(), 0.3));
  for (const cv::Mat& panorama : RealPanoramas(5)) ExpectTurnInvariant(panorama);
}

TEST(FourierSignature, PhasesTurnByFrequency) {
  const cv::Mat panorama = RenderedPanorama(RoomCentre(), 0);
  const FourierSignature a = Signature(panorama);
  const int columns = 29;
  const FourierSignature b = Signature(Rolled(panorama, columns));
  const double turn = 2 * kPi * columns / panorama.cols;
  for (int row = 0; row < a.phases.rows(); ++row) {
    for (int l = 1; l < a.phases.cols(); ++l) {
      const double change =
          static_cast<float>(a.phases(row, l)) - static_cast<float>(b.phases(row, l)) - l * turn;
      EXPECT_NEAR(std::remainder(change, 2 * kPi), 0, 0.01) << row << " " << l;
    }
  }
}

// row(azimuth) = m_0 cos p_0 + 2 sum m_l cos(l azimuth + p_l), azimuth from the front.
TEST(FourierSignature, IsWhatItsHeaderSays) {
  const double offset = 100;
  const double amplitude = 40;
  const double phase = 0.7;
  cv::Mat wave(8, 256, CV_32FC1);
  for (int x = 0; x < wave.cols; ++x) {
    const double azimuth = 2 * kPi * (x + 0.5) / wave.cols - kPi;
    wave.col(x).setTo(offset + 2 * amplitude * std::cos(5 * azimuth + phase));
  }
  const FourierSignature signature = DescribeBand(wave, {});
  EXPECT_NEAR(static_cast<float>(signature.magnitudes(3, 0)), offset, 0.1);
  EXPECT_NEAR(static_cast<float>(signature.magnitudes(3, 5)), amplitude, 0.05);
  EXPECT_NEAR(static_cast<float>(signature.phases(3, 5)), phase, 1e-3);
  EXPECT_LT(static_cast<float>(signature.magnitudes(3, 6)), 1e-3F);
}

TEST(FourierSignature, DoesNotDependOnTheColumns) {
  const cv::Mat panorama = RenderedPanorama(RoomCentre(), 1);
  cv::Mat wide;
  cv::resize(panorama, wide, {2 * panorama.cols, panorama.rows}, 0, 0, cv::INTER_NEAREST);
  const Eigen::MatrixXf a = Signature(panorama).magnitudes.cast<float>();
  const Eigen::MatrixXf b = Signature(wide).magnitudes.cast<float>();
  EXPECT_LT((a - b).leftCols(16).norm() / a.norm(), 0.01);
}

TEST(FourierSignature, RebuildsTheBandThatItWasMadeOf) {
  const cv::Mat panorama = RenderedPanorama(RoomCentre(), 0.5);
  SignatureOptions options;
  options.k1 = options.k2 = 256;
  const cv::Mat band = ExtractBand({panorama, {}}, options);
  const RowImage image =
      Rebuild(DescribeBand(band, options), 256, 512, kPi / 512 - kPi);  // column 0 to the front
  double squares = 0;
  for (int y = 0; y < band.rows; ++y) {
    for (int x = 0; x < band.cols; ++x) squares += std::pow(image(y, x) - band.at<float>(y, x), 2);
  }
  EXPECT_LT(std::sqrt(squares) / cv::norm(band), 0.02);
}

// Sums of cosines at the columns, whether they are enough for the frequencies or not.
TEST(FourierSignature, ImagesAreSampledAtTheirColumns) {
  const FourierSignature signature = Signature(RenderedPanorama(RoomCentre(), 0.5));
  const RowSpectra spectra = ComputeSpectra(signature, 40);
  constexpr double kTurn = 0.3;
  for (const int columns : {1, 24, 39, 40, 78, 79, 200}) {
    const RowImage image = RebuildTurned(spectra, 40, columns, kTurn);
    for (int j = 0; j < columns; ++j) {
      double value = 0;
      for (int l = 0; l < 40; ++l) {
        const double phase = static_cast<float>(signature.phases(7, l));
        value += (l == 0 ? 1 : 2) * static_cast<float>(signature.magnitudes(7, l)) *
                 std::cos(phase + l * (kTurn + 2 * kPi * j / columns));
      }
      EXPECT_NEAR(image(7, j), value, 1e-4) << columns << " " << j;
    }
  }
}

TEST(FourierSignature, NormalisingTakesExposureAway) {
  const cv::Mat panorama = RenderedPanorama(RoomCentre(), 0.5);
  cv::Mat darker;
  panorama.convertTo(darker, CV_8U, 0.7, 5);
  const Eigen::MatrixXf a = Signature(panorama).magnitudes.cast<float>();
  const Eigen::MatrixXf b = Signature(darker).magnitudes.cast<float>();
  EXPECT_LT((a - b).norm() / a.norm(), 0.02);
  SignatureOptions plain;
  plain.normalise = false;
  const Eigen::MatrixXf c = Signature(darker, plain).magnitudes.cast<float>();
  EXPECT_NEAR(c.col(0).mean() / Signature(panorama, plain).magnitudes.cast<float>().col(0).mean(),
              0.7, 0.06);
}

TEST(FourierSignature, ColourGivesItsGrey) {
  const cv::Mat panorama = RenderedPanorama(RoomCentre(), 0.5);
  cv::Mat colour;
  cv::cvtColor(panorama, colour, cv::COLOR_GRAY2BGR);
  EXPECT_EQ(Signature(colour), Signature(panorama));
  EXPECT_FALSE(Signature(Rolled(panorama, 3)) == Signature(panorama));
}

TEST(FourierSignature, UsesWhatThePanoramaShowsOfTheBand) {
  const cv::Mat panorama = RenderedPanorama(RoomCentre(), 0.5);
  const Panorama part = {panorama, {0.3, -1}};
  EXPECT_EQ(UsedBand(part, {}), (ElevationBand{0.3, -0.6}));
  SignatureOptions above;
  above.band = {1.2, 0.8};
  EXPECT_THROW(UsedBand(part, above), MapError);
}

TEST(FourierSignature, RefusesWhatHasNoTextureOrTooFewColumns) {
  EXPECT_THROW(Signature(cv::Mat(256, 512, CV_8UC1, cv::Scalar(0))), MapError);
  EXPECT_THROW(Signature(RenderedPanorama(RoomCentre(), 0).colRange(0, 100).clone()), MapError);
}

TEST(SignatureOptions, RefusesWhatIsOutOfRange) {
  SignatureOptions options;
  EXPECT_NO_THROW(options.Check());
  options.rows = 1;  // a motion between two needs two
  EXPECT_THROW(options.Check(), MapError);
  options = {};
  options.k2 = 1;
  EXPECT_THROW(options.Check(), MapError);
  options = {};
  options.band = {-0.1, 0.1};
  EXPECT_THROW(options.Check(), MapError);
}

}  // namespace
}  // namespace waystone
