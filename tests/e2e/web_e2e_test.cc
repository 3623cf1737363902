// SPDX-License-Identifier: Apache-2.0
// The page, as the real server gives it, in a real browser.
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include "api/json.h"
#include "cli/system/child_process.h"
#include "tests/e2e/calibrated_maps.h"
#include "tests/e2e/drawn_plan.h"
#include "tests/e2e/shared_map.h"

namespace waystone {
namespace {

class WebTest : public testing::Test {
 protected:
  void SetUp() override {
    const char* wanted = std::getenv("BROWSER");
    if (wanted != nullptr && std::string(wanted) == "no") GTEST_SKIP() << "BROWSER=no";
  }

  // The address that a server says first.
  static std::string AddressOf(ChildProcess& server) {
    const std::string line = server.ReadLine();
    const size_t at = line.find("http://");
    EXPECT_NE(at, std::string::npos) << line;
    return at == std::string::npos ? "" : line.substr(at);
  }

  // Runs a script of tests/web, which says what failed.
  static void RunScript(const std::string& name, const std::vector<std::string>& arguments) {
    std::vector<std::string> command = {"/usr/bin/env", "node",
                                        std::string(WAYSTONE_SOURCE_DIR) + "/tests/web/" + name};
    command.insert(command.end(), arguments.begin(), arguments.end());
    ChildProcess node(command, true);
    std::string said;
    for (std::string out = node.ReadLine(); !out.empty(); out = node.ReadLine()) said += out + "\n";
    EXPECT_EQ(node.Wait(), 0) << said << "`make browser` installs what the test needs, "
                              << "and BROWSER=no leaves it out";
  }
};

TEST_F(WebTest, EveryViewInABrowser) {
  const std::filesystem::path room = FreshFolder() / "room.db";
  std::filesystem::copy_file(TheMap().map, room);
  ASSERT_EQ(RunWaystone({"name", room, "--keyframes", "1:3", "Door <&>"}).code, 0);
  ChildProcess server({WAYSTONE_PROGRAM, "serve", room, TheCorner().map, TheTurns(), "--port", "0"},
                      true);
  RunScript("page_test.mjs", {AddressOf(server), TheMap().inside, TheMap().elsewhere});
}

TEST_F(WebTest, AMapWithPosesInABrowser) {
  const std::filesystem::path folder = FreshFolder();
  const std::filesystem::path map = folder / "hall.db", plan = ThePosedHall().walk / "plan.png";
  const std::filesystem::path names = folder / "names.json";
  std::filesystem::copy_file(ThePosedHall().map, map);
  ASSERT_EQ(RunWaystone({"plan", map, plan, "--anchor", AnchorAt(0, 0), "--anchor", AnchorAt(13, 0),
                         "--anchor", AnchorAt(13, 12)})
                .code,
            0);
  ASSERT_EQ(RunWaystone({"name", map, "--polygon", "1,7 4,7 4,11 1,11", "Room <&>"}).code, 0);
  {
    ChildProcess server({WAYSTONE_PROGRAM, "serve", map, "--port", "0"}, true);
    RunScript("pose_page_test.mjs", {AddressOf(server), ThePosedHall().walk, names});
  }
  // The program takes the file that the page composed.
  const RunResult taken = RunWaystone({"name", map, "--from", names, "--json"});
  ASSERT_EQ(taken.code, 0) << taken.err;
  const Json places = Json::parse(taken.out)["places"];
  ASSERT_EQ(places.size(), 3u) << taken.out;
  EXPECT_EQ(places[0]["name"], "Area");
  EXPECT_EQ(places[0]["polygons"][0].size(), 4u);
  EXPECT_EQ(places[2]["name"], "Walls");
  EXPECT_FALSE(places[2]["planes"].empty());
  std::filesystem::remove_all(folder);
}

TEST_F(WebTest, PartsOfThePageWithoutABrowser) { RunScript("units_test.mjs", {}); }

}  // namespace
}  // namespace waystone
