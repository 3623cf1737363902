// SPDX-License-Identifier: Apache-2.0
#include "core/base/ids.h"

#include <gtest/gtest.h>

#include <concepts>
#include <set>
#include <type_traits>
#include <unordered_set>

namespace waystone {
namespace {

template <class A, class B>
concept Comparable = requires(A a, B b) {
  a == b;
};

static_assert(!std::convertible_to<KeyframeId, PlaneId>);
static_assert(!std::constructible_from<KeyframeId, PlaneId>);
static_assert(!std::assignable_from<KeyframeId&, SequenceId>);
static_assert(!std::convertible_to<KeyframeId, int64_t>);
static_assert(!std::convertible_to<int64_t, KeyframeId>);
static_assert(Comparable<PlaneId, PlaneId>);
static_assert(std::is_trivially_copyable_v<PlaneId>);
static_assert(sizeof(PlaneId) == sizeof(int64_t));

TEST(Ids, OnlyPositiveOnesAreValid) {
  EXPECT_FALSE(PlaneId{});
  EXPECT_FALSE(PlaneId{0});
  EXPECT_FALSE(PlaneId{-1});
  EXPECT_TRUE(PlaneId{1});
  EXPECT_TRUE(PlaneId{int64_t{1} << 62});
}

TEST(Ids, AreOrderedByTheirValue) {
  EXPECT_EQ(KeyframeId{3}, KeyframeId{3});
  EXPECT_NE(KeyframeId{3}, KeyframeId{4});
  EXPECT_LT(KeyframeId{3}, KeyframeId{4});
  EXPECT_GT(KeyframeId{3}, KeyframeId{-4});
  const std::set<KeyframeId> sorted = {KeyframeId{9}, KeyframeId{1}, KeyframeId{5}};
  EXPECT_EQ(sorted.begin()->value, 1);
  EXPECT_EQ(sorted.rbegin()->value, 9);
}

TEST(Ids, AreKeysOfHashedContainers) {
  std::unordered_set<PlaneId> ids;
  for (int64_t value = 1; value <= 1000; ++value) {
    ids.insert(PlaneId{value});
    ids.insert(PlaneId{value});
  }
  EXPECT_EQ(ids.size(), 1000u);
  EXPECT_TRUE(ids.contains(PlaneId{1000}));
  EXPECT_FALSE(ids.contains(PlaneId{1001}));
}

}  // namespace
}  // namespace waystone
