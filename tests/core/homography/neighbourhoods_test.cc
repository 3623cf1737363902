// SPDX-License-Identifier: Apache-2.0
#include "core/homography/neighbourhoods.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>

#include "tests/core/homography/made_views.h"

namespace waystone {
namespace {

TEST(Neighbourhoods, AreThoseOfSorting) {
  Random random(1);
  for (int count : {2, 3, 15, 120}) {
    std::vector<Eigen::Vector2d> points;
    for (int i = 0; i < count; ++i) points.push_back(RandomPoint(random));
    for (int k : {1, 4, 14, 200}) {
      const Neighbourhoods neighbourhoods(points, k);
      for (int i = 0; i < count; ++i) {
        std::vector<int> others(count);
        std::iota(others.begin(), others.end(), 0);
        others.erase(others.begin() + i);
        std::stable_sort(others.begin(), others.end(), [&](int a, int b) {
          return (points[a] - points[i]).squaredNorm() < (points[b] - points[i]).squaredNorm();
        });
        others.resize(std::min<size_t>(k, others.size()));
        const auto found = neighbourhoods.of(i);
        EXPECT_EQ(std::vector<int>(found.begin(), found.end()), others) << count << " " << k;
      }
    }
  }
}

TEST(Neighbourhoods, OfEqualPointsTheLowerComesFirst) {
  const std::vector<Eigen::Vector2d> points(6, Eigen::Vector2d(3, 4));
  const Neighbourhoods neighbourhoods(points, 3);
  const auto found = neighbourhoods.of(1);
  EXPECT_EQ(std::vector<int>(found.begin(), found.end()), (std::vector<int>{0, 2, 3}));
}

TEST(Neighbourhoods, OfNoneAndOfOne) {
  EXPECT_NO_THROW(Neighbourhoods({}, 5));
  const std::vector<Eigen::Vector2d> one = {Eigen::Vector2d(1, 2)};
  EXPECT_TRUE(Neighbourhoods(one, 5).of(0).empty());
}

}  // namespace
}  // namespace waystone
