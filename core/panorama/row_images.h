// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "core/panorama/fourier_signature.h"

namespace waystone {

// An image rebuilt from a signature: rows as in the signature, columns spread evenly over the
// azimuth, column j at 2 pi j / columns clockwise from the front.
using RowImage = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// The frequencies for which a signature has both magnitude and phase.
int CommonFrequencies(const FourierSignature& signature);

// Rebuilds the image from the frequencies below `frequencies` (at most CommonFrequencies), turned
// so that azimuth `turn_rad` of the signature comes to the front. Row means are in it.
RowImage Rebuild(const FourierSignature& signature, int frequencies, int columns,
                 double turn_rad = 0);

}  // namespace waystone
