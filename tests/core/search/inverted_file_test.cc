// SPDX-License-Identifier: Apache-2.0
#include "core/search/inverted_file.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <limits>
#include <set>

#include "core/base/error.h"
#include "tests/core/features/made_descriptors.h"

namespace waystone {
namespace {

class InvertedFiles : public testing::TestWithParam<FeatureType> {};

InvertedFileOptions SmallOptions() {
  InvertedFileOptions options;
  options.min_rows = 100;
  options.lists_per_root = 1;
  return options;
}

TEST_P(InvertedFiles, TheSameOnAnyNumberOfThreads) {
  Random random(1);
  const Descriptors rows = MadeDescriptors(GetParam(), 3000, random, 40);
  const tbb::global_control allow(tbb::global_control::max_allowed_parallelism, 8);
  std::vector<InvertedFile> files;
  for (const int threads : {1, 2, 8}) {
    tbb::task_arena arena(threads);
    files.push_back(
        arena.execute([&] { return BuildInvertedFile(rows, GetParam(), SmallOptions()); }));
  }
  EXPECT_EQ(files[0].centres.rows(), 64);
  EXPECT_TRUE(files[1] == files[0]);
  EXPECT_TRUE(files[2] == files[0]);
}

TEST_P(InvertedFiles, EveryRowIsInTheListWithTheNearestCentre) {
  Random random(2);
  const Descriptors rows = MadeDescriptors(GetParam(), 700, random);
  const InvertedFile file = BuildInvertedFile(rows, GetParam(), SmallOptions());
  ASSERT_EQ(InvertedFileProblem(file, rows.rows(), GetParam()), "");
  for (int i = 0; i < rows.rows(); ++i) {
    int best = std::numeric_limits<int>::max();
    int nearest = -1;
    for (int c = 0; c < file.centres.rows(); ++c) {
      const int distance = NaiveDistance(GetParam(), rows.row(i), file.centres.row(c));
      if (distance >= best) continue;
      best = distance;
      nearest = c;
    }
    ASSERT_EQ(file.list_of_row[i], nearest) << "row " << i;
  }
}

// Rows in clumps that are far apart: no list may hold rows of two of them.
TEST_P(InvertedFiles, ClumpsAreKeptApart) {
  Random random(3);
  constexpr int kClumps = 8;
  constexpr int kEach = 200;
  const Descriptors seeds = MadeDescriptors(GetParam(), kClumps, random);
  Descriptors rows(seeds.bytes());
  for (int i = 0; i < kClumps * kEach; ++i) {
    std::vector<uint8_t> row(seeds.row(i % kClumps), seeds.row(i % kClumps) + seeds.bytes());
    row[random.Below(seeds.bytes())] ^= 1;
    rows.Append(row.data());
  }
  const InvertedFile file = BuildInvertedFile(rows, GetParam(), SmallOptions());
  std::vector<std::set<int>> clumps(file.centres.rows());
  for (int i = 0; i < rows.rows(); ++i) clumps[file.list_of_row[i]].insert(i % kClumps);
  for (const auto& of_list : clumps) EXPECT_LE(of_list.size(), 1U);
}

TEST_P(InvertedFiles, RowsThatAreAllTheSame) {
  const int bytes = DescriptorBytes(GetParam());
  const Descriptors rows(bytes, std::vector<uint8_t>(static_cast<size_t>(bytes) * 500, 7));
  const InvertedFile file = BuildInvertedFile(rows, GetParam(), SmallOptions());
  EXPECT_EQ(InvertedFileProblem(file, 500, GetParam()), "");
}

TEST_P(InvertedFiles, FewRowsOrNoneHaveNone) {
  Random random(4);
  const Descriptors rows = MadeDescriptors(GetParam(), 99, random);
  EXPECT_TRUE(BuildInvertedFile(rows, GetParam(), SmallOptions()).list_of_row.empty());
  EXPECT_EQ(
      BuildInvertedFile(Descriptors(DescriptorBytes(GetParam())), GetParam(), {}).centres.rows(),
      0);
}

TEST_P(InvertedFiles, ProblemsAreNamed) {
  Random random(5);
  const Descriptors rows = MadeDescriptors(GetParam(), 300, random);
  const InvertedFile good = BuildInvertedFile(rows, GetParam(), SmallOptions());
  EXPECT_EQ(InvertedFileProblem(good, 300, GetParam()), "");
  EXPECT_NE(InvertedFileProblem(good, 301, GetParam()).find("301"), std::string::npos);
  InvertedFile file = good;
  file.list_of_row[17] = static_cast<uint16_t>(good.centres.rows());
  EXPECT_NE(InvertedFileProblem(file, 300, GetParam()).find("row 17"), std::string::npos);
  file = good;
  file.centres = Descriptors(DescriptorBytes(GetParam()));
  EXPECT_NE(InvertedFileProblem(file, 300, GetParam()).find("0 lists"), std::string::npos);
  file.centres = Descriptors(5, std::vector<uint8_t>(50));
  EXPECT_NE(InvertedFileProblem(file, 300, GetParam()).find("5 bytes"), std::string::npos);
}

INSTANTIATE_TEST_SUITE_P(Types, InvertedFiles, testing::ValuesIn(kAllTypes));

TEST(ListCount, GrowsWithTheRootOfTheRows) {
  EXPECT_EQ(ListCount(0, {}), 0);
  EXPECT_EQ(ListCount(8191, {}), 0);
  EXPECT_EQ(ListCount(100'000, {}), 1024);
  EXPECT_EQ(ListCount(1'000'000, {}), 4096);
  EXPECT_LE(ListCount(2'000'000'000, {}), 1 << 15);
}

TEST(InvertedFileOptions, OutOfRange) {
  InvertedFileOptions options;
  options.training_rows = 0;
  EXPECT_THROW(options.Check(), MapError);
  options = {};
  options.lists_per_root = 0;
  EXPECT_THROW(options.Check(), MapError);
}

}  // namespace
}  // namespace waystone
