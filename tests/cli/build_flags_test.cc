// SPDX-License-Identifier: Apache-2.0
#include "cli/commands/build_flags.h"

#include <gtest/gtest.h>

#include "core/base/error.h"

namespace waystone {
namespace {

int WorkingPixels(const std::string& features, const std::vector<std::string>& settings = {}) {
  BuildFlags flags;
  flags.features = features;
  flags.settings = settings;
  return MakeBuildOptions(flags, "hall").features.working_pixels;
}

TEST(BuildFlags, WorkingImagesSuitTheTypeOfFeatures) {
  EXPECT_EQ(WorkingPixels("sift"), 640 * 480 / 2);
  EXPECT_EQ(WorkingPixels("orb"), 640 * 480);
  EXPECT_EQ(WorkingPixels("akaze"), 640 * 480);
  EXPECT_EQ(WorkingPixels("sift", {"features.type=orb"}), 640 * 480);
  EXPECT_EQ(WorkingPixels("orb", {"features.working_pixels=50000"}), 50'000);
}

TEST(BuildFlags, SetTheOptionsTheyName) {
  const auto parse = [](const std::vector<std::string>& options) {
    return MakeBuildOptions(ParseBuildFlags({"photos"}, options), "hall");
  };
  const BuildOptions defaults = parse({});
  EXPECT_EQ(defaults.planes.landmarks.max_kept, BuildOptions().planes.landmarks.max_kept);
  EXPECT_TRUE(defaults.images);
  const BuildOptions given = parse({"--landmarks", "40", "--max-features=700", "--no-images"});
  EXPECT_EQ(given.planes.landmarks.max_kept, 40);
  EXPECT_EQ(given.features.max_features, 700);
  EXPECT_FALSE(given.images);
  EXPECT_EQ(parse({"--landmarks", "0"}).planes.landmarks.max_kept, 0);
  try {
    parse({"--landmarks", "-1"});
    ADD_FAILURE() << "less than none was accepted";
  } catch (const MapError& error) {
    EXPECT_EQ(error.code(), ErrorCode::kBadOptions);
  }
}

}  // namespace
}  // namespace waystone
