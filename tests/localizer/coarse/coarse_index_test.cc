// SPDX-License-Identifier: Apache-2.0
// Which of many maps may show an image.
#include "localizer/coarse/coarse_index.h"

#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include "core/base/error.h"
#include "tests/localizer/coarse/made_entry.h"

namespace waystone {
namespace {

struct Collection {
  std::vector<std::vector<MadePlace>> places;  // by map
  std::vector<CoarseIndex::Map> maps;
};

Collection MakeCollection(int maps, FeatureType type = FeatureType::kSift) {
  Collection made;
  for (int i = 0; i < maps; ++i) {
    made.places.push_back(MadePlaces(type, 6, 100 + static_cast<uint64_t>(i)));
    made.maps.push_back({"map " + std::to_string(1000 + i),
                         std::make_shared<CoarseEntry>(EntryOf(type, made.places.back()))});
  }
  return made;
}

std::vector<CoarseDescriptors> Seen(FeatureType type, const MadePlace& place) {
  return {{type, place.rows}};
}

class CoarseIndexTest : public testing::TestWithParam<FeatureType> {};

INSTANTIATE_TEST_SUITE_P(Types, CoarseIndexTest, testing::ValuesIn(kAllTypes),
                         [](const auto& type) { return std::string(NameOf(type.param)); });

TEST_P(CoarseIndexTest, EveryPlaceIsFoundInItsMap) {
  const Collection made = MakeCollection(60, GetParam());
  const CoarseIndex index(made.maps);
  EXPECT_EQ(index.places(), 360);
  for (size_t map = 0; map < made.maps.size(); ++map) {
    const auto proposals = index.Propose({Seen(GetParam(), made.places[map][map % 6])}, 10);
    ASSERT_FALSE(proposals.empty());
    EXPECT_EQ(index.maps()[proposals[0].map].name, made.maps[map].name);
    for (size_t i = 1; i < proposals.size(); ++i) {
      EXPECT_LE(proposals[i].score, proposals[i - 1].score);
    }
  }
}

TEST(CoarseIndex, DependsNeitherOnTheOrderNorOnThreads) {
  const Collection made = MakeCollection(30);
  std::vector<CoarseIndex::Map> backwards(made.maps.rbegin(), made.maps.rend());
  const CoarseIndex index(made.maps);
  const CoarseIndex other(backwards);
  for (int map = 0; map < 30; map += 7) {
    const std::vector<std::vector<CoarseDescriptors>> query = {
        Seen(FeatureType::kSift, made.places[map][2]),
        Seen(FeatureType::kSift, made.places[map][3])};
    const auto proposals = index.Propose(query, 10);
    EXPECT_EQ(proposals, other.Propose(query, 10));
    tbb::task_arena one(1);
    EXPECT_EQ(proposals, one.execute([&] { return index.Propose(query, 10); }));
  }
}

TEST(CoarseIndex, PassesOverWhatIsLeftOut) {
  const Collection made = MakeCollection(20);
  const CoarseIndex index(made.maps);
  std::vector<bool> left_out(20, false);
  left_out[4] = true;
  const auto query = Seen(FeatureType::kSift, made.places[4][1]);
  EXPECT_EQ(index.Propose({query}, 3).at(0).map, 4);
  for (const auto& proposal : index.Propose({query}, 20, left_out)) EXPECT_NE(proposal.map, 4);
  EXPECT_EQ(index.Propose({query}, 1).size(), 1U);
  EXPECT_TRUE(index.Propose({query}, 0).empty());
}

TEST(CoarseIndex, TypesGoTogether) {
  std::vector<CoarseIndex::Map> maps;
  for (const FeatureType type : kAllTypes) {
    maps.push_back({std::string(NameOf(type)),
                    std::make_shared<CoarseEntry>(EntryOf(type, MadePlaces(type, 3, 9)))});
  }
  const CoarseIndex index(maps);
  EXPECT_EQ(index.Needs().size(), 3U);
  for (const FeatureType type : kAllTypes) {
    const auto proposals = index.Propose({Seen(type, MadePlaces(type, 3, 9)[1])}, 10);
    ASSERT_EQ(proposals.size(), 1U);
    EXPECT_EQ(index.maps()[proposals[0].map].name, NameOf(type));
  }
}

TEST(CoarseIndex, HoldsNothingWithoutMaps) {
  const CoarseIndex none;
  const CoarseIndex empty(std::vector<CoarseIndex::Map>{});
  EXPECT_EQ(none.places(), 0);
  EXPECT_TRUE(none.Needs().empty());
  const auto query = Seen(FeatureType::kSift, MadePlaces(FeatureType::kSift, 1, 1)[0]);
  EXPECT_TRUE(none.Propose({query}, 10).empty());
  EXPECT_TRUE(empty.Propose({query}, 10).empty());
  EXPECT_TRUE(CoarseIndex(MakeCollection(2).maps).Propose({}, 10).empty());
}

TEST(CoarseIndex, TakesLessThanTwoKilobytesAPlace) {
  const CoarseIndex index(MakeCollection(400).maps);
  EXPECT_LT(index.bytes() / index.places(), 2000);
}

TEST(CoarseIndex, OptionsHaveRanges) {
  CoarseOptions options;
  options.probes = 0;
  EXPECT_THROW(CoarseIndex({}, options), MapError);
}

}  // namespace
}  // namespace waystone
