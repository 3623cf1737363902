// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <ostream>
#include <string>

#include "tests/schema/made_map.h"

namespace waystone {

// Two ways in which a map's file is replaced: `write` does it to `folder` / "m.db", where `prepare`
// put the old map.
struct MapWrite {
  std::string name;
  std::function<void(const TemporaryFolder&)> prepare;
  std::function<void(const TemporaryFolder&)> write;
};

inline void PrintTo(const MapWrite& write, std::ostream* out) { *out << write.name; }

MapWrite Overwrite();  // WriteMap onto another map
MapWrite Migrate();    // MigrateMap of a map of version 1

}  // namespace waystone
