// SPDX-License-Identifier: Apache-2.0
#include "core/search/search_index.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <tuple>

#include "core/features/distance.h"
#include "tests/core/features/made_descriptors.h"

namespace waystone {
namespace {

constexpr int kAll = std::numeric_limits<int>::max();

InvertedFileOptions FewLists() {
  InvertedFileOptions options;
  options.min_rows = 100;
  return options;
}

SearchIndex Filled(SearchIndex index, const Descriptors& rows) {
  for (int i = 0; i < rows.rows(); ++i) index.Set(i, rows.row(i));
  return index;
}

SearchIndex Indexed(FeatureType type, const Descriptors& rows) {
  return Filled(SearchIndex(type, BuildInvertedFile(rows, type, FewLists())), rows);
}

// Rows around seeds, as descriptors of the same corners seen from different places are.
Descriptors Clumped(FeatureType type, int rows, const Descriptors& seeds, Random& random) {
  Descriptors made(seeds.bytes());
  for (int i = 0; i < rows; ++i) {
    const uint8_t* seed = seeds.row(random.Below(seeds.rows()));
    std::vector<uint8_t> row(seed, seed + seeds.bytes());
    for (int change = 0; change < seeds.bytes() / 6; ++change) {
      uint8_t& byte = row[random.Below(seeds.bytes())];
      byte = type == FeatureType::kSift ? random.Below(128) : byte ^ (1 << random.Below(8));
    }
    made.Append(row.data());
  }
  return made;
}

void ExpectSame(const std::vector<Neighbour>& a, const std::vector<Neighbour>& b) {
  ASSERT_EQ(a.size(), b.size());
  for (size_t i = 0; i < a.size(); ++i) {
    ASSERT_EQ(a[i].row, b[i].row) << i;
    ASSERT_EQ(a[i].distance, b[i].distance) << i;
  }
}

// The k nearest rows of each query, by sorting all; ties go to the lower row.
std::vector<Neighbour> NearestBySorting(const Descriptors& queries, const Descriptors& rows,
                                        FeatureType type, int k) {
  std::vector<Neighbour> nearest;
  for (int q = 0; q < queries.rows(); ++q) {
    std::vector<Neighbour> all;
    for (int row = 0; row < rows.rows(); ++row) {
      all.push_back({row, DescriptorDistance(type, queries.row(q), rows.row(row))});
    }
    const auto rank = [](const Neighbour& one) { return std::tuple(one.distance, one.row); };
    std::ranges::partial_sort(all, all.begin() + k, {}, rank);
    nearest.insert(nearest.end(), all.begin(), all.begin() + k);
  }
  return nearest;
}

class SearchIndexes : public testing::TestWithParam<FeatureType> {};

TEST_P(SearchIndexes, SearchingAllListsIsExhaustive) {
  Random random(1);
  // Few levels: ties are frequent, and go to the lower row.
  const Descriptors rows = MadeDescriptors(GetParam(), 1500, random, 4);
  const Descriptors queries = MadeDescriptors(GetParam(), 70, random, 4);
  const auto truth = NearestBySorting(queries, rows, GetParam(), 3);
  ExpectSame(Indexed(GetParam(), rows).Nearest(queries, 3, kAll), truth);
  ExpectSame(Filled(SearchIndex(GetParam(), rows.rows()), rows).Nearest(queries, 3, 1), truth);
}

TEST_P(SearchIndexes, FewListsFindAlmostAllThatIsNear) {
  Random random(2);
  const Descriptors seeds = MadeDescriptors(GetParam(), 2000, random);
  const Descriptors rows = Clumped(GetParam(), 20000, seeds, random);
  const Descriptors queries = Clumped(GetParam(), 400, seeds, random);
  const auto truth = NearestBySorting(queries, rows, GetParam(), 1);
  const SearchIndex index = Indexed(GetParam(), rows);
  int found = 0;
  const auto neighbours = index.Nearest(queries, 1, 32);
  for (size_t i = 0; i < truth.size(); ++i) found += neighbours[i].distance == truth[i].distance;
  EXPECT_GE(found, 396) << "of " << truth.size() << " with 32 of " << index.lists() << " lists";
}

TEST_P(SearchIndexes, MoreListsNeverFindWorse) {
  Random random(3);
  const Descriptors rows = MadeDescriptors(GetParam(), 3000, random);
  const Descriptors queries = MadeDescriptors(GetParam(), 50, random);
  const SearchIndex index = Indexed(GetParam(), rows);
  auto last = index.Nearest(queries, 2, 1);
  for (const int probes : {2, 8, 40, 1000}) {
    const auto next = index.Nearest(queries, 2, probes);
    for (size_t i = 0; i < next.size(); ++i) EXPECT_LE(next[i].distance, last[i].distance);
    last = next;
  }
}

TEST_P(SearchIndexes, RowsComeBackAsTheyWereSet) {
  Random random(4);
  const Descriptors rows = MadeDescriptors(GetParam(), 333, random);
  const SearchIndex index = Indexed(GetParam(), rows);
  EXPECT_EQ(index.rows(), 333);
  EXPECT_EQ(index.Rows(0, 333), rows);
  EXPECT_EQ(index.Rows(332, 1).data(),
            std::vector<uint8_t>(rows.row(332), rows.row(332) + rows.bytes()));
}

TEST_P(SearchIndexes, FewerRowsThanAsked) {
  Random random(5);
  const Descriptors rows = MadeDescriptors(GetParam(), 2, random);
  const auto found = Filled(SearchIndex(GetParam(), 2), rows).Nearest(rows, 3, 5);
  ASSERT_EQ(found.size(), 6U);
  EXPECT_EQ(found[0].row, 0);
  EXPECT_EQ(found[0].distance, 0);
  EXPECT_EQ(found[2].row, -1);
  const auto none = SearchIndex(GetParam(), 0).Nearest(rows, 1, 1);
  EXPECT_EQ(none[0].row, -1);
  EXPECT_TRUE(SearchIndex().Nearest(Descriptors(DescriptorBytes(GetParam())), 1, 1).empty());
}

INSTANTIATE_TEST_SUITE_P(Types, SearchIndexes, testing::ValuesIn(kAllTypes));

}  // namespace
}  // namespace waystone
