// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <opencv2/core.hpp>
#include <string_view>

#include "core/camera/panorama.h"

namespace waystone {

// The faces of a rig of pinhole cameras of 90 by 90 degrees with one centre. Rig frame: x right, y
// down, z forward. Up and down are what the front camera sees when it tilts by 90 degrees.
enum class CubeFace { kFront = 0, kRight, kBack, kLeft, kUp, kDown };
inline constexpr int kCubeFaces = 6;
inline constexpr int kSideFaces = 4;  // the first ones, which every such rig has

// "front", "right", "back", "left", "up", "down".
std::string_view NameOf(CubeFace face);

// x_rig = rig_from_face x_face.
Eigen::Matrix3d RigFromFace(CubeFace face);

// Images by CubeFace; empty for a face that the rig doesn't have (up, down).
using FaceImages = std::array<cv::Mat, kCubeFaces>;

// The panorama of a rig, options.columns wide, linear between pixels. Without an up or down face,
// its band ends at the elevation where the four sides end in their corners, atan(1 / sqrt(2)) from
// the horizon.
// Throws MapError(kBadImage) when one of the four sides is missing or the faces are not square or
// of different sizes. Images as for ToPanorama. Thread-safe.
Panorama FromFaces(const FaceImages& faces, const PanoramaOptions& options = {});

// What a face of the rig sees of a whole equirectangular image (any type): width_px square.
// Thread-safe.
cv::Mat FaceOf(const cv::Mat& equirectangular, CubeFace face, int width_px);

}  // namespace waystone
