// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>

#include "core/base/options.h"
#include "core/camera/panorama.h"

namespace waystone {

using HalfMatrix = Eigen::Matrix<Eigen::half, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// The Fourier signature of a panorama (Fernandez et al. 2011, sec. III-A; after Menegatti 2004):
// the discrete Fourier transform of each row, cut to its low frequencies. Row 0 is the uppermost;
// column l is frequency l, l cycles around the horizon, from l = 0, the row's mean.
// The azimuth is measured clockwise from the front (the middle of the image), so that a signature
// doesn't depend on how many columns the panorama has:
//   row(azimuth) = m_0 cos(p_0) + 2 sum_{l > 0} m_l cos(l azimuth + p_l).
// Turning the camera by h counter-clockwise (seen from above) keeps the magnitudes and takes l h
// from the phases, which is the paper's eq. (1) with q = h N_y / (2 pi).
// 16-bit floats: 2^-11 relative.
struct FourierSignature {
  HalfMatrix magnitudes;  // rows x k1: |A_l| / N_y; grey levels, or the band's sigmas when
                          // photometrically normalised
  HalfMatrix phases;      // rows x k2, radians in [-pi, pi]; column 0 is 0 or pi: the mean's sign

  bool operator==(const FourierSignature& other) const;
};

struct SignatureOptions {
  int rows = 64;
  int k1 = 64;
  int k2 = 64;
  // Elevations that are used, from pi / 2 to -pi / 2, as far as the panorama shows them. A narrow
  // band sees what is far away, and less of the camera's carrier and the floor.
  ElevationBand band = {0.6, -0.6};
  bool normalise = true;

  static constexpr auto Fields(const auto& use) {
    using O = SignatureOptions;
    return use(
        OptionField{"rows", &O::rows, Closed(2, 1024), "rows",
                    "Number of rows of the signature, spread evenly over the band. More rows "
                    "resolve elevations better, at the cost of time and map size: a signature "
                    "takes 2 rows (k1 + k2) bytes."},
        OptionField{"k1", &O::k1, Closed(2, 4096), "",
                    "Number of magnitudes per row, by which places are compared. More magnitudes "
                    "distinguish nearby places; fewer tolerate more change."},
        OptionField{
            "k2", &O::k2, Closed(2, 4096), "",
            "Number of phases per row, from which headings are estimated. More phases give finer "
            "headings. The compass uses only frequencies with both a magnitude and a phase."},
        OptionGroup{"band", &O::band},
        OptionField{"normalise", &O::normalise, AnyValue(), "",
                    "Photometric normalisation: subtract the band's mean and divide by its "
                    "standard deviation. This tolerates changes of exposure, but loses the overall "
                    "brightness, which may distinguish places."});
  }
  void Check() const;  // throws MapError(kBadOptions)
  bool operator==(const SignatureOptions&) const = default;
};

// The options' band as far as the panorama shows it: what the signature's rows span. Throws
// MapError(kBadImage) when that is less than a row of pixels. Thread-safe, as all here.
ElevationBand UsedBand(const Panorama& panorama, const SignatureOptions& options);

// The band of the panorama that the signature sees: options.rows x the panorama's columns,
// CV_32FC1, each row the mean over its elevations, normalised if options.normalise. Turning the
// panorama by whole columns turns the band by exactly as many. Throws MapError(kBadImage) as
// UsedBand does, when the panorama has too few columns for the frequencies (2 max(k1, k2)), and
// when its band has no texture.
cv::Mat ExtractBand(const Panorama& panorama, const SignatureOptions& options);

// The signature of a band, CV_32FC1 of any number of rows, at least 2 max(k1, k2) columns.
FourierSignature DescribeBand(const cv::Mat& band, const SignatureOptions& options);

// Both steps.
FourierSignature Signature(const Panorama& panorama, const SignatureOptions& options = {});
// The same for a whole equirectangular image: CV_8UC1, or CV_8UC3 (BGR), which becomes grey.
FourierSignature Signature(const cv::Mat& panorama, const SignatureOptions& options = {});

}  // namespace waystone
