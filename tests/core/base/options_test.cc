// SPDX-License-Identifier: Apache-2.0
#include "core/base/options.h"

#include <gtest/gtest.h>

#include <limits>
#include <map>
#include <string>

namespace waystone {
namespace {

struct Inner {
  double ratio = 0.5;
  bool mutual = true;

  static constexpr auto Fields(const auto& use) {
    return use(OptionField{"ratio", &Inner::ratio, OpenLow(0, 1), "", "A ratio."},
               OptionField{"mutual", &Inner::mutual, AnyValue(), "", "Both ways."});
  }
};

struct Outer {
  int count = 3;
  Inner inner{};
  float length_px = 2.5F;

  static constexpr auto Fields(const auto& use) {
    return use(OptionField{"count", &Outer::count, Closed(1, 10), "", "How many."},
               OptionGroup{"inner", &Outer::inner},
               OptionField{"length_px", &Outer::length_px, Above(0), "px", "How long.",
                           OptionUse::kInternal});
  }
};

std::string ErrorOf(const Outer& options) {
  try {
    CheckFields("outer", options);
    return "";
  } catch (const MapError& error) {
    EXPECT_EQ(error.code(), ErrorCode::kBadOptions);
    return error.what();
  }
}

TEST(Options, AreVisitedInOrderWithTheirGroups) {
  Outer options;
  std::string names;
  VisitFields("", options, [&](const std::string& path, const auto& field, const auto&) {
    names += path + "[" + std::string(field.unit) + "] ";
  });
  EXPECT_EQ(names, "count[] inner.ratio[] inner.mutual[] length_px[px] ");
}

TEST(Options, NumbersOutOfRangeAreNamedWithTheirRange) {
  EXPECT_EQ(ErrorOf({}), "");
  EXPECT_EQ(ErrorOf({.count = 11}), "outer.count is 11; it must be between 1 and 10");
  EXPECT_EQ(ErrorOf({.inner = {.ratio = 0}}),
            "outer.inner.ratio is 0; it must be above 0 and at most 1");
  EXPECT_EQ(ErrorOf({.length_px = 0}), "outer.length_px is 0; it must be above 0 px");
  EXPECT_NE(ErrorOf({.inner = {.ratio = std::numeric_limits<double>::quiet_NaN()}}), "");
}

TEST(Options, TakeTextAndLists) {
  std::string text;
  ParseOptionValue("o.text", "a=b, c", &text);
  EXPECT_EQ(text, "a=b, c");
  std::vector<double> numbers = {7};
  ParseOptionValue("o.numbers", "0,2.5,-3", &numbers);
  EXPECT_EQ(numbers, (std::vector<double>{0, 2.5, -3}));
  EXPECT_THROW(ParseOptionValue("o.numbers", "1,,2", &numbers), MapError);
  double number = 0;
  float small = 0;
  for (const char* other : {"inf", "-inf", "nan", "1e999"}) {
    EXPECT_THROW(ParseOptionValue("o.number", other, &number), MapError) << other;
    EXPECT_THROW(ParseOptionValue("o.small", other, &small), MapError) << other;
    EXPECT_THROW(ParseOptionValue("o.numbers", std::string("1,") + other, &numbers), MapError);
  }
}

TEST(Options, AreSetByName) {
  Outer options;
  EXPECT_TRUE(SetField("", options, "inner.ratio", "0.25"));
  EXPECT_TRUE(SetField("", options, "inner.mutual", "false"));
  EXPECT_TRUE(SetField("", options, "count", "7"));
  EXPECT_FALSE(SetField("", options, "inner", "7"));
  EXPECT_FALSE(SetField("", options, "ratio", "7"));
  EXPECT_EQ(options.inner.ratio, 0.25);
  EXPECT_FALSE(options.inner.mutual);
  EXPECT_EQ(options.count, 7);
  for (const char* text : {"", "7x", "1.5", "99999999999", " 7"}) {
    EXPECT_THROW(SetField("", options, "count", text), MapError) << text;
  }
  EXPECT_THROW(SetField("", options, "inner.mutual", "1"), MapError);
}

}  // namespace
}  // namespace waystone
