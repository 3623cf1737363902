// SPDX-License-Identifier: Apache-2.0
#include "builder/options_record.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "builder/build_map.h"
#include "core/base/option_members.h"

namespace waystone {
namespace {

enum class Metal { kIron, kZinc };
std::string_view NameOf(Metal metal) { return metal == Metal::kIron ? "iron" : "zinc"; }

struct Alloy {
  Metal metal = Metal::kZinc;
  std::vector<double> shares = {0.25, 0.75};

  static constexpr auto Fields(const auto& use) {
    return use(OptionField{"metal", &Alloy::metal, AnyValue(), "", ""},
               OptionField{"shares", &Alloy::shares, AnyValue(), "", ""});
  }
};

struct Casting {
  int rounds = 3;
  Alloy alloy{};
  bool cooled = true;
  double heat = 0.1;

  static constexpr auto Fields(const auto& use) {
    return use(OptionField{"rounds", &Casting::rounds, AnyValue(), "", ""},
               OptionGroup{"alloy", &Casting::alloy},
               OptionField{"cooled", &Casting::cooled, AnyValue(), "", ""},
               OptionField{"heat", &Casting::heat, AnyValue(), "", ""});
  }
};

TEST(RecordFields, NestsGroupsInTheOrderOfTheLists) {
  EXPECT_EQ(
      RecordFields(Casting{}),
      R"({"rounds":3,"alloy":{"metal":"zinc","shares":[0.25,0.75]},"cooled":true,"heat":0.1})");
}

// An options struct that grows a member without listing it isn't fully recorded.
TEST(RecordOptions, HasEveryMember) { EXPECT_EQ(FindUnlistedMembers<BuildOptions>("build"), ""); }

TEST(RecordOptions, DependsOnWhatAMapDependsOn) {
  BuildOptions options;
  const std::string record = RecordOptions(options);
  options.threads = 7;
  options.map_name = "another";
  EXPECT_EQ(RecordOptions(options), record);
  options.image_width = 200;
  EXPECT_NE(RecordOptions(options), record);
  const nlohmann::json json = nlohmann::json::parse(RecordOptions(options));
  EXPECT_EQ(json["image_width"], 200);
  EXPECT_EQ(json["planes"]["min_features"], options.planes.min_features);
  EXPECT_EQ(json["features"]["type"], "sift");
  EXPECT_EQ(json["appearance"]["describe"]["signature"]["band"]["top_rad"], 0.6);
  EXPECT_EQ(json["appearance"]["odometry"]["compass"]["warping"]["columns"], 120);
  EXPECT_EQ(json["appearance_calibration"]["blank_spacings"].size(), 3u);
}

TEST(OptionsOfRecord, HasWhatSourcesAreBuiltWith) {
  BuildOptions options;
  options.features.max_features = 300;
  options.planes.min_features = 17;
  options.appearance.describe.signature.rows = 16;
  options.appearance.describe.features.max_kept = 100;
  options.orientation.turns.reach = 7;
  options.image_width = 200;
  options.map_name = "another";
  const BuildOptions read = OptionsOfRecord(RecordOptions(options));
  EXPECT_EQ(RecordOptions(read), RecordOptions(options));
}

}  // namespace
}  // namespace waystone
