// SPDX-License-Identifier: Apache-2.0
#include "cli/commands/build_flags.h"

#include <gtest/gtest.h>

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

}  // namespace
}  // namespace waystone
