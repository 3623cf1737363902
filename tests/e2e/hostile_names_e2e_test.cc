// SPDX-License-Identifier: Apache-2.0
// A map, a query log and photos whose names were chosen to drive the terminal of whoever looks at
// them: the program prints them, on the lines that they belong to, and nothing that acts.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

#include "api/json.h"
#include "schema/file/map_store.h"
#include "tests/e2e/shared_map.h"

namespace waystone {
namespace {

namespace fs = std::filesystem;

// Clears the screen, sets the window's title, starts a line that looks like ours, hides what comes
// behind, turns the text around, and ends a line in three more ways.
const std::string kHostile =
    "\x1b[2J\x1b]0;x\x07\r\nwaystone: no damage "
    "found\x1b[8m\u009b31m\x7f\b\u202egpj.\u2066\u2028\u0085z";
const std::string kShown =
    "\\u001b[2J\\u001b]0;x\\u0007\\u000d\\u000awaystone: no damage "
    "found\\u001b[8m\\u009b31m\\u007f\\u0008\\u202egpj.\\u2066\\u2028\\u0085z";

class HostileNames : public testing::Test {
 protected:
  HostileNames() {
    MapData map = ReadMap(TheMap().map);
    map.info.name = kHostile;
    map.info.program = kHostile;
    for (Sequence& sequence : map.sequences) sequence.name = kHostile;
    for (Keyframe& keyframe : map.keyframes) keyframe.source = kHostile + keyframe.source;
    WriteMap(map, map_, {});
  }
  ~HostileNames() override { fs::remove_all(folder_); }

  static size_t Lines(const std::string& text) {
    return static_cast<size_t>(std::ranges::count(text, '\n'));
  }

  // Both outputs hold no character that acts on a terminal.
  static void ExpectHarmless(const RunResult& result) {
    const std::string text = result.out + result.err;
    for (const char c : text) {
      const auto byte = static_cast<unsigned char>(c);
      ASSERT_TRUE((byte >= 0x20 && byte != 0x7f) || c == '\n' || c == '\t') << text;
    }
    for (const char* character : {"\u009b", "\u0085", "\u202e", "\u2066", "\u2028"}) {
      EXPECT_EQ(text.find(character), std::string::npos) << text;
    }
  }

  // The same on the hostile map as on the sound one, but for names.
  RunResult Run(std::vector<std::string> arguments, bool shows) {
    std::vector<std::string> sound = arguments;
    std::ranges::replace(arguments, "MAP", map_.string());
    std::ranges::replace(sound, "MAP", TheMap().map.string());
    SCOPED_TRACE(arguments[0]);
    RunResult result = RunWaystone(arguments);
    const RunResult usual = RunWaystone(sound);
    ExpectHarmless(result);
    EXPECT_EQ(result.code, usual.code) << result.err;
    EXPECT_EQ(Lines(result.out), Lines(usual.out)) << result.out;
    EXPECT_EQ(Lines(result.err), Lines(usual.err)) << result.err;
    EXPECT_EQ(result.out.find(kShown) != std::string::npos, shows) << result.out;
    return result;
  }

  const fs::path folder_ = FreshFolder();
  const fs::path map_ = folder_ / "room.db";
};

TEST_F(HostileNames, OfAMapArePrintedHarmlessly) {
  Run({"info", "MAP"}, true);
  Run({"check", "MAP"}, false);
  Run({"localize", "MAP", TheMap().inside}, true);
  Run({"audit", "MAP"}, false);
  const RunResult json = Run({"localize", "MAP", TheMap().inside, "--json"}, false);
  EXPECT_TRUE(Json::parse(json.out)["keyframe"]["source"].get<std::string>().starts_with(kHostile))
      << "JSON keeps the name";
}

TEST_F(HostileNames, OfDamagedMapsArePrintedHarmlessly) {
  std::string bytes = ReadFile(map_);
  for (size_t at = 0; (at = bytes.find("found\x1b[8m", at)) != std::string::npos; ++at) {
    bytes[at] = '\x1b';
  }
  WriteFile(map_, bytes);
  const RunResult result = RunWaystone({"check", map_});
  EXPECT_EQ(result.code, 3);
  ExpectHarmless(result);
}

TEST_F(HostileNames, OfPhotosArePrintedHarmlessly) {
  const fs::path photo = folder_ / (kHostile + ".jpg");
  fs::copy_file(TheMap().inside, photo);
  const RunResult found = RunWaystone({"localize", map_, photo});
  ExpectHarmless(found);
  EXPECT_EQ(Lines(found.out), 1U) << found.out;
  WriteFile(photo, "no image");
  const RunResult refused = RunWaystone({"localize", map_, photo});
  ExpectHarmless(refused);
  EXPECT_EQ(Lines(refused.out + refused.err), 1U) << refused.out << refused.err;
  const RunResult missing = RunWaystone({"info", photo});
  EXPECT_EQ(missing.code, 3);
  ExpectHarmless(missing);
  EXPECT_EQ(Lines(missing.err), 1U) << missing.err;
}

TEST_F(HostileNames, OfAQueryLogArePrintedHarmlessly) {
  const fs::path log = folder_ / "log";
  fs::create_directory(log);
  fs::copy_file(TheMap().inside, log / "a.jpg");
  Json line = Json::parse(R"({"map": "room", "request": {}, "answer": {"keyframe": {}}})");
  line["id"] = line["answer"]["verdict"] = line["answer"]["keyframe"]["sequence"] =
      line["answer"]["keyframe"]["source"] = kHostile;
  line["images"] = {{{"name", kHostile}, {"file", "a.jpg"}}};
  WriteFile(log / "queries.jsonl", Dump(line) + "\n");
  const RunResult changed = RunWaystone({"replay", log, map_});
  EXPECT_EQ(changed.code, 0) << changed.err;
  ExpectHarmless(changed);
  EXPECT_EQ(Lines(changed.out), 2U) << changed.out;
  line["images"][0]["file"] = kHostile;
  WriteFile(log / "queries.jsonl", Dump(line) + "\n");
  const RunResult refused = RunWaystone({"replay", log, map_});
  EXPECT_EQ(refused.code, 3);
  ExpectHarmless(refused);
  EXPECT_EQ(Lines(refused.out + refused.err), 1U) << refused.err;
}

}  // namespace
}  // namespace waystone
