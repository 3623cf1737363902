// SPDX-License-Identifier: Apache-2.0
#include "core/panorama/row_images.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/base/check.h"

namespace waystone {

int CommonFrequencies(const FourierSignature& signature) {
  return static_cast<int>(std::min(signature.magnitudes.cols(), signature.phases.cols()));
}

RowImage Rebuild(const FourierSignature& signature, int frequencies, int columns, double turn_rad) {
  WS_CHECK(frequencies >= 1 && frequencies <= CommonFrequencies(signature) && columns >= 1,
           "frequencies that the signature doesn't have");
  const auto rows = signature.magnitudes.rows();
  // A row is the real part of sum (2) m_l exp(j (p_l + l turn)) exp(j l azimuth).
  const RowImage phases =
      signature.phases.leftCols(frequencies).cast<float>().rowwise() +
      Eigen::RowVectorXf::LinSpaced(frequencies, 0, frequencies - 1) * static_cast<float>(turn_rad);
  RowImage amplitudes = signature.magnitudes.leftCols(frequencies).cast<float>();
  amplitudes.rightCols(frequencies - 1) *= 2;
  Eigen::ArrayXf angles(columns);
  for (int j = 0; j < columns; ++j) angles[j] = 2 * std::numbers::pi_v<float> * j / columns;
  RowImage cosines(frequencies, columns);
  RowImage sines(frequencies, columns);
  for (int l = 0; l < frequencies; ++l) {
    for (int j = 0; j < columns; ++j) {
      const float angle = angles[(static_cast<int64_t>(l) * j) % columns];
      cosines(l, j) = std::cos(angle);
      sines(l, j) = std::sin(angle);
    }
  }
  RowImage image(rows, columns);
  image.noalias() = amplitudes.cwiseProduct(phases.array().cos().matrix()) * cosines;
  image.noalias() -= amplitudes.cwiseProduct(phases.array().sin().matrix()) * sines;
  return image;
}

}  // namespace waystone
