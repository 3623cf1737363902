// SPDX-License-Identifier: Apache-2.0
#include "bench/accuracy/recall_sets.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "bench/accuracy/common.h"
#include "core/base/error.h"

namespace waystone::bench {
namespace {

RecallSet SetOf(const std::string& name, int queries) {
  RecallSet set{name, {}, {}, {}, {}};
  for (int i = 0; i < queries; ++i) set.queries.emplace_back(name + std::to_string(i));
  return set;
}

TEST(ReadRecallSets, WantsSomeData) {
  const ScratchFolder nothing;
  EXPECT_THROW(ReadRecallSets(nothing.path()), MapError);
}

TEST(ChooseForeign, TakesAtMostAsManyAsAskedFor) {
  for (int queries = 1; queries < 200; ++queries) {
    const std::vector<RecallSet> sets{SetOf("own", 50), SetOf("other", queries)};
    const auto chosen = ChooseForeign(sets, sets[0], 48);
    EXPECT_EQ(chosen.front(), "other0");
    EXPECT_LE(chosen.size(), 48U);
    EXPECT_GE(chosen.size(), std::min<size_t>(queries, 24));
  }
}

TEST(ChooseForeign, LeavesOutSetsOfTheSamePlace) {
  const std::vector<RecallSet> sets{SetOf("tower-floor3", 5), SetOf("tower-floor4", 5)};
  EXPECT_TRUE(ChooseForeign(sets, sets[0], 48).empty());
}

}  // namespace
}  // namespace waystone::bench
