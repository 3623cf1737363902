// SPDX-License-Identifier: Apache-2.0
// The lists of fields of the options of core and world.
#include <gtest/gtest.h>

#include <set>
#include <string>

#include "core/base/options.h"
#include "core/features/match.h"
#include "core/homography/plane_in_space.h"
#include "core/homography/segment_planes.h"
#include "core/image/decode.h"
#include "core/localization/graph_filter.h"
#include "core/manhattan/great_circles.h"
#include "core/manhattan/manhattan_frame.h"
#include "core/manhattan/segments.h"
#include "core/pose_graph/pose_graph.h"
#include "core/search/inverted_file.h"
#include "core/trajectory/trajectory_error.h"
#include "core/two_view/relative_rotation.h"
#include "world/setting.h"
#include "world/write_walk.h"

namespace waystone {
namespace {

template <class Options>
class OptionLists : public testing::Test {};

using AllOptions =
    testing::Types<FeatureOptions, MatchOptions, InvertedFileOptions, DecodeLimits,
                   SegmentationOptions, SpaceOptions, BearingFeatureOptions, RelativeOptions,
                   GreatCircleOptions, SegmentOptions, ManhattanOptions, AssociationOptions,
                   PoseGraphOptions, GraphFilterOptions, OdometryOptions, PlanOptions, WorldOptions,
                   WalkOptions, RenderOptions, WriteWalkOptions>;
TYPED_TEST_SUITE(OptionLists, AllOptions);

TYPED_TEST(OptionLists, NameEachFieldOnceAndExplainIt) {
  const TypeParam options;
  EXPECT_NO_THROW(options.Check());
  std::set<std::string> names;
  VisitFields("", options, [&](const std::string& name, const auto& field, const auto&) {
    EXPECT_TRUE(names.insert(name).second) << name << " is listed twice";
    EXPECT_TRUE(field.help.ends_with(".")) << name << ": " << field.help;
  });
  EXPECT_FALSE(names.empty());
}

TYPED_TEST(OptionLists, RefuseWhatIsOutOfRange) {
  const TypeParam defaults;
  int bounded = 0;
  VisitFields("", defaults, [&](const std::string& name, const auto& field, const auto& value) {
    using Value = std::decay_t<decltype(value)>;
    if constexpr (std::is_arithmetic_v<Value> && !std::is_same_v<Value, bool>) {
      if (std::is_unsigned_v<Value> || !std::isfinite(field.range.low)) return;
      ++bounded;
      TypeParam options;
      SetField("", options, name, std::to_string(static_cast<int>(field.range.low) - 1));
      EXPECT_THROW(options.Check(), MapError) << name;
    }
  });
  const bool none_bounded = std::is_same_v<TypeParam, MatchOptions>;
  EXPECT_GT(bounded + (none_bounded ? 1 : 0), 0);
}

TEST(OptionEnumerations, SetEnumerationsByName) {
  FeatureOptions features;
  EXPECT_TRUE(SetField("features", features, "features.type", "orb"));
  EXPECT_EQ(features.type, FeatureType::kOrb);
  EXPECT_THROW(SetField("features", features, "features.type", "surf"), MapError);
  SegmentOptions segments;
  EXPECT_TRUE(SetField("segments", segments, "segments.detector", "lsd"));
  EXPECT_EQ(segments.detector, SegmentDetector::kLsd);
  EXPECT_THROW(SetField("segments", segments, "segments.detector", "hough"), MapError);
}

TEST(OptionGroups, RefuseFieldsThatContradictEachOther) {
  EXPECT_THROW((LocalRansacOptions{.max_error_px = 0.5, .min_error_px = 0.75}.Check()), MapError);
  EXPECT_THROW((LabellingOptions{.min_sigmas = 5, .max_sigmas = 4}.Check()), MapError);
  EXPECT_THROW((PlanOptions{.wall_height_m = 2, .door_height_m = 2.5}.Check()), MapError);
  SegmentationOptions segmentation;
  segmentation.ransac.max_error_px = 0.5;
  EXPECT_THROW(segmentation.Check(), MapError) << "groups are checked whole";
}

}  // namespace
}  // namespace waystone
