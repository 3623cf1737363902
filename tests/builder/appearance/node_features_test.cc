// SPDX-License-Identifier: Apache-2.0
#include "builder/appearance/node_features.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "core/base/error.h"
#include "tests/builder/appearance/drive.h"

namespace waystone {
namespace {

// The rows of `from` whose codes and bearings a node keeps.
std::vector<int> KeptRows(const NodeFeatures& kept, const BearingFeatures& from) {
  const NodeFeatures all = ToNodeFeatures(from);
  std::vector<int> rows;
  for (int i = 0; i < std::ssize(kept.bearings); ++i) {
    for (int row = 0; row < from.size(); ++row) {
      if (all.bearings[row] == kept.bearings[i] &&
          std::equal(kept.codes.row(i), kept.codes.row(i) + kept.codes.bytes(),
                     all.codes.row(row))) {
        rows.push_back(row);
        break;
      }
    }
  }
  return rows;
}

TEST(NodeFeatureChooser, KeepsWhatIsFoundAgainBeforeWhatIsnt) {
  NodeFeatureOptions options;
  options.max_kept = 30;
  std::vector<BearingFeatures> features;
  for (int i = 0; i < 3; ++i) {
    features.push_back(ExtractPanoramaFeatures(TheDrive().panoramas[i], options.extract));
  }
  ASSERT_GT(features[1].size(), 2 * options.max_kept);
  NodeFeatureChooser chooser(options);
  EXPECT_EQ(chooser.Next(features[0]), NodeFeatures{});
  chooser.Next(features[1]);
  const NodeFeatures middle = chooser.Next(features[2]);
  EXPECT_EQ(std::ssize(chooser.Last().bearings), options.max_kept);
  EXPECT_EQ(chooser.Last(), NodeFeatures{});  // another sequence begins
  const std::vector<int> rows = KeptRows(middle, features[1]);
  ASSERT_EQ(std::ssize(rows), options.max_kept);
  std::vector<int> again(features[1].size(), 0);
  for (const int neighbour : {0, 2}) {
    for (const Match& match :
         MatchBearings(features[1], features[neighbour], options.match).matches) {
      ++again[match.a];
    }
  }
  const auto found = std::ranges::count_if(rows, [&](int row) { return again[row] > 0; });
  const auto anyway = std::ranges::count_if(again, [](int times) { return times > 0; });
  EXPECT_GE(found, std::min<std::ptrdiff_t>(options.max_kept * 3 / 4, anyway / 2));
  EXPECT_GT(static_cast<double>(found) / options.max_kept,
            static_cast<double>(anyway) / features[1].size());
}

TEST(NodeFeatureChooser, BearsPanoramasWithoutFeatures) {
  const NodeFeatureOptions options;
  NodeFeatureChooser chooser(options);
  chooser.Next({});
  EXPECT_EQ(chooser.Next({}), NodeFeatures{});
  EXPECT_EQ(chooser.Last(), NodeFeatures{});
}

TEST(NodeFeatureChooser, RefusesOptionsOutOfRange) {
  NodeFeatureOptions options;
  options.max_kept = -1;
  EXPECT_THROW(options.Check(), MapError);
}

}  // namespace
}  // namespace waystone
