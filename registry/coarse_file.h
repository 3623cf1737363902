// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "localizer/index/map_index.h"
#include "registry/map_version.h"
#include "registry/store.h"

namespace waystone {

// Puts the map's entry of the coarse index (localizer/coarse/coarse_entry.h) into the store, under
// its hash like a map file. Nothing for a map whose places have no features to be found by:
// searches of all maps don't propose it. Throws MapError as Store::Put does, and kFileUnwritable
// without room for a temporary file. Thread-safe.
std::optional<CoarseFile> PutCoarseEntry(const Store& store, const MapIndex& index);

}  // namespace waystone
