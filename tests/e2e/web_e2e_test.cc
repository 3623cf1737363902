// SPDX-License-Identifier: Apache-2.0
// The page, as the real server gives it, in a real browser.
#include <gtest/gtest.h>

#include <cstdlib>
#include <string>

#include "cli/child_process.h"
#include "tests/e2e/calibrated_maps.h"
#include "tests/e2e/shared_map.h"

namespace waystone {
namespace {

constexpr int kMissing =
    77;  // page_test.mjs's exit code when Node's packages or Chromium aren't there

TEST(WebTest, EveryViewInABrowser) {
  if (std::system("command -v node >/dev/null") != 0) {  // NOLINT(cert-env33-c): a constant
    GTEST_SKIP() << "Node is missing; the page is tested where it is installed";
  }
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
  const int code = browser.Wait();
  if (code == kMissing) GTEST_SKIP() << "the page isn't tested: " << said;
  EXPECT_EQ(code, 0) << said;
}

}  // namespace
}  // namespace waystone
