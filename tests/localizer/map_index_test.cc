// SPDX-License-Identifier: Apache-2.0
#include "localizer/map_index.h"

#include <gtest/gtest.h>

#include <functional>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "tests/localizer/made_map.h"

namespace waystone {
namespace {

void ExpectDamaged(const std::function<void(MapData&)>& damage, const std::string& named) {
  MapData map = MadeMap();
  damage(map);
  try {
    MapIndex::Build(std::move(map));
    ADD_FAILURE() << "a map was taken whose " << named << " is wrong";
  } catch (const MapError& error) {
    EXPECT_EQ(error.code(), ErrorCode::kMapDamaged);
    EXPECT_NE(std::string(error.what()).find(named), std::string::npos) << error.what();
    EXPECT_NE(std::string(error.what()).find("waystone check"), std::string::npos);
  }
}

TEST(MapIndex, RefusesReferencesToWhatIsNotThere) {
  ExpectDamaged([](MapData& map) { map.keyframes[2].sequence = SequenceId{9}; }, "sequence 9");
  ExpectDamaged([](MapData& map) { map.planes[1].reference = KeyframeId{77}; }, "keyframe 77");
  ExpectDamaged([](MapData& map) { map.planes[1].views[0].keyframe = KeyframeId{0}; },
                "keyframe 0");
  ExpectDamaged([](MapData& map) { map.edges[0].a = PlaneId{12}; }, "plane 12");
  ExpectDamaged([](MapData& map) { map.edges[1].b = PlaneId{-3}; }, "plane -3");
}

TEST(MapIndex, RefusesPlanesWhoseFeaturesAndDescriptorsDisagree) {
  ExpectDamaged([](MapData& map) { map.planes[2].features.pop_back(); }, "plane 3");
  ExpectDamaged([](MapData& map) { map.planes[0].descriptors = Descriptors(128); }, "plane 1");
  ExpectDamaged(
      [](MapData& map) {
        map.planes[3].descriptors = Descriptors(32, std::vector<uint8_t>(32 * kMapFeatures));
      },
      "plane 4");
}

TEST(MapIndex, FindsByIdAndNothingForOtherIds) {
  const auto index = MadeIndex();
  for (int64_t id = 1; id <= 4; ++id) {
    ASSERT_NE(index->FindPlane(PlaneId{id}), nullptr);
    EXPECT_EQ(index->FindPlane(PlaneId{id})->id, PlaneId{id});
  }
  EXPECT_EQ(index->FindKeyframe(KeyframeId{6})->source, "rgb/60.jpg");
  EXPECT_EQ(index->FindSequence(SequenceId{1})->name, "walk");
  EXPECT_EQ(index->FindPlane(PlaneId{5}), nullptr);
  EXPECT_EQ(index->FindPlane(PlaneId{}), nullptr);
  EXPECT_EQ(index->FindKeyframe(KeyframeId{7}), nullptr);
  EXPECT_EQ(index->FindSequence(SequenceId{2}), nullptr);
}

TEST(MapIndex, NeighboursAreThoseOfTheEdgesAscendingFromBothEnds) {
  MapData map = MadeMap();
  map.edges.push_back(map.edges[0]);
  map.edges.back().a = PlaneId{2};
  map.edges.back().b = PlaneId{4};
  const auto index = MapIndex::Build(std::move(map));
  const auto ids = [](std::vector<int64_t> values) {
    std::vector<PlaneId> planes;
    for (int64_t value : values) planes.push_back(PlaneId{value});
    return planes;
  };
  EXPECT_EQ(index->Neighbours(PlaneId{1}), ids({2}));
  EXPECT_EQ(index->Neighbours(PlaneId{2}), ids({1, 3, 4}));
  EXPECT_EQ(index->Neighbours(PlaneId{3}), ids({2}));
  EXPECT_EQ(index->Neighbours(PlaneId{4}), ids({2}));
  EXPECT_TRUE(index->Neighbours(PlaneId{99}).empty());
}

TEST(MapIndex, EveryDescriptorIsThereWithItsPlane) {
  const MapData map = MadeMap();
  const auto index = MapIndex::Build(map);
  ASSERT_EQ(index->search().rows(), 4 * kMapFeatures);
  for (int p = 0; p < 4; ++p) {
    const Descriptors of_plane = index->DescriptorsOf(p);
    ASSERT_EQ(of_plane.rows(), kMapFeatures);
    for (int f = 0; f < kMapFeatures; ++f) {
      EXPECT_TRUE(
          std::equal(of_plane.row(f), of_plane.row(f) + 128, map.planes[p].descriptors.row(f)));
      const int row = p * kMapFeatures + f;
      EXPECT_EQ(index->PlaneOfRow(row), p);
      EXPECT_EQ(index->search().Rows(row, 1).data(),
                std::vector<uint8_t>(of_plane.row(f), of_plane.row(f) + 128));
    }
  }
}

TEST(MapIndex, TakesAMapWithoutAnything) {
  const auto index = MapIndex::Build({});
  EXPECT_EQ(index->search().rows(), 0);
  EXPECT_EQ(index->FindPlane(PlaneId{1}), nullptr);
}

TEST(MapIndex, TakesAPlaneWithoutFeatures) {
  MapData map = MadeMap();
  map.planes[1].features.clear();
  map.planes[1].descriptors = {};
  const auto index = MapIndex::Build(std::move(map));
  EXPECT_EQ(index->DescriptorsOf(1).rows(), 0);
  EXPECT_EQ(index->DescriptorsOf(2).rows(), kMapFeatures);
  EXPECT_EQ(index->PlaneOfRow(kMapFeatures), 2);
}

}  // namespace
}  // namespace waystone
