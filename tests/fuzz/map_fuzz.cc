// SPDX-License-Identifier: Apache-2.0
#include "localizer/index/map_index.h"
#include "schema/file/map_store.h"
#include "tests/fuzz/compressed.h"
#include "tests/fuzz/fuzz_targets.h"

namespace waystone {
namespace {

constexpr size_t kMaxFileBytes = 4 << 20;

MapData ReadUnversioned(const std::filesystem::path& path) {
  MapData map = ReadMap(path);
  map.info.version.clear();
  return map;
}

}  // namespace

// The input is a map file, compressed. What is refused `waystone check` finds; what is accepted is
// written and read to the same, and can be searched or is refused.
bool FuzzMap(FuzzInput input) {
  const auto path = WriteInput("map.db", Decompress(TextOf(input), kMaxFileBytes));
  const auto map = ReadOrRefuse([&] { return ReadUnversioned(path); });
  const auto problems = ReadOrRefuse([&] { return CheckMap(path); });
  ReadOrRefuse([&] { return TableSizes(path); });
  Require(map || !problems || !problems->empty(), "the check finds what is refused");
  if (!map) return false;
  const auto written = FuzzFolder() / "written.db";
  const MapData again = ReadBack(
      [&] {
        WriteMap(*map, written, {.overwrite = true});
        return ReadUnversioned(written);
      },
      "a map");
  Require(again == *map, "a map is written and read to the same");
  ReadOrRefuse([&] { return MapIndex::Build(again); });
  return true;
}

}  // namespace waystone
