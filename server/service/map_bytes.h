// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "registry/map_version.h"

namespace waystone {

// Bytes of memory that an open map takes, as a multiple of its file: measured as 1.4 for maps of
// planes and 2.6 with an appearance layer, whose index of features is made when the map is opened.
// Pure; thread-safe.
inline int64_t OpenBytes(const MapVersion& version) {
  return version.bytes * (HasLayer(version, "appearance") ? 3 : 2);
}
// The same while it is being opened: the file is in memory, too. Pure; thread-safe.
inline int64_t OpeningBytes(const MapVersion& version) {
  return OpenBytes(version) + version.bytes;
}

}  // namespace waystone
