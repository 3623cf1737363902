// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <numbers>
#include <opencv2/core.hpp>
#include <optional>

#include "core/base/options.h"

namespace waystone {

// Elevations are angles above the horizon: up is positive (camera.h's asin(Y / |x|) is minus that).
struct ElevationBand {
  double top_rad = std::numbers::pi / 2;
  double bottom_rad = -std::numbers::pi / 2;

  static constexpr auto Fields(const auto& use) {
    constexpr double kUp = std::numbers::pi / 2;
    return use(OptionField{"top_rad", &ElevationBand::top_rad, Closed(-kUp, kUp), "rad",
                           "Upper end of the band, above the lower one."},
               OptionField{"bottom_rad", &ElevationBand::bottom_rad, Closed(-kUp, kUp), "rad",
                           "Lower end of the band."});
  }
  bool operator==(const ElevationBand&) const = default;
};

// Whether the rows of both have the same elevations: the ends differ by at most a millionth of a
// radian.
bool BandsAgree(const ElevationBand& a, const ElevationBand& b);

// A panorama: columns are azimuth over the whole circle, growing clockwise seen from above (to the
// right), the middle of the image looks to the front and the seam is behind; rows are elevation,
// linear from the image's upper edge (band.top_rad) to its lower edge (band.bottom_rad). A whole
// equirectangular image (camera.h) has the default band.
struct Panorama {
  cv::Mat grey;  // CV_8UC1
  ElevationBand band;
};

// The circle of a catadioptric camera's mirror in its image, and the camera's own reflection
// within.
struct MirrorRing {
  cv::Point2d centre_px;
  double inner_px = 0;  // radii
  double outer_px = 0;

  bool operator==(const MirrorRing&) const = default;
};

struct PanoramaOptions {
  int columns = 1024;
  // A mirror's elevations at its outer and inner radius, pi / 2 to -pi / 2; between them elevation
  // is linear in the radius. Depends on the mirror: see its data sheet.
  ElevationBand mirror_band = {0.35, -0.9};
  // Where the mirror is; found in the image when not given.
  std::optional<MirrorRing> mirror;
  bool mirror_clockwise = true;
  double max_seam = 3;
  double min_mirror_contrast = 12;

  static constexpr int kUnlistedMembers = 1;  // where the mirror is: what is known of one camera
  static constexpr auto Fields(const auto& use) {
    return use(
        OptionField{"columns", &PanoramaOptions::columns, Closed(16, 16'384), "",
                    "Number of columns of a panorama unwrapped from a mirror image or joined from "
                    "faces. More columns preserve more detail; for a mirror image, more than 2 pi "
                    "times its outer radius bring no gain."},
        OptionGroup{"mirror_band", &PanoramaOptions::mirror_band},
        OptionField{
            "mirror_clockwise", &PanoramaOptions::mirror_clockwise, AnyValue(), "",
            "Whether the azimuth increases clockwise in the mirror image (a camera that looks up "
            "into the mirror sees it counter-clockwise). The front is at the top of the image."},
        OptionField{"max_seam", &PanoramaOptions::max_seam, Closed(1, 100), "",
                    "Maximum difference between the two sides of the seam, relative to the 98th "
                    "percentile of the differences between neighbouring columns. Above it, the "
                    "image counts as covering less than 360 degrees. Lower values refuse panoramas "
                    "whose seam runs along an edge."},
        OptionField{"min_mirror_contrast", &PanoramaOptions::min_mirror_contrast, Closed(1, 100),
                    "grey levels",
                    "Minimum brightness difference between the inside and the outside of the "
                    "mirror's circle in the image."});
  }
  void Check() const;  // throws MapError(kBadOptions)
};

enum class PanoramaKind { kEquirectangular, kStrip, kMirror };

// An image as a panorama. Twice as wide as high (HasPanoramaShape): equirectangular. Wider: a strip
// of one around the horizon, as many radians high as its pixels are. Less wide, or with a mirror
// given: a catadioptric camera's image, which is unwrapped. Grey (CV_8UC1), BGR (CV_8UC3) and BGRA
// (CV_8UC4, whose alpha is dropped) are taken. Throws MapError(kBadImage), with what to do about
// it, for an image of fewer than 64 columns or 8 rows, or one that has no texture (all black),
// isn't 360 degrees wide (the seam's sides differ) or is neither a panorama nor a mirror's image.
// Thread-safe.
Panorama ToPanorama(const cv::Mat& image, const PanoramaOptions& options = {});

// Whether an image is a whole equirectangular panorama by its shape: twice as wide as high, to 2 %.
bool HasPanoramaShape(const cv::Size& size);

// What ToPanorama takes an image for.
PanoramaKind KindOf(const cv::Mat& image, const PanoramaOptions& options = {});

// The difference between the seam's two sides over the 98th percentile of the differences between
// neighbouring columns: about 1 for a panorama, several for other images.
double SeamRatio(const cv::Mat& grey);

// The mirror's circle: the one with the highest contrast of its bright inside against its outside;
// the inner radius is that of the strongest concentric edge, or a quarter of the outer one. Throws
// MapError(kBadImage) when no circle has the contrast, or what surrounds the best one isn't of
// nearly one brightness, as in a photo.
MirrorRing FindMirror(const cv::Mat& grey, const PanoramaOptions& options = {});

// A mirror's image (CV_8UC1) unwrapped: rows from the outer radius (top) to the inner. Throws
// MapError(kBadOptions) for an impossible ring, and MapError(kBadImage) for an image with a side
// over 32,766 px or a panorama of more than 64 million pixels.
Panorama Unwrap(const cv::Mat& grey, const MirrorRing& mirror, const PanoramaOptions& options = {});

}  // namespace waystone
