// SPDX-License-Identifier: Apache-2.0
#include "server/service/home_page.h"

#include <gtest/gtest.h>

#include <string>

namespace waystone {
namespace {

TEST(HomePage, EscapesNames) {
  const std::string page = HomePage({"<b>&\"x"}, "h<o>st");
  EXPECT_EQ(page.find("<b>&"), std::string::npos);
  EXPECT_EQ(page.find("h<o>st"), std::string::npos);
  EXPECT_NE(page.find("/v1/maps/%3Cb%3E%26%22x/localize"), std::string::npos);
}
}  // namespace
}  // namespace waystone
