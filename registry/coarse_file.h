// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "localizer/index/map_index.h"
#include "registry/map_version.h"
#include "registry/store.h"

namespace waystone {

// Adds the map's entry of the coarse index (localizer/coarse/coarse_entry.h) to the store, under
// its hash as map files are. Nothing for a map whose places have no features that could be found:
// searches of all maps don't propose it. Throws as Store::Put does.
std::optional<CoarseFile> PutCoarseEntry(const Store& store, const MapIndex& index);

}  // namespace waystone
