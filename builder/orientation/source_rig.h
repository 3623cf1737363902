// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "builder/sources/source.h"
#include "core/camera/rig.h"

namespace waystone {

// The rig that took a source's frames. Thread-safe.
struct SourceRig {
  Rig rig;
  bool panorama = false;  // frames are whole panoramas, which become the rig's faces

  // The rig's images from Frame::images.
  std::vector<cv::Mat> SplitIntoFaces(const std::vector<cv::Mat>& images) const;
};

// The faces of a rig; six faces, a quarter as wide, of panoramas (an equirectangular camera, or
// none and exactly twice as wide as high); or the one camera. Nothing for a source without a
// calibration.
std::optional<SourceRig> FindSourceRig(const Source& source);

}  // namespace waystone
