// SPDX-License-Identifier: Apache-2.0
// The page, as the real server gives it, in a real browser.
#include <gtest/gtest.h>

#include <cstdlib>
#include <string>

#include "cli/system/child_process.h"
#include "tests/e2e/calibrated_maps.h"
#include "tests/e2e/shared_map.h"

namespace waystone {
namespace {

TEST(WebTest, EveryViewInABrowser) {
  const char* wanted = std::getenv("BROWSER");
  if (wanted != nullptr && std::string(wanted) == "no") GTEST_SKIP() << "BROWSER=no";
  ChildProcess server(
      {WAYSTONE_PROGRAM, "serve", TheMap().map, TheCorner().map, TheTurns(), "--port", "0"}, true);
  const std::string line = server.ReadLine();
  const size_t at = line.find("http://");
  ASSERT_NE(at, std::string::npos) << line;
  ChildProcess browser(
      {"/usr/bin/env", "node", std::string(WAYSTONE_SOURCE_DIR) + "/tests/web/page_test.mjs",
       line.substr(at), TheMap().inside, TheMap().elsewhere},
      true);
  std::string said;
  for (std::string out = browser.ReadLine(); !out.empty(); out = browser.ReadLine()) {
    said += out + "\n";
  }
  EXPECT_EQ(browser.Wait(), 0) << said << "`make browser` installs what the test needs, "
                               << "and BROWSER=no leaves it out";
}

}  // namespace
}  // namespace waystone
