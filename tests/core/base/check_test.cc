// SPDX-License-Identifier: Apache-2.0
#include "core/base/check.h"

#include <gtest/gtest.h>

#include <string>

namespace waystone {
namespace {

TEST(Check, PassesWhenTheConditionHolds) { EXPECT_NO_THROW(WS_CHECK(1 + 1 == 2, "arithmetic")); }

TEST(Check, NamesFileLineConditionAndMessage) {
  const int line = __LINE__ + 2;
  try {
    WS_CHECK(1 > 2, "one is " + std::to_string(1));
    FAIL() << "nothing was thrown";
  } catch (const CheckFailure& failure) {
    const std::string what = failure.what();
    EXPECT_NE(what.find("check_test.cc:" + std::to_string(line)), std::string::npos) << what;
    EXPECT_NE(what.find("1 > 2"), std::string::npos) << what;
    EXPECT_NE(what.find("one is 1"), std::string::npos) << what;
  }
}

TEST(Check, EvaluatesTheConditionOnceAndTheMessageOnlyOnFailure) {
  int conditions = 0;
  int messages = 0;
  const auto message = [&] {
    ++messages;
    return std::string("message");
  };
  WS_CHECK(++conditions > 0, message());
  EXPECT_EQ(conditions, 1);
  EXPECT_EQ(messages, 0);
  EXPECT_THROW(WS_CHECK(++conditions < 0, message()), CheckFailure);
  EXPECT_EQ(conditions, 2);
  EXPECT_EQ(messages, 1);
}

TEST(Check, IsOneStatement) {
  bool otherwise = false;
  if (otherwise)
    WS_CHECK(false, "not reached");
  else
    otherwise = true;
  EXPECT_TRUE(otherwise);
}

}  // namespace
}  // namespace waystone
