// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "schema/map_data.h"

namespace waystone {

// A keyframe's picture (CV_8UC3, 640 px wide) with its planes drawn over it, each in the colour of
// its surface: its features, mapped here from the reference image, as dots, and its outline. On
// plain grey when the map has no picture. `surface_of_plane` is FindSurfaces of the map.
// Thread-safe.
cv::Mat DrawPlanes(const MapData& map, const std::vector<PlaneId>& surface_of_plane,
                   const Keyframe& keyframe);

}  // namespace waystone
