// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "schema/map_data.h"

// Parts of a map that are asked while it is built or joined.
namespace waystone {

// The map as far as its planes are asked for, without the pictures of keyframes.
MapData CopyPlanes(const MapData& map);

// The map as far as its panoramas are asked for, without their pictures.
MapData CopyPanoramas(const MapData& map);

}  // namespace waystone
