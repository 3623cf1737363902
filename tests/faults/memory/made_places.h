// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "schema/map_data.h"

namespace waystone {

// A map of one plane, which is the whole of PhotoJpeg(), and one of three panoramas, of which the
// first is PanoramaJpeg(). Made once.
const MapData& PhotoMap();
const MapData& PanoramaMap();

// Pictures as clients send them.
const std::string& PhotoJpeg();
const std::string& PanoramaJpeg();

// Pictures of a camera that passes a wall, and of one that turns on the spot all the way.
std::vector<std::string> PhotoWalk();
std::vector<std::string> PanoramaWalk();

}  // namespace waystone
