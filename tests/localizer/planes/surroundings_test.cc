// SPDX-License-Identifier: Apache-2.0
#include "localizer/planes/surroundings.h"

#include <gtest/gtest.h>

#include "tests/localizer/made_map.h"

namespace waystone {
namespace {

// One stretch of 26 keyframes, a plane that some of them saw, and links between them.
MapData StretchMap(const std::vector<int64_t>& saw, const std::vector<KeyframeLink>& links) {
  MapData map = MadeMap();
  map.links = links;
  const Keyframe keyframe = map.keyframes.back();
  for (int64_t id = 7; id <= 32; ++id) {
    map.keyframes.push_back(keyframe);
    map.keyframes.back().id = KeyframeId{id};
    map.keyframes.back().stretch = 9;
  }
  for (const int64_t id : saw) {
    map.planes[3].views.push_back({KeyframeId{id}, Eigen::Matrix3d::Identity(), 20});
  }
  return map;
}
std::shared_ptr<const MapIndex> Stretch(const std::vector<int64_t>& saw,
                                        const std::vector<KeyframeLink>& links = {}) {
  return MapIndex::Build(StretchMap(saw, links));
}

// The next stretch may be of another storey.
TEST(FollowEachOther, NotWhereAStretchEnds) {
  MapData map = StretchMap({}, {});
  EXPECT_TRUE(FollowEachOther(*MapIndex::Build(map), 9, 10));
  for (size_t k = 10; k < map.keyframes.size(); ++k) map.keyframes[k].stretch = 10;
  const auto index = MapIndex::Build(map);
  EXPECT_FALSE(FollowEachOther(*index, 9, 10));
  EXPECT_TRUE(FollowEachOther(*index, 10, 11));
  EXPECT_FALSE(KeyframesAreNear(*index, 9, 10));
}

TEST(KeyframesAreNear, WhereAPlaneWasFollowedFromOneToTheOther) {
  const auto followed = Stretch({7, 9, 12, 15, 18});
  EXPECT_TRUE(KeyframesAreNear(*followed, 6, 17));
  EXPECT_TRUE(KeyframesAreNear(*followed, 17, 6));
  EXPECT_FALSE(KeyframesAreNear(*followed, 7, 17));  // which didn't see it
  EXPECT_TRUE(KeyframesNearThird(*followed, 7).contains(17));
  const auto seen_twice = Stretch({7, 18});
  EXPECT_FALSE(KeyframesAreNear(*seen_twice, 6, 17));
  EXPECT_FALSE(KeyframesNearThird(*seen_twice, 6).contains(17));
  EXPECT_TRUE(KeyframesNearThird(*seen_twice, 6).contains(14));
}

// Each visit is linked with the one before it.
TEST(KeyframesAreNear, ByWayOfOtherVisits) {
  std::vector<KeyframeLink> links;
  for (int64_t id = 7; id < 32; id += 5) links.push_back({KeyframeId{id}, KeyframeId{id + 5}});
  const auto visits = Stretch({}, links);
  for (const int visit : {11, 16, 21, 26}) {
    EXPECT_TRUE(KeyframesAreNear(*visits, 6, visit)) << visit;
    EXPECT_TRUE(KeyframesAreNear(*visits, visit, 6)) << visit;
  }
  EXPECT_FALSE(KeyframesAreNear(*visits, 6, 31));  // by too many of them
  EXPECT_FALSE(KeyframesAreNear(*Stretch({}, {links.front()}), 6, 16));
}

TEST(KeyframesNearThird, IsMutual) {
  const auto index = Stretch({7, 9, 12, 25, 28}, {{KeyframeId{8}, KeyframeId{22}}});
  const int keyframes = static_cast<int>(index->map().keyframes.size());
  for (int a = 0; a < keyframes; ++a) {
    for (const int b : KeyframesNearThird(*index, a)) {
      EXPECT_TRUE(KeyframesNearThird(*index, b).contains(a)) << a << ", " << b;
    }
  }
}

}  // namespace
}  // namespace waystone
