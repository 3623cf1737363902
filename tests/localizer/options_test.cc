// SPDX-License-Identifier: Apache-2.0
#include "localizer/options.h"

#include <gtest/gtest.h>

#include <functional>
#include <limits>
#include <vector>

#include "core/base/error.h"
#include "localizer/localizer.h"
#include "tests/localizer/made_map.h"

namespace waystone {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

TEST(LocalizeOptions, DefaultsAreInRange) { EXPECT_NO_THROW(LocalizeOptions{}.Check()); }

TEST(LocalizeOptions, OutOfTheirRangeAreRefused) {
  using Change = std::function<void(LocalizeOptions&)>;
  const std::vector<Change> changes = {
      [](auto& o) { o.limits.max_pixels = 0; },
      [](auto& o) { o.planes.max_features = 10; },
      [](auto& o) { o.planes.contrast_threshold = 0; },
      [](auto& o) { o.planes.votes_per_feature = 0; },
      [](auto& o) { o.planes.max_candidates = 0; },
      [](auto& o) { o.planes.min_votes = 0; },
      [](auto& o) { o.planes.probes = 0; },
      [](auto& o) { o.planes.settled_inliers = 0; },
      [](auto& o) { o.planes.settled_share = o.planes.gates.ambiguous_share + 0.1; },
      [](auto& o) { o.planes.match.max_ratio = 1.5; },
      [](auto& o) { o.planes.ransac.max_samples = 0; },
      [](auto& o) { o.planes.homology.draws = 1; },
      [](auto& o) { o.planes.gates.min_inliers = 4; },
      [](auto& o) { o.planes.gates.min_probability = 1; },
      [](auto& o) { o.planes.gates.min_inlier_share = -0.1; },
      [](auto& o) { o.planes.gates.min_inlier_share = 1.1; },
      [](auto& o) { o.planes.gates.min_inlier_share = kNan; },
      [](auto& o) { o.planes.gates.distinct_px = -1; },
      [](auto& o) { o.planes.gates.max_scale = 1; },
      [](auto& o) { o.planes.gates.ambiguous_share = 0; },
      [](auto& o) { o.planes.gates.ambiguous_share = 1.01; },
      [](auto& o) { o.pose.search_px = 0; },
      [](auto& o) { o.pose.max_descriptor_distance = 1.5; },
      [](auto& o) { o.pose.solve.min_inliers = -1; },
  };
  const auto index = MadeIndex();
  for (size_t i = 0; i < changes.size(); ++i) {
    LocalizeOptions options;
    changes[i](options);
    try {
      LocalizeFeatures(*index, Features{}, options);
      ADD_FAILURE() << "change " << i << " was taken";
    } catch (const MapError& error) {
      EXPECT_EQ(error.code(), ErrorCode::kBadOptions) << "change " << i;
    }
  }
}

TEST(Verdict, Names) {
  EXPECT_STREQ(NameOf(Verdict::kLocalized), "localized");
  EXPECT_STREQ(NameOf(Verdict::kAmbiguous), "ambiguous");
  EXPECT_STREQ(NameOf(Verdict::kNotInMap), "not_in_map");
  EXPECT_STREQ(NameOf(Verdict::kBadImage), "bad_image");
}

}  // namespace
}  // namespace waystone
