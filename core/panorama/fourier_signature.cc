// SPDX-License-Identifier: Apache-2.0
#include "core/panorama/fourier_signature.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <opencv2/imgproc.hpp>
#include <string>
#include <vector>

#include "core/base/check.h"
#include "core/base/error.h"
#include "core/geometry/angle.h"

namespace waystone {
namespace {

constexpr double kMinSigma = 0.5;  // grey levels: below that there is only rounding

// Adds weight times a row of the panorama.
void AddRow(const cv::Mat& grey, int row, float weight, float* sum) {
  const auto* in = grey.ptr<uint8_t>(row);
  for (int x = 0; x < grey.cols; ++x) sum[x] += weight * static_cast<float>(in[x]);
}

// The mean of the rows from `top` to `bottom`, the first and last weighted by their covered part.
void MeanOfRows(const cv::Mat& grey, double top, double bottom, float* mean) {
  std::fill(mean, mean + grey.cols, 0.0F);
  const int last = std::min(grey.rows, static_cast<int>(std::ceil(bottom)));
  for (int row = static_cast<int>(top); row < last; ++row) {
    const double covered = std::min(bottom, row + 1.0) - std::max<double>(top, row);
    AddRow(grey, row, static_cast<float>(covered / (bottom - top)), mean);
  }
}

void Normalise(cv::Mat& band) {
  cv::Scalar mean;
  cv::Scalar sigma;
  cv::meanStdDev(band, mean, sigma);
  if (sigma[0] < kMinSigma) {
    throw MapError(
        ErrorCode::kBadImage,
        "the band of the panorama has no texture (standard deviation of its grey levels " +
            std::to_string(sigma[0]) + ", less than " + std::to_string(kMinSigma) +
            "); uncover the lens, increase the exposure or choose another band");
  }
  band.convertTo(band, CV_32F, 1 / sigma[0], -mean[0] / sigma[0]);
}

// cv::dft counts the azimuth from the centre of column 0, the signature from the front, which is
// half a turn less half a column away: the turn of frequency l.
std::vector<std::complex<float>> TurnsToFront(int frequencies, int columns) {
  std::vector<std::complex<float>> turns(frequencies);
  for (int l = 0; l < frequencies; ++l) {
    const double angle = l * (kPi - kPi / columns);
    turns[l] = std::complex<float>(std::polar(1.0 / columns, angle));
  }
  return turns;
}

// One row of OpenCV's packed spectrum (Re 0, Re 1, Im 1, Re 2, Im 2, ...) as x and y, turned.
void TurnRow(const float* packed, const std::vector<std::complex<float>>& turns, float* x,
             float* y) {
  x[0] = packed[0] * turns[0].real();
  y[0] = 0;
  for (size_t l = 1; l < turns.size(); ++l) {
    const float re = packed[2 * l - 1];
    const float im = packed[2 * l];
    x[l] = re * turns[l].real() - im * turns[l].imag();
    y[l] = re * turns[l].imag() + im * turns[l].real();
  }
}

// The first `columns` columns as 16-bit floats.
HalfMatrix ToHalf(const cv::Mat& values, int columns) {
  HalfMatrix half(values.rows, columns);
  cv::Mat out(values.rows, columns, CV_16FC1, half.data());
  values.colRange(0, columns).convertTo(out, CV_16F);
  return half;
}

}  // namespace

bool FourierSignature::operator==(const FourierSignature& other) const {
  const auto same = [](const HalfMatrix& a, const HalfMatrix& b) {
    return a.rows() == b.rows() && a.cols() == b.cols() && (a.array() == b.array()).all();
  };
  return same(magnitudes, other.magnitudes) && same(phases, other.phases);
}

void SignatureOptions::Check() const {
  CheckFields("signature", *this);
  if (!(band.top_rad <= kPi / 2 && band.bottom_rad >= -kPi / 2 && band.top_rad > band.bottom_rad)) {
    throw MapError(
        ErrorCode::kBadOptions,
        "the band from " + std::to_string(band.top_rad) + " to " + std::to_string(band.bottom_rad) +
            " rad is invalid; the top comes first, and both must be between pi / 2 and -pi / 2");
  }
}

ElevationBand UsedBand(const Panorama& panorama, const SignatureOptions& options) {
  options.Check();
  const ElevationBand& shown = panorama.band;
  const ElevationBand used = {std::min(shown.top_rad, options.band.top_rad),
                              std::max(shown.bottom_rad, options.band.bottom_rad)};
  const double row_rad = (shown.top_rad - shown.bottom_rad) / panorama.grey.rows;
  if (used.top_rad - used.bottom_rad >= row_rad) return used;
  throw MapError(ErrorCode::kBadImage,
                 "the panorama covers elevations from " + std::to_string(shown.top_rad) + " to " +
                     std::to_string(shown.bottom_rad) +
                     " rad, which do not overlap the band from " +
                     std::to_string(options.band.top_rad) + " to " +
                     std::to_string(options.band.bottom_rad) + "; choose another band");
}

cv::Mat ExtractBand(const Panorama& panorama, const SignatureOptions& options) {
  options.Check();
  WS_CHECK(panorama.grey.type() == CV_8UC1, "a panorama must be grey");
  const int columns = 2 * std::max(options.k1, options.k2);
  if (panorama.grey.cols < columns) {
    throw MapError(ErrorCode::kBadImage,
                   "the panorama has " + std::to_string(panorama.grey.cols) +
                       " columns, too few for " + std::to_string(columns / 2) +
                       " frequencies; the minimum is " + std::to_string(columns));
  }
  const ElevationBand used = UsedBand(panorama, options);
  const double rows_per_rad =
      panorama.grey.rows / (panorama.band.top_rad - panorama.band.bottom_rad);
  const double top = (panorama.band.top_rad - used.top_rad) * rows_per_rad;
  const double step = (used.top_rad - used.bottom_rad) * rows_per_rad / options.rows;
  cv::Mat band(options.rows, panorama.grey.cols, CV_32FC1);
  for (int row = 0; row < options.rows; ++row) {
    MeanOfRows(panorama.grey, top + row * step, top + (row + 1) * step, band.ptr<float>(row));
  }
  if (options.normalise) Normalise(band);
  return band;
}

FourierSignature DescribeBand(const cv::Mat& band, const SignatureOptions& options) {
  const int frequencies = std::max(options.k1, options.k2);
  WS_CHECK(band.type() == CV_32FC1 && band.cols >= 2 * frequencies, "not a band for the options");
  cv::Mat spectrum;
  cv::dft(band, spectrum, cv::DFT_ROWS);
  const auto turns = TurnsToFront(frequencies, band.cols);
  cv::Mat x(band.rows, frequencies, CV_32FC1);
  cv::Mat y(band.rows, frequencies, CV_32FC1);
  for (int row = 0; row < band.rows; ++row) {
    TurnRow(spectrum.ptr<float>(row), turns, x.ptr<float>(row), y.ptr<float>(row));
  }
  cv::Mat magnitudes;
  cv::Mat phases;
  cv::cartToPolar(x, y, magnitudes, phases);
  // cartToPolar gives 0 to 2 pi; around 0 a 16-bit float is finer.
  phases.forEach<float>([](float& phase, const int*) {
    if (phase > static_cast<float>(kPi)) phase -= static_cast<float>(2 * kPi);
  });
  return {ToHalf(magnitudes, options.k1), ToHalf(phases, options.k2)};
}

FourierSignature Signature(const Panorama& panorama, const SignatureOptions& options) {
  return DescribeBand(ExtractBand(panorama, options), options);
}

FourierSignature Signature(const cv::Mat& panorama, const SignatureOptions& options) {
  if (panorama.type() == CV_8UC1) return Signature(Panorama{panorama, {}}, options);
  WS_CHECK(panorama.type() == CV_8UC3, "a panorama must be CV_8UC1 or CV_8UC3");
  cv::Mat grey;
  cv::cvtColor(panorama, grey, cv::COLOR_BGR2GRAY);
  return Signature(Panorama{grey, {}}, options);
}

}  // namespace waystone
