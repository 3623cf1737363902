// SPDX-License-Identifier: Apache-2.0
#include "core/features/match.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "tests/core/features/made_descriptors.h"

namespace waystone {
namespace {

// Rows of `b` from the nearest to the farthest of one descriptor; ties by row.
std::vector<Neighbour> Sorted(FeatureType type, const uint8_t* query, const Descriptors& b) {
  std::vector<Neighbour> all;
  for (int j = 0; j < b.rows(); ++j) all.push_back({j, NaiveDistance(type, query, b.row(j))});
  std::stable_sort(all.begin(), all.end(),
                   [](const auto& x, const auto& y) { return x.distance < y.distance; });
  return all;
}

std::vector<Match> NaiveMatches(FeatureType type, const Descriptors& a, const Descriptors& b,
                                const MatchOptions& options) {
  std::vector<Match> matches;
  for (int i = 0; i < a.rows(); ++i) {
    const std::vector<Neighbour> of_a = Sorted(type, a.row(i), b);
    if (of_a.empty()) continue;
    if (of_a.size() > 1) {
      const bool sift = type == FeatureType::kSift;
      const double first = sift ? std::sqrt(of_a[0].distance) : of_a[0].distance;
      const double second = sift ? std::sqrt(of_a[1].distance) : of_a[1].distance;
      if (!(first < options.max_ratio * second)) continue;
    }
    if (options.mutual && Sorted(type, b.row(of_a[0].row), a).front().row != i) continue;
    matches.push_back({i, of_a[0].row, of_a[0].distance});
  }
  return matches;
}

// Some rows of `a`, a little changed, among random ones: so that there is something to match.
Descriptors Disturbed(FeatureType type, const Descriptors& a, int rows, Random& random) {
  Descriptors result(a.bytes());
  for (int j = 0; j < rows; ++j) {
    std::vector<uint8_t> row;
    if (a.rows() > 0 && random.Below(2) == 0) {
      const uint8_t* source = a.row(random.Below(a.rows()));
      row.assign(source, source + a.bytes());
      for (int change = random.Below(12); change > 0; --change) {
        row[random.Below(a.bytes())] = random.Below(128);
      }
    } else {
      row = MadeDescriptors(type, 1, random).data();
    }
    result.Append(row.data());
  }
  return result;
}

class Matching : public testing::TestWithParam<FeatureType> {};

TEST_P(Matching, MatchesAreThoseOfTheDefinition) {
  const FeatureType type = GetParam();
  Random random(1);
  size_t found = 0;
  for (const auto& [rows_a, rows_b] : std::vector<std::pair<int, int>>{{0, 0},
                                                                       {0, 5},
                                                                       {5, 0},
                                                                       {1, 1},
                                                                       {1, 2},
                                                                       {40, 1},
                                                                       {1, 300},
                                                                       {50, 60},
                                                                       {60, 257},
                                                                       {30, 256},
                                                                       {20, 255},
                                                                       {40, 513}}) {
    const Descriptors a = MadeDescriptors(type, rows_a, random);
    const Descriptors b = Disturbed(type, a, rows_b, random);
    for (const double ratio : {0.5, 0.8, 0.97, 1.0}) {
      for (const bool mutual : {false, true}) {
        const std::vector<Match> expected = NaiveMatches(type, a, b, {ratio, mutual});
        EXPECT_EQ(MatchDescriptors(a, b, type, {ratio, mutual}), expected)
            << rows_a << " x " << rows_b << ", ratio " << ratio << ", mutual " << mutual;
        found += expected.size();
      }
    }
  }
  EXPECT_GT(found, 300u) << "nothing was compared";
}

// Few levels make many distances equal, and the ratio of 1 lets all but true ties through.
TEST_P(Matching, TiesGoToTheLowerIndex) {
  const FeatureType type = GetParam();
  Random random(2);
  const Descriptors a = MadeDescriptors(type, 80, random, 2);
  const Descriptors b = MadeDescriptors(type, 300, random, 2);
  EXPECT_EQ(MatchDescriptors(a, b, type, {1.0, true}), NaiveMatches(type, a, b, {1.0, true}));
  EXPECT_EQ(MatchDescriptors(a, b, type, {1.0, false}), NaiveMatches(type, a, b, {1.0, false}));
}

TEST_P(Matching, OfTwoEqualRowsTheLowerIsTheMutualMatch) {
  const FeatureType type = GetParam();
  Random random(3);
  const Descriptors b = MadeDescriptors(type, 2, random);
  Descriptors a(b.bytes());
  for (int i = 0; i < 3; ++i) a.Append(b.row(1));
  const std::vector<Match> matches = MatchDescriptors(a, b, type, {0.8, true});
  ASSERT_EQ(matches.size(), 1u);
  EXPECT_EQ(matches[0], (Match{0, 1, 0}));
  EXPECT_EQ(MatchDescriptors(a, b, type, {0.8, false}).size(), 3u);
}

// A row that is there twice can't be told apart from its copy.
TEST_P(Matching, ADescriptorThatIsThereTwiceHasNoMatch) {
  const FeatureType type = GetParam();
  Random random(4);
  const Descriptors a = MadeDescriptors(type, 1, random);
  Descriptors b(a.bytes());
  b.Append(a.row(0));
  b.Append(a.row(0));
  EXPECT_TRUE(MatchDescriptors(a, b, type, {1.0, true}).empty());
}

TEST_P(Matching, MutualMatchesAreTheSameFromEitherSide) {
  const FeatureType type = GetParam();
  Random random(5);
  const Descriptors a = MadeDescriptors(type, 90, random);
  const Descriptors b = Disturbed(type, a, 120, random);
  // Without a ratio below one, a match of one side is a match of the other unless there is a tie.
  std::vector<Match> forth = MatchDescriptors(a, b, type, {1.0, true});
  std::vector<Match> back = MatchDescriptors(b, a, type, {1.0, true});
  for (Match& match : back) std::swap(match.a, match.b);
  std::sort(back.begin(), back.end(), [](const auto& x, const auto& y) { return x.a < y.a; });
  std::erase_if(forth, [&](const Match& m) { return !std::count(back.begin(), back.end(), m); });
  EXPECT_GE(forth.size(), back.size() * 9 / 10);
  EXPECT_GT(forth.size(), 20u);
}

INSTANTIATE_TEST_SUITE_P(Types, Matching, testing::ValuesIn(kAllTypes),
                         [](const auto& type) { return std::string(NameOf(type.param)); });

TEST(PassesRatio, ComparesLengthsNotSquares) {
  // Squared distances 63 and 100 of SIFT are lengths 7.94 and 10; Hamming distances are lengths.
  EXPECT_TRUE(PassesRatio(FeatureType::kSift, 63, 100, 0.8));
  EXPECT_FALSE(PassesRatio(FeatureType::kSift, 65, 100, 0.8));
  EXPECT_TRUE(PassesRatio(FeatureType::kOrb, 79, 100, 0.8));
  EXPECT_FALSE(PassesRatio(FeatureType::kAkaze, 81, 100, 0.8));
  EXPECT_FALSE(PassesRatio(FeatureType::kSift, 0, 0, 1.0));
}

TEST(MatchOptions, RefuseARatioOutsideItsRange) {
  for (double ratio : {0.0, -1.0, 1.01, std::numeric_limits<double>::quiet_NaN()}) {
    MatchOptions options;
    options.max_ratio = ratio;
    try {
      options.Check();
      ADD_FAILURE() << ratio << " was taken";
    } catch (const MapError& error) {
      EXPECT_EQ(error.code(), ErrorCode::kBadOptions);
    }
  }
  EXPECT_NO_THROW((MatchOptions{1.0, true}.Check()));
}

}  // namespace
}  // namespace waystone
