// SPDX-License-Identifier: Apache-2.0
// Maps of earlier programs (tests/schema/golden/README.md) answer after a migration as they did
// when they were new.
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "core/homography/homography.h"
#include "localizer/localizer.h"
#include "schema/file/map_store.h"

namespace waystone {
namespace {

namespace fs = std::filesystem;

const fs::path kGoldenFolder = fs::path(WAYSTONE_SOURCE_DIR) / "tests/schema/golden";

MapData MigratedMap(const std::string& name) {
  const fs::path copy = fs::temp_directory_path() / (name + "_" + std::to_string(getpid()) + ".db");
  fs::copy_file(kGoldenFolder / (name + ".db"), copy, fs::copy_options::overwrite_existing);
  fs::permissions(copy, fs::perms::owner_read | fs::perms::owner_write);
  MigrateMap(copy);
  MapData map = ReadMap(copy);
  fs::remove(copy);
  return map;
}

class GoldenWalkTest : public testing::TestWithParam<std::string> {};

TEST_P(GoldenWalkTest, LocalizesAsWhenItWasNew) {
  std::ifstream file(kGoldenFolder / "query.jpg", std::ios::binary);
  const std::vector<uint8_t> bytes{std::istreambuf_iterator<char>(file),
                                   std::istreambuf_iterator<char>()};
  const Answer answer = Localize(*MapIndex::Build(MigratedMap(GetParam())), bytes, "query.jpg", {});
  ASSERT_EQ(answer.verdict, Verdict::kLocalized) << answer.message;
  EXPECT_GT(answer.probability, 0.99);
  ASSERT_TRUE(answer.planes.keyframe);
  EXPECT_EQ(answer.planes.keyframe->source, "12.jpg");
  const auto plane = std::ranges::find(answer.planes.recognised, PlaneId{1}, &RecognisedPlane::id);
  ASSERT_NE(plane, answer.planes.recognised.end());
  EXPECT_GT(plane->inliers, 150);  // 179 when it was new
  Eigen::Matrix3d then;            // the answer of the program that wrote it
  then << 1.2135532196456187, -0.009194853150588407, 25.25602922262787, 0.049039104583107646,
      1.0981634565959748, -34.93337971746402, 0.00013518412489610016, 1.145867575795292e-05, 1;
  for (const Eigen::Vector2d& x : {Eigen::Vector2d(320, 240), Eigen::Vector2d(160, 120)}) {
    EXPECT_LT((Apply(plane->reference_from_query, x) - Apply(then, x)).norm(), 1.5);  // px
  }
}

INSTANTIATE_TEST_SUITE_P(Golden, GoldenWalkTest, testing::Values("v3_walk", "v4_walk", "v5_walk"),
                         [](const auto& walk) { return walk.param; });

}  // namespace
}  // namespace waystone
