// SPDX-License-Identifier: Apache-2.0
#include "cli/commands/settings.h"

#include <gtest/gtest.h>

#include <fstream>
#include <sstream>
#include <string>

#include "core/base/error.h"

namespace waystone {
namespace {

std::string ErrorOfSetting(const std::string& setting) {
  BuildOptions options;
  try {
    ApplySettings({setting}, options);
    return "";
  } catch (const MapError& error) {
    return error.what();
  }
}

TEST(ApplySettings, SetsFieldsByTheirFullNames) {
  BuildOptions options;
  ApplySettings({"image_width=240", "images=false"}, options);
  EXPECT_EQ(options.image_width, 240);
  EXPECT_FALSE(options.images);
  EXPECT_THROW(ApplySettings({"image_width=200", "image_width=240"}, options), MapError);
}

TEST(ApplySettings, SetsOptionsOfQueries) {
  LocalizeOptions options;
  ApplySettings({"panorama.candidates=3", "planes.max_features=700"}, options);
  EXPECT_EQ(options.panorama.candidates, 3);
  EXPECT_EQ(options.planes.max_features, 700);
  EXPECT_THROW(ApplySettings({"image_width=200"}, options), MapError);
}

TEST(ApplySettings, NamesTheNearestOption) {
  EXPECT_NE(ErrorOfSetting("image_widht=200").find("did you mean 'image_width'"),
            std::string::npos);
  EXPECT_EQ(ErrorOfSetting("foo=1"), "there is no option 'foo'; `waystone options` lists all");
  EXPECT_NE(ErrorOfSetting("image_width").find("NAME=VALUE"), std::string::npos);
  EXPECT_NE(ErrorOfSetting("image_width=wide").find("image_width is 'wide'"), std::string::npos);
}

TEST(ApplySettings, SetsNamesAndLists) {
  BuildOptions options;
  ApplySettings({"features.type=orb", "appearance_calibration.blank_spacings=0,5"}, options);
  EXPECT_EQ(options.features.type, FeatureType::kOrb);
  EXPECT_EQ(options.appearance_calibration.blank_spacings, (std::vector<double>{0, 5}));
  EXPECT_EQ(ErrorOfSetting("features.type=surf"),
            "features.type is 'surf'; it must be sift, orb or akaze");
}

TEST(ApplySettings, LeavesRangesToTheCheck) {
  BuildOptions options;
  ApplySettings({"image_width=3"}, options);
  EXPECT_THROW(options.Check(), MapError);
}

// After a change of options: build/release/cli/waystone options --markdown > docs/options.md
TEST(OptionsMarkdown, IsTheCommittedFile) {
  std::ifstream in(WAYSTONE_SOURCE_DIR "/docs/options.md");
  std::stringstream committed;
  committed << in.rdbuf();
  EXPECT_EQ(OptionsMarkdown(), committed.str());
}

TEST(OptionsText, HasALineAnOption) {
  EXPECT_NE(OptionsText().find("  image_width = 320 px (between 16 and 4096): Width"),
            std::string::npos);
}

}  // namespace
}  // namespace waystone
