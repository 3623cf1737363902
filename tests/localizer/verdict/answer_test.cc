// SPDX-License-Identifier: Apache-2.0
#include "localizer/verdict/answer.h"

#include <gtest/gtest.h>

#include <string>

namespace waystone {
namespace {

// What is below a threshold must not read as if it reached it.
TEST(PercentText, IsTheShareRoundedDown) {
  for (int percent = 0; percent <= 100; ++percent) {
    EXPECT_EQ(PercentText(percent / 100.0), std::to_string(percent) + "%");
  }
  EXPECT_EQ(PercentText(0.8999), "89%");
  EXPECT_EQ(PercentText(0.89999999), "89%");
}

}  // namespace
}  // namespace waystone
