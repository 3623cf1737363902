// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "core/panorama/fourier_signature.h"

namespace waystone {

// An image rebuilt from a signature: rows as in the signature, columns spread evenly over the
// azimuth, column j at 2 pi j / columns clockwise from the front. All functions here are pure;
// thread-safe.
using RowImage = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// The frequencies for which a signature has both magnitude and phase.
int CommonFrequencies(const FourierSignature& signature);

// A signature's rows as complex numbers, from which images of several sizes and turns are made.
struct RowSpectra {
  RowImage re;  // rows x frequencies: m_l cos p_l
  RowImage im;  // m_l sin p_l

  int frequencies() const { return static_cast<int>(re.cols()); }
};

// Of the frequencies below `frequencies` (1 to CommonFrequencies).
RowSpectra ComputeSpectra(const FourierSignature& signature, int frequencies);

// The image of the frequencies below `frequencies` (at most those of the spectra), turned so that
// azimuth `turn_rad` comes to the front: sampled at `columns` columns, with frequencies beyond half
// of them folded over. Includes the row means.
RowImage RebuildTurned(const RowSpectra& spectra, int frequencies, int columns,
                       double turn_rad = 0);

// Both steps.
RowImage Rebuild(const FourierSignature& signature, int frequencies, int columns,
                 double turn_rad = 0);

}  // namespace waystone
