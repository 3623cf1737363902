// SPDX-License-Identifier: Apache-2.0
#include "localizer/index/map_index.h"

#include <gtest/gtest.h>

#include <functional>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "core/base/random.h"
#include "localizer/localizer.h"
#include "schema/layers/planes/index_features.h"
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
  const auto ids = [](const std::vector<int64_t>& values) {
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

// The made map with a plane of random features that is large enough for an index.
MapData LargeMap() {
  MapData map = MadeMap();
  Plane plane = map.planes.back();
  plane.id = PlaneId{5};
  Random random(3);
  std::vector<uint8_t> row(128);
  for (int i = 0; i < 9000; ++i) {
    plane.features.push_back(plane.features[i % kMapFeatures]);
    for (uint8_t& byte : row) byte = random.Below(60);
    plane.descriptors.Append(row.data());
  }
  map.planes.push_back(std::move(plane));
  return map;
}

std::vector<int> InliersOf(const Answer& answer) {
  std::vector<int> inliers;
  for (const RecognisedPlane& plane : answer.planes.recognised) inliers.push_back(plane.inliers);
  return inliers;
}

TEST(MapIndex, AStoredIndexAndOneMadeOnOpeningAnswerTheSame) {
  MapData map = LargeMap();
  const auto made = MapIndex::Build(map);
  map.index = IndexFeatures(map);
  ASSERT_TRUE(map.index);
  const auto stored = MapIndex::Build(map);
  EXPECT_EQ(stored->search().lists(), map.index->centres.rows());
  EXPECT_EQ(made->search().lists(), stored->search().lists());
  EXPECT_FALSE(stored->map().index) << "it is in memory twice";
  LocalizeOptions exhaustive;
  exhaustive.planes.probes = stored->search().lists();
  for (uint64_t seed = 1; seed <= 5; ++seed) {
    const Features query = QueryOf(map, {1, 2}, PoseOf(1.5), 200, seed);
    const Answer answer = LocalizeFeatures(*stored, query, {});
    EXPECT_EQ(answer.verdict, Verdict::kLocalized);
    EXPECT_EQ(InliersOf(LocalizeFeatures(*made, query, {})), InliersOf(answer));
    EXPECT_EQ(InliersOf(LocalizeFeatures(*stored, query, exhaustive)), InliersOf(answer));
  }
}

TEST(MapIndex, RefusesAnIndexOfAnotherMap) {
  ExpectDamaged(
      [](MapData& map) {
        map.index = IndexFeatures(map, {.min_rows = 1});
        map.index->list_of_row[5] = 60000;
      },
      "row 5");
  ExpectDamaged(
      [](MapData& map) {
        map.index = IndexFeatures(map, {.min_rows = 1});
        map.index->list_of_row.pop_back();
      },
      "280 features");
}

TEST(MapIndex, MapsOfBinaryFeaturesAreIndexedToo) {
  MapData map = LargeMap();
  map.info.feature_type = FeatureType::kOrb;
  Random random(4);
  for (Plane& plane : map.planes) {
    plane.descriptors = Descriptors(32);
    std::vector<uint8_t> row(32);
    for (size_t i = 0; i < plane.features.size(); ++i) {
      for (uint8_t& byte : row) byte = random.Below(256);
      plane.descriptors.Append(row.data());
    }
  }
  const auto index = MapIndex::Build(map);
  EXPECT_GT(index->search().lists(), 1);
  EXPECT_EQ(index->DescriptorsOf(1), map.planes[1].descriptors);
  // Every descriptor is its own nearest neighbour: its list's centre is the nearest.
  const auto nearest = index->search().Nearest(map.planes[1].descriptors, 1, 1);
  for (int i = 0; i < kMapFeatures; ++i) EXPECT_EQ(nearest[i].row, kMapFeatures + i);
}

}  // namespace
}  // namespace waystone
