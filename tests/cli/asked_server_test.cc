// SPDX-License-Identifier: Apache-2.0
// Addresses of servers that commands refuse before they ask.
#include "cli/commands/asked_server.h"

#include <gtest/gtest.h>

#include <string>

#include "core/base/error.h"

namespace waystone {
namespace {

TEST(AskedServers, AddressesAndPortsThatThereCannotBeAreRefused) {
  for (const std::string url :
       {"ftp://host", "host", "http://", "http://localhost:99999999999", "http://localhost:65536",
        "http://localhost:0", "http://localhost:", "http://localhost:x", "http://[::1]:70000/path",
        "https://localhost:-1"}) {
    try {
      CheckServerFlags({.url = url, .token_file = ""});
      ADD_FAILURE() << url;
    } catch (const MapError& error) {
      EXPECT_EQ(error.code(), ErrorCode::kUsage) << url;
      EXPECT_EQ(std::string(error.what()), "--server " + url +
                                               " is no address of a server; give http://HOST:PORT "
                                               "with a port from 1 to 65535");
    }
    EXPECT_THROW(AskServer({.url = url, .token_file = ""}, "-", "photo", "bytes"), MapError) << url;
  }
  for (const std::string url : {"http://localhost", "https://maps:443/waystone/", "http://[::1]",
                                "http://[::1]:65535/x:y", "http://10.0.0.1:1"}) {
    EXPECT_NO_THROW(CheckServerFlags({.url = url, .token_file = ""})) << url;
  }
}

}  // namespace
}  // namespace waystone
