// SPDX-License-Identifier: Apache-2.0
// The clients against the real server.
#include <gtest/gtest.h>

#include <cstdlib>
#include <string>

#include "tests/e2e/shared_map.h"

namespace waystone {
namespace {

// Debian's Python; the clients need nothing but its library.
TEST(Clients, PythonAndRosWithALiveServer) {
  const std::string command =
      "/usr/bin/python3 " WAYSTONE_SOURCE_DIR "/tests/e2e/clients.py " WAYSTONE_PROGRAM " " +
      TheMap().map.string() + " " + TheMap().inside.string() + " " + TheMap().elsewhere.string();
  EXPECT_EQ(std::system(command.c_str()), 0);  // NOLINT(cert-env33-c): made of our own paths
}

}  // namespace
}  // namespace waystone
