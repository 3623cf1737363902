// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "schema/map_data.h"

// Parts of a map that are queried while it is built or joined. Thread-safe.
namespace waystone {

// What queries of the map's planes need, without the pictures of keyframes.
MapData CopyPlanes(const MapData& map);

// What queries of the map's panoramas need, without their pictures.
MapData CopyPanoramas(const MapData& map);

}  // namespace waystone
