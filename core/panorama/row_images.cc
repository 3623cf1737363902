// SPDX-License-Identifier: Apache-2.0
#include "core/panorama/row_images.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <opencv2/core.hpp>

#include "core/base/check.h"

namespace waystone {
namespace {

// Where a frequency goes in a row of OpenCV's packed spectrum (Re 0, Re 1, Im 1, Re 2, ...) of
// `columns` columns, and its factor there: when sampled, l aliases to l - columns and, conjugated,
// to columns - l.
struct Slot {
  int re = 0;
  int im = -1;  // none at frequencies 0 and columns / 2
  float re_scale = 1;
  float im_scale = 1;
};

Slot SlotOf(int frequency, int columns) {
  const int around = frequency % columns;
  const int folded = std::min(around, columns - around);
  // An inverse transform counts each frequency twice, except these two.
  if (folded == 0) return {0, -1, frequency == 0 ? 1.0F : 2.0F, 0};
  if (2 * folded == columns) return {columns - 1, -1, 2, 0};
  return {2 * folded - 1, 2 * folded, 1, around == folded ? 1.0F : -1.0F};
}

}  // namespace

int CommonFrequencies(const FourierSignature& signature) {
  return static_cast<int>(std::min(signature.magnitudes.cols(), signature.phases.cols()));
}

RowSpectra ComputeSpectra(const FourierSignature& signature, int frequencies) {
  WS_CHECK(frequencies >= 1 && frequencies <= CommonFrequencies(signature),
           "frequencies that the signature doesn't have");
  const RowImage magnitudes = signature.magnitudes.leftCols(frequencies).cast<float>();
  const RowImage phases = signature.phases.leftCols(frequencies).cast<float>();
  return {magnitudes.array() * phases.array().cos(), magnitudes.array() * phases.array().sin()};
}

RowImage RebuildTurned(const RowSpectra& spectra, int frequencies, int columns, double turn_rad) {
  WS_CHECK(frequencies >= 1 && frequencies <= spectra.frequencies() && columns >= 1,
           "frequencies that the spectra don't have");
  const auto rows = spectra.re.rows();
  RowImage packed = RowImage::Zero(rows, columns);
  for (int l = 0; l < frequencies; ++l) {
    const std::complex<float> turn(std::polar(1.0, l * turn_rad));
    const Slot slot = SlotOf(l, columns);
    for (Eigen::Index row = 0; row < rows; ++row) {
      const float re = spectra.re(row, l) * turn.real() - spectra.im(row, l) * turn.imag();
      packed(row, slot.re) += slot.re_scale * re;
      if (slot.im < 0) continue;
      const float im = spectra.re(row, l) * turn.imag() + spectra.im(row, l) * turn.real();
      packed(row, slot.im) += slot.im_scale * im;
    }
  }
  // A row of the image is the real part of sum (2) m_l exp(j (p_l + l turn)) exp(j l azimuth).
  RowImage image(rows, columns);
  cv::Mat out(static_cast<int>(rows), columns, CV_32FC1, image.data());
  cv::dft(cv::Mat(static_cast<int>(rows), columns, CV_32FC1, packed.data()), out,
          cv::DFT_INVERSE | cv::DFT_REAL_OUTPUT | cv::DFT_ROWS);
  return image;
}

RowImage Rebuild(const FourierSignature& signature, int frequencies, int columns, double turn_rad) {
  return RebuildTurned(ComputeSpectra(signature, frequencies), frequencies, columns, turn_rad);
}

}  // namespace waystone
