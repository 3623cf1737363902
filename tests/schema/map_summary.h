// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "schema/map_data.h"

namespace waystone {

// What golden/summarize.py prints of the file that the map is read from: a line a row, texts in
// hexadecimal, numbers to the last bit, blobs as the CRC-32C that they are written with.
std::string SummariseMap(const MapData& map);

}  // namespace waystone
