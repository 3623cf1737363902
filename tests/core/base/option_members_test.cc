// SPDX-License-Identifier: Apache-2.0
#include "core/base/option_members.h"

#include <gtest/gtest.h>

#include <optional>
#include <string>
#include <vector>

namespace waystone {
namespace {

enum class Kind { kA, kB };

struct Whole {
  double ratio = 0.5;
  std::string name = "a";
  std::vector<double> steps = {1, 2};
  std::optional<int> limit;
  Kind kind = Kind::kA;

  static constexpr auto Fields(const auto& use) {
    return use(OptionField{"ratio", &Whole::ratio, AnyValue(), "", ""},
               OptionField{"name", &Whole::name, AnyValue(), "", ""},
               OptionField{"steps", &Whole::steps, AnyValue(), "", ""},
               OptionField{"limit", &Whole::limit, AnyValue(), "", ""},
               OptionField{"kind", &Whole::kind, AnyValue(), "", ""});
  }
};

struct Partial {
  int listed = 1;
  int forgotten = 2;

  static constexpr auto Fields(const auto& use) {
    return use(OptionField{"listed", &Partial::listed, AnyValue(), "", ""});
  }
};

struct Declared {
  int listed = 1;
  int of_this_query = 2;

  static constexpr int kUnlistedMembers = 1;
  static constexpr auto Fields(const auto& use) {
    return use(OptionField{"listed", &Declared::listed, AnyValue(), "", ""});
  }
};

template <class Group>
struct Nesting {
  int count = 3;
  Group group{};

  static constexpr auto Fields(const auto& use) {
    return use(OptionField{"count", &Nesting::count, AnyValue(), "", ""},
               OptionGroup{"group", &Nesting::group});
  }
};

TEST(OptionMembers, AreCounted) {
  EXPECT_EQ(options_internal::CountMembers<Whole>(), 5u);
  EXPECT_EQ(options_internal::CountMembers<Partial>(), 2u);
  EXPECT_EQ(options_internal::CountMembers<Nesting<Whole>>(), 2u);
}

TEST(OptionMembers, AMemberThatFieldsForgetsIsFound) {
  EXPECT_EQ(FindUnlistedMembers<Whole>("whole"), "");
  EXPECT_EQ(FindUnlistedMembers<Partial>("partial"), "partial lists 1 of its 2 members\n");
  EXPECT_EQ(FindUnlistedMembers<Declared>("declared"), "");
}

TEST(OptionMembers, GroupsAreLookedInto) {
  EXPECT_EQ(FindUnlistedMembers<Nesting<Whole>>("a"), "");
  EXPECT_EQ(FindUnlistedMembers<Nesting<Declared>>("a"), "");
  EXPECT_EQ(FindUnlistedMembers<Nesting<Nesting<Partial>>>("a"),
            "a.group.group lists 1 of its 2 members\n");
}

}  // namespace
}  // namespace waystone
