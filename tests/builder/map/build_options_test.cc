// SPDX-License-Identifier: Apache-2.0
#include "builder/build_options.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>
#include <string>
#include <type_traits>

#include "core/base/error.h"

namespace waystone {
namespace {

template <class Value>
constexpr bool kIsNumber = std::is_arithmetic_v<Value> && !std::is_same_v<Value, bool>;

// Message of the error that Check throws; empty when it throws none.
std::string Refusal(const BuildOptions& options) {
  try {
    options.Check();
  } catch (const MapError& error) {
    EXPECT_EQ(error.code(), ErrorCode::kBadOptions);
    return error.what();
  }
  return "";
}

TEST(BuildOptions, DefaultsAreInRange) { EXPECT_EQ(Refusal({}), ""); }

TEST(BuildOptions, EveryNumberOutOfItsRangeIsRefusedByItsFullName) {
  BuildOptions options;
  int tried = 0;
  VisitFields("", options, [&](const std::string& path, const auto& field, auto& value) {
    using Value = std::decay_t<decltype(value)>;
    if constexpr (kIsNumber<Value>) {
      if (!std::isfinite(field.range.low)) return;
      const Value before = value;
      value = static_cast<Value>(field.range.low - 1);
      const std::string refusal = Refusal(options);
      EXPECT_TRUE(refusal.starts_with(path + " is ")) << path << ": " << refusal;
      value = before;
      ++tried;
    }
  });
  EXPECT_GT(tried, 80);
}

TEST(BuildOptions, NumbersThatContradictEachOtherAreRefused) {
  BuildOptions options;
  options.keyframes.min_matches_last = options.keyframes.min_matches_before_last - 1;
  EXPECT_NE(Refusal(options).find("keyframes.min_matches_last"), std::string::npos);
  options = {};
  options.planes.min_features_unconfirmed = options.planes.min_features - 1;
  EXPECT_NE(Refusal(options).find("min_features_unconfirmed"), std::string::npos);
  options = {};
  options.planes.rotation.max_focal = options.planes.rotation.min_focal;
  EXPECT_NE(Refusal(options).find("max_focal"), std::string::npos);
  options = {};
  options.appearance.describe.image_width = 5;
  EXPECT_NE(Refusal(options).find("describe.image_width is 5"), std::string::npos);
}

TEST(BuildOptions, FieldsAreListedOnceAndExplained) {
  BuildOptions options;
  std::set<std::string> paths;
  VisitFields("", options, [&](const std::string& path, const auto& field, const auto&) {
    EXPECT_TRUE(paths.insert(path).second) << path;
    EXPECT_GT(field.help.size(), 5U) << path;
  });
}

}  // namespace
}  // namespace waystone
