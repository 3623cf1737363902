// SPDX-License-Identifier: Apache-2.0
// Memory runs out while a map is built.
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "builder/build_map.h"
#include "builder/options_record.h"
#include "builder/sources/memory_source.h"
#include "core/image/decode.h"
#include "schema/file/map_store.h"
#include "tests/faults/files/map_writes.h"
#include "tests/faults/memory/attack.h"
#include "tests/faults/memory/made_places.h"

namespace waystone {
namespace {

using Names = std::vector<std::string>;
using Sources = std::vector<std::unique_ptr<Source>>;

Sources SourceOf(const std::vector<std::string>& pictures) {
  MemorySequence sequence{.name = "made"};
  for (const std::string& jpeg : pictures) {
    const int number = static_cast<int>(sequence.frames.size());
    sequence.frames.emplace_back(
        FrameInfo{number, std::to_string(number) + ".jpg", std::nullopt}, [jpeg] {
          return DecodeGrey({reinterpret_cast<const uint8_t*>(jpeg.data()), jpeg.size()}, {});
        });
  }
  Sources sources;
  sources.push_back(std::make_unique<MemorySource>(std::move(sequence)));
  return sources;
}

class BuildMemory : public testing::Test {
 protected:
  // Builds a map of the pictures over an old one, again and again: it is the old one or the new
  // one, and that is whole. A picture that there is no memory for ends the build, too.
  void Attack(const std::string& name, const std::vector<std::string>& pictures) {
    BuildOptions options;
    options.threads = 1;
    options.calibration.rendered_negatives = 0;
    options.calibration.max_keyframes = 2;
    const auto build = [&](const std::filesystem::path& file) {
      WriteMap(BuildMap(SourceOf(pictures), options, {}).map, file, {.overwrite = true});
    };
    build(folder_ / "m.db");
    const std::string after = ReadFile(folder_ / "m.db");
    WriteMap(PhotoMap(), folder_ / "m.db", {.overwrite = true});
    const std::string before = ReadFile(folder_ / "m.db");
    const MemoryAttack attack = AttackMemory(
        name, [&] { build(folder_ / "m.db"); },
        [&](bool threw) {
          ASSERT_TRUE(ReadFile(folder_ / "m.db") == (threw ? before : after));
          ASSERT_EQ(folder_.Names(), Names{"m.db"});
          WriteFile(folder_ / "m.db", before);
        },
        {.single = 40, .lasting = 8});
    EXPECT_GT(attack.threw, attack.runs / 2);
  }

  // So that every run asks for the same memory in the same order.
  const tbb::global_control one_thread_{tbb::global_control::max_allowed_parallelism, 1};
  const TemporaryFolder folder_;
};

TEST_F(BuildMemory, OptionsAreRecordedWholeOrNotAtAll) {
  const std::string expected = RecordOptions({});
  std::string record;
  const MemoryAttack attack = AttackMemory(
      "record the options", [&] { record = RecordOptions({}); },
      [&](bool threw) { ASSERT_TRUE(threw || record == expected); });
  EXPECT_GT(attack.threw, attack.runs / 2);
}

TEST_F(BuildMemory, OfPhotosLeavesTheOldMap) { Attack("build a map of photos", PhotoWalk()); }

TEST_F(BuildMemory, OfPanoramasLeavesTheOldMap) {
  Attack("build a map of panoramas", PanoramaWalk());
}

}  // namespace
}  // namespace waystone
