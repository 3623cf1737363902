// SPDX-License-Identifier: Apache-2.0
// The power fails after each call of a write of a map.
#include "tests/faults/files/power_loss.h"

#include <gtest/gtest.h>

#include <iostream>
#include <string>
#include <vector>

#include "tests/faults/files/map_writes.h"

namespace waystone {
namespace {

constexpr int kStatesPerCall = 50;

struct RecordedWrite {
  DiskState before;
  std::string old_map, new_map;
  std::filesystem::path path;
  std::vector<FileCall> calls;
};

RecordedWrite Record(const MapWrite& write, const TemporaryFolder& folder) {
  write.prepare(folder);
  RecordedWrite recorded;
  recorded.path = folder / "m.db";
  recorded.old_map = ReadFile(recorded.path);
  recorded.before = {{recorded.path, recorded.old_map}};
  {
    const WatchedCalls watched(folder.path());
    write.write(folder);
    recorded.calls = watched.succeeded();
  }
  recorded.new_map = ReadFile(recorded.path);
  return recorded;
}

// What losses of power made of the map's file.
struct Losses {
  int states = 0;
  int old_maps = 0;
  int new_maps = 0;
  int broken() const { return states - old_maps - new_maps; }
};

Losses LosePowerAfter(const RecordedWrite& write, size_t calls) {
  Random random(calls + 1);
  Losses losses;
  for (int i = 0; i < kStatesPerCall; ++i) {
    const DiskState state =
        StateAfterPowerLoss(write.before, std::span(write.calls).first(calls), random);
    ++losses.states;
    const auto map = state.find(write.path);
    if (map == state.end()) continue;
    losses.old_maps += map->second == write.old_map ? 1 : 0;
    losses.new_maps += map->second == write.new_map ? 1 : 0;
  }
  return losses;
}

Losses LosePowerAnywhere(const RecordedWrite& write) {
  Losses all;
  for (size_t calls = 0; calls <= write.calls.size(); ++calls) {
    const Losses losses = LosePowerAfter(write, calls);
    all.states += losses.states;
    all.old_maps += losses.old_maps;
    all.new_maps += losses.new_maps;
  }
  return all;
}

class PowerLoss : public testing::TestWithParam<MapWrite> {};

TEST_P(PowerLoss, LeavesTheOldMapOrTheNewOne) {
  const TemporaryFolder folder;
  const RecordedWrite write = Record(GetParam(), folder);
  const Losses losses = LosePowerAnywhere(write);
  std::cout << losses.states << " states after " << write.calls.size()
            << " calls: " << losses.old_maps << " old maps, " << losses.new_maps << " new ones\n";
  EXPECT_EQ(losses.broken(), 0);
  EXPECT_GT(losses.new_maps, 0);
}

TEST_P(PowerLoss, AfterTheWriteLeavesTheNewOne) {
  const TemporaryFolder folder;
  const RecordedWrite write = Record(GetParam(), folder);
  EXPECT_EQ(LosePowerAfter(write, write.calls.size()).new_maps, kStatesPerCall);
}

// The attacker can win: a write that doesn't sync its file before the rename loses the map.
TEST_P(PowerLoss, BreaksAWriteThatDoesNotSync) {
  const TemporaryFolder folder;
  RecordedWrite write = Record(GetParam(), folder);
  std::erase_if(write.calls, [](const FileCall& call) { return call.kind == FileCallKind::kSync; });
  EXPECT_GT(LosePowerAnywhere(write).broken(), 0);
}

INSTANTIATE_TEST_SUITE_P(Writes, PowerLoss, testing::Values(Overwrite(), Migrate()),
                         [](const auto& param) { return param.param.name; });

}  // namespace
}  // namespace waystone
