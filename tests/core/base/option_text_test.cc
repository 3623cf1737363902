// SPDX-License-Identifier: Apache-2.0
#include "core/base/option_text.h"

#include <gtest/gtest.h>

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace waystone {
namespace {

enum class Colour { kRed, kGreen };
std::string_view NameOf(Colour colour) { return colour == Colour::kRed ? "red" : "green"; }

TEST(OptionText, IsWhatParsesBack) {
  EXPECT_EQ(ToOptionText(0.8), "0.8");
  EXPECT_EQ(ToOptionText(0.1F), "0.1");
  EXPECT_EQ(ToOptionText(-3), "-3");
  EXPECT_EQ(ToOptionText(1e-9), "1e-09");
  EXPECT_EQ(ToOptionText(true), "true");
  EXPECT_EQ(ToOptionText(Colour::kGreen), "green");
  EXPECT_EQ(ToOptionText(std::string("map")), "map");
  EXPECT_EQ(ToOptionText(std::optional<double>()), "none");
  EXPECT_EQ(ToOptionText(std::optional<double>(2.5)), "2.5");
  EXPECT_EQ(ToOptionText(std::vector<double>{0, 2, 2.5}), "0,2,2.5");
}

TEST(EditDistance, CountsLetters) {
  EXPECT_EQ(EditDistance("", "abc"), 3U);
  EXPECT_EQ(EditDistance("kitten", "sitting"), 3U);
  EXPECT_EQ(EditDistance("serve", "serve"), 0U);
}

TEST(NearestName, IsTheOneThatWasMeant) {
  const std::vector<std::string> names{"features.max_features", "planes.fusion.min_votes",
                                       "planes.min_features", "planes.match.max_ratio"};
  EXPECT_EQ(NearestName("planes.fusoin.min_votes", names), "planes.fusion.min_votes");
  EXPECT_EQ(NearestName("min_votes", names), "planes.fusion.min_votes");
  EXPECT_EQ(NearestName("planes.max_ratio", names), "planes.match.max_ratio");
  EXPECT_EQ(NearestName("planes.minfeatures", names), "planes.min_features");
  EXPECT_EQ(NearestName("x", {}), "");
  EXPECT_EQ(NearestName("foo", {"appearance.signature.rows"}), "");
  EXPECT_EQ(NearestName("planes.zzzzzzzzz", names), "");
}

}  // namespace
}  // namespace waystone
