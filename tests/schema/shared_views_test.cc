// SPDX-License-Identifier: Apache-2.0
#include "schema/layers/planes/shared_views.h"

#include <gtest/gtest.h>

namespace waystone {
namespace {

// A plane with views of every `step`-th of so many keyframes.
Plane SeenInEvery(int step, int keyframes) {
  Plane plane;
  for (int i = 0; i < keyframes; i += step) plane.views.push_back({.keyframe = KeyframeId{i + 1}});
  return plane;
}

TEST(SharedViews, AreOfTheKeyframesThatSawBoth) {
  const Plane m = SeenInEvery(2, 60);
  const Plane n = SeenInEvery(3, 60);
  const std::vector<SharedView> shared = SharedViews(m, n);
  ASSERT_EQ(shared.size(), 10U);
  for (size_t i = 0; i < shared.size(); ++i) {
    EXPECT_EQ(shared[i].of_m->keyframe, KeyframeId{static_cast<int64_t>(6 * i + 1)});
    EXPECT_EQ(shared[i].of_n->keyframe, shared[i].of_m->keyframe);
  }
  EXPECT_TRUE(SharedViews(m, Plane{}).empty());
}

TEST(SharedViews, OfACameraThatStoodStillAreAFewSpreadOverAll) {
  const Plane m = SeenInEvery(1, 5000);
  const std::vector<SharedView> shared = SharedViews(m, m);
  ASSERT_EQ(shared.size(), 20U);
  EXPECT_EQ(shared.front().of_m->keyframe, KeyframeId{1});
  EXPECT_EQ(shared.back().of_m->keyframe, KeyframeId{5000});
  for (size_t i = 1; i < shared.size(); ++i) {
    EXPECT_LT(shared[i - 1].of_m->keyframe, shared[i].of_m->keyframe);
  }
}

}  // namespace
}  // namespace waystone
