// SPDX-License-Identifier: Apache-2.0
#include "builder/planes/options.h"

#include <gtest/gtest.h>

#include "builder/planes/plane_tracker.h"
#include "core/base/error.h"

namespace waystone {
namespace {

TEST(PlaneLayerOptions, OutOfTheirRangeAreRefused) {
  const auto expect_refused = [](auto change) {
    PlaneLayerOptions options;
    change(options);
    try {
      PlaneTracker tracker(options);
      ADD_FAILURE() << "an option out of its range was taken";
    } catch (const MapError& error) {
      EXPECT_EQ(error.code(), ErrorCode::kBadOptions);
    }
  };
  expect_refused([](auto& o) { o.min_tracked = 4; });
  expect_refused([](auto& o) { o.reacquire_px = 0; });
  expect_refused([](auto& o) { o.reacquire_distance = 1.1; });
  expect_refused([](auto& o) { o.max_extrapolation = -0.1; });
  expect_refused([](auto& o) { o.min_anchored = 1.1; });
  expect_refused([](auto& o) { o.min_vote_share = -0.1; });
  expect_refused([](auto& o) { o.min_features = 3; });
  expect_refused([](auto& o) { o.min_features_unconfirmed = o.min_features - 1; });
  expect_refused([](auto& o) { o.match.max_ratio = 0; });
  expect_refused([](auto& o) { o.segmentation.min_inliers = 0; });
  expect_refused([](auto& o) { o.rotation.focal_steps = 1; });
  expect_refused([](auto& o) { o.fusion.min_votes = 0; });
  EXPECT_NO_THROW(PlaneLayerOptions{}.Check());
}

TEST(FusionOptions, OutOfTheirRangeAreRefused) {
  const auto expect_refused = [](auto change) {
    FusionOptions options;
    change(options);
    EXPECT_THROW(options.Check(), MapError);
  };
  expect_refused([](auto& o) { o.min_votes = 0; });
  expect_refused([](auto& o) { o.votes_per_feature = 0; });
  expect_refused([](auto& o) { o.max_voters = 0; });
  expect_refused([](auto& o) { o.min_inliers = 4; });
  expect_refused([](auto& o) { o.min_support = 1.1; });
  expect_refused([](auto& o) { o.min_overlap = -0.1; });
  expect_refused([](auto& o) { o.min_within_reach = 1.1; });
  expect_refused([](auto& o) { o.neighbours = 1; });
  expect_refused([](auto& o) { o.max_vote_distance = 0; });
  expect_refused([](auto& o) { o.max_vote_ratio = 1.1; });
  expect_refused([](auto& o) { o.index.training_rows = 0; });
  expect_refused([](auto& o) { o.probes = 0; });
  expect_refused([](auto& o) { o.max_moved_px = 0; });
  EXPECT_NO_THROW(FusionOptions{}.Check());
}

}  // namespace
}  // namespace waystone
