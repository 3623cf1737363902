// SPDX-License-Identifier: Apache-2.0
#include "core/base/error.h"

#include <gtest/gtest.h>

#include <map>
#include <regex>
#include <set>
#include <string>
#include <vector>

namespace waystone {
namespace {

// kInternal is the last one: a code added behind it would go unseen by these tests, which is why
// the enum keeps it there.
std::vector<ErrorCode> AllCodes() {
  std::vector<ErrorCode> codes;
  for (int value = 0; value <= static_cast<int>(ErrorCode::kInternal); ++value) {
    codes.push_back(static_cast<ErrorCode>(value));
  }
  return codes;
}

TEST(ErrorTable, NamesAreUniqueAndSnakeCase) {
  const std::regex snake_case("[a-z]+(_[a-z]+)*");
  std::set<std::string_view> names;
  for (ErrorCode code : AllCodes()) {
    const ErrorInfo& info = InfoOf(code);
    EXPECT_TRUE(std::regex_match(std::string(info.name), snake_case)) << info.name;
    EXPECT_TRUE(names.insert(info.name).second) << info.name << " names two codes";
  }
  EXPECT_EQ(names.size(), AllCodes().size());
}

TEST(ErrorTable, TitlesAreUniqueShortSentences) {
  std::set<std::string_view> titles;
  for (ErrorCode code : AllCodes()) {
    const ErrorInfo& info = InfoOf(code);
    ASSERT_FALSE(info.title.empty()) << info.name;
    EXPECT_LT(info.title.size(), 60u) << info.name;
    EXPECT_TRUE(std::isupper(static_cast<unsigned char>(info.title.front()))) << info.title;
    EXPECT_NE(info.title.back(), '.') << info.title;
    EXPECT_TRUE(titles.insert(info.title).second) << info.title << " is two codes' title";
  }
}

TEST(ErrorTable, ExitCodesAreThoseOfTheProgram) {
  const std::map<ErrorCode, int> others = {{ErrorCode::kUsage, 2},
                                           {ErrorCode::kBadOptions, 2},
                                           {ErrorCode::kUnreadableFrames, 4},
                                           {ErrorCode::kRegistryUnavailable, 6},
                                           {ErrorCode::kStoreUnavailable, 6},
                                           {ErrorCode::kInterrupted, 130},
                                           {ErrorCode::kInternal, 5}};
  for (ErrorCode code : AllCodes()) {
    const auto other = others.find(code);
    EXPECT_EQ(InfoOf(code).exit_code, other == others.end() ? 3 : other->second)
        << InfoOf(code).name;
  }
}

TEST(ErrorTable, EveryHttpStatusIsAnErrorAndTheWellKnownOnesAreRight) {
  for (ErrorCode code : AllCodes()) {
    EXPECT_GE(InfoOf(code).http_status, 400) << InfoOf(code).name;
    EXPECT_LE(InfoOf(code).http_status, 599) << InfoOf(code).name;
  }
  EXPECT_EQ(InfoOf(ErrorCode::kBadRequest).http_status, 400);
  EXPECT_EQ(InfoOf(ErrorCode::kNotFound).http_status, 404);
  EXPECT_EQ(InfoOf(ErrorCode::kMethodNotAllowed).http_status, 405);
  EXPECT_EQ(InfoOf(ErrorCode::kFileExists).http_status, 409);
  EXPECT_EQ(InfoOf(ErrorCode::kPayloadTooLarge).http_status, 413);
  EXPECT_EQ(InfoOf(ErrorCode::kImageTooLarge).http_status, 413);
  EXPECT_EQ(InfoOf(ErrorCode::kUnsupportedMedia).http_status, 415);
  EXPECT_EQ(InfoOf(ErrorCode::kBadImage).http_status, 422);
  EXPECT_EQ(InfoOf(ErrorCode::kBusy).http_status, 429);
  EXPECT_EQ(InfoOf(ErrorCode::kInternal).http_status, 500);
}

// Clients tell errors apart by these: a name that is released never changes.
TEST(ErrorTable, NamesThatClientsRelyOn) {
  EXPECT_EQ(InfoOf(ErrorCode::kBadImage).name, "bad_image");
  EXPECT_EQ(InfoOf(ErrorCode::kImageTooLarge).name, "image_too_large");
  EXPECT_EQ(InfoOf(ErrorCode::kNotAMap).name, "not_a_map");
  EXPECT_EQ(InfoOf(ErrorCode::kMapDamaged).name, "map_damaged");
  EXPECT_EQ(InfoOf(ErrorCode::kMapVersion).name, "map_version");
  EXPECT_EQ(InfoOf(ErrorCode::kNotFound).name, "not_found");
  EXPECT_EQ(InfoOf(ErrorCode::kBusy).name, "busy");
  EXPECT_EQ(InfoOf(ErrorCode::kPayloadTooLarge).name, "payload_too_large");
}

TEST(ErrorTable, AValueThatIsNoCodeCountsAsABugOfOurs) {
  EXPECT_EQ(InfoOf(static_cast<ErrorCode>(1000)).name, "internal");
}

TEST(MapError, KeepsCodeAndMessage) {
  try {
    throw MapError(ErrorCode::kNotAMap, "x.db has 3 bytes; give a map");
  } catch (const std::exception& error) {
    EXPECT_STREQ(error.what(), "x.db has 3 bytes; give a map");
    const auto* map_error = dynamic_cast<const MapError*>(&error);
    ASSERT_NE(map_error, nullptr);
    EXPECT_EQ(map_error->code(), ErrorCode::kNotAMap);
  }
}

}  // namespace
}  // namespace waystone
