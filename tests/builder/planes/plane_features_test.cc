// SPDX-License-Identifier: Apache-2.0
#include "builder/planes/plane_features.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "core/features/distance.h"
#include "core/features/keypoint_grid.h"
#include "core/geometry/angle.h"
#include "core/homography/homography.h"
#include "tests/builder/planes/made_scene.h"

namespace waystone {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;

Matrix3d Similarity(double scale, double angle_rad, double x_px, double y_px) {
  Matrix3d h = Matrix3d::Identity();
  h.topLeftCorner<2, 2>() = scale * Eigen::Rotation2Dd(angle_rad).toRotationMatrix();
  h.topRightCorner<2, 1>() = Vector2d(x_px, y_px);
  return h;
}

PlaneFeature FeatureAt(float x, float y) { return {{x, y, 8, 0}, 1, 1}; }

TEST(DistanceAt, IsSquaredForSiftAndLinearForBits) {
  EXPECT_NEAR(DistanceAt(FeatureType::kSift, 1), 2 * 256 * 256, 1e-6);
  EXPECT_NEAR(DistanceAt(FeatureType::kSift, 0.5), 0.25 * 2 * 256 * 256, 1e-6);
  EXPECT_NEAR(DistanceAt(FeatureType::kOrb, 0.5), 128, 1e-9);
  EXPECT_NEAR(DistanceAt(FeatureType::kAkaze, 1), 488, 1e-9);
  for (FeatureType type : {FeatureType::kSift, FeatureType::kOrb, FeatureType::kAkaze}) {
    EXPECT_EQ(DistanceAt(type, 0), 0);
  }
}

TEST(Transferred, FollowsASimilarity) {
  Random random(1);
  for (int trial = 0; trial < 100; ++trial) {
    const double scale = random.Uniform(0.3, 3);
    const double angle = random.Uniform(-kPi, kPi);
    const Matrix3d h = Similarity(scale, angle, random.Uniform(-200, 200), 40);
    const Keypoint k{
        static_cast<float>(random.Uniform(0, 640)), static_cast<float>(random.Uniform(0, 480)),
        static_cast<float>(random.Uniform(2, 60)), static_cast<float>(random.Uniform(0, 2 * kPi))};
    const Keypoint moved = Transferred(h, k);
    const Vector2d expected = Apply(h, Vector2d(k.x_px, k.y_px));
    EXPECT_NEAR(moved.x_px, expected.x(), 1e-3);
    EXPECT_NEAR(moved.y_px, expected.y(), 1e-3);
    EXPECT_NEAR(moved.scale_px / (scale * k.scale_px), 1, 1e-4);
    EXPECT_NEAR(std::remainder(moved.angle_rad - k.angle_rad - angle, 2 * kPi), 0, 1e-4);
    EXPECT_GE(moved.angle_rad, 0);
    EXPECT_LT(moved.angle_rad, 2 * kPi);
  }
}

TEST(Transferred, ByTheIdentityChangesNothing) {
  const Keypoint k{100, 50, 12, 6.1f};
  const Keypoint same = Transferred(3 * Matrix3d::Identity(), k);
  EXPECT_NEAR(same.x_px, k.x_px, 1e-4);
  EXPECT_NEAR(same.y_px, k.y_px, 1e-4);
  EXPECT_NEAR(same.scale_px, k.scale_px, 1e-4);
  EXPECT_NEAR(same.angle_rad, k.angle_rad, 1e-5);
}

TEST(Transferred, GrowsWhereAHomographyComesNearer) {
  Matrix3d h = Matrix3d::Identity();
  h(2, 0) = -0.001;  // nearer to the right
  EXPECT_GT(Transferred(h, {500, 240, 10, 0}).scale_px, Transferred(h, {100, 240, 10, 0}).scale_px);
}

TEST(DropSparseFeatures, KeepsPlentyAndWhatManySaw) {
  Plane plane;
  plane.descriptors = Descriptors(DescriptorBytes(FeatureType::kSift));
  const std::vector<int> votes = {2, 5, 2, 3, 2, 2, 4};
  for (int v : votes) {
    plane.features.push_back({.reference = {}, .votes = v, .visible = 5});
    plane.descriptors.Append(std::vector<uint8_t>(plane.descriptors.bytes(), v).data());
  }
  const auto kept = [&](int plenty, int min_votes) {
    Plane thinned = plane;
    DropSparseFeatures(plenty, min_votes, thinned);
    std::vector<int> left;
    for (size_t f = 0; f < thinned.features.size(); ++f) {
      left.push_back(thinned.features[f].votes);
      EXPECT_EQ(thinned.descriptors.row(static_cast<int>(f))[0], left.back());
    }
    return left;
  };
  EXPECT_EQ(kept(7, 3), votes) << "not more than plenty";
  EXPECT_EQ(kept(5, 3), (std::vector<int>{2, 5, 2, 3, 4})) << "the first of those alike stay";
  EXPECT_EQ(kept(1, 3), (std::vector<int>{5, 3, 4})) << "enough keyframes found them";
  EXPECT_EQ(kept(2, 5), (std::vector<int>{5, 4}));
}

TEST(KeepFeatures, KeepsFeaturesWithTheirDescriptors) {
  Random random(2);
  Plane plane;
  plane.descriptors = Descriptors(128);
  for (int i = 0; i < 10; ++i) {
    plane.features.push_back(FeatureAt(static_cast<float>(i), 0));
    plane.descriptors.Append(RandomDescriptor(random).data());
  }
  const Plane before = plane;
  const std::vector<int> kept = {0, 3, 9};
  KeepFeatures(kept, plane);
  ASSERT_EQ(plane.features.size(), 3u);
  ASSERT_EQ(plane.descriptors.rows(), 3);
  EXPECT_EQ(plane.descriptors.bytes(), 128);
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(plane.features[i], before.features[kept[i]]);
    EXPECT_TRUE(std::equal(plane.descriptors.row(i), plane.descriptors.row(i) + 128,
                           before.descriptors.row(kept[i])));
  }
  KeepFeatures({}, plane);
  EXPECT_TRUE(plane.features.empty());
  EXPECT_EQ(plane.descriptors.rows(), 0);
  EXPECT_EQ(plane.descriptors.bytes(), 128) << "so that it can grow again";
}

TEST(IsWithinReach, IsTheImageAndAMarginAroundIt) {
  EXPECT_TRUE(IsWithinReach({0, 0}, 640, 480, 0.1));
  EXPECT_TRUE(IsWithinReach({-63, -47}, 640, 480, 0.1));
  EXPECT_TRUE(IsWithinReach({703, 527}, 640, 480, 0.1));
  EXPECT_FALSE(IsWithinReach({-65, 100}, 640, 480, 0.1));
  EXPECT_FALSE(IsWithinReach({705, 100}, 640, 480, 0.1));
  EXPECT_FALSE(IsWithinReach({100, -49}, 640, 480, 0.1));
  EXPECT_FALSE(IsWithinReach({100, 529}, 640, 480, 0.1));
  EXPECT_FALSE(IsWithinReach({NAN, 100}, 640, 480, 0.1));
  EXPECT_FALSE(IsWithinReach({100, INFINITY}, 640, 480, 0.1));
}

// Features anywhere in the image, some of them at its very border.
Features RandomFeatures(int count, Random& random) {
  Features features{FeatureType::kSift, 200, 150, 200, 150, {}, Descriptors(128), {}};
  for (int i = 0; i < count; ++i) {
    const double x = i % 10 == 0 ? 199.9 : random.Uniform(0, 200);
    const double y = i % 15 == 0 ? 0 : random.Uniform(0, 150);
    features.keypoints.push_back({static_cast<float>(x), static_cast<float>(y), 8, 0});
    features.descriptors.Append(RandomDescriptor(random).data());
  }
  return features;
}

int MostAlikeByBruteForce(const Features& features, double radius_px, const Vector2d& position,
                          const uint8_t* descriptor, double max_distance) {
  int best = -1;
  for (int i = 0; i < features.size(); ++i) {
    const Keypoint& k = features.keypoints[i];
    if (std::hypot(k.x_px - position.x(), k.y_px - position.y()) > radius_px) continue;
    const int32_t distance =
        DescriptorDistance(features.type, descriptor, features.descriptors.row(i));
    if (distance > max_distance) continue;
    max_distance = distance;
    best = i;
  }
  return best;
}

TEST(KeypointGrid, FindsWhatBruteForceFinds) {
  Random random(3);
  const Features features = RandomFeatures(400, random);
  for (double radius : {1.5, 3.0, 8.0, 25.0}) {
    const KeypointGrid grid(features, radius);
    int found = 0;
    for (int trial = 0; trial < 500; ++trial) {
      const Vector2d position(random.Uniform(0, 200), random.Uniform(0, 150));
      const std::vector<uint8_t> descriptor = RandomDescriptor(random);
      const double limit = DistanceAt(features.type, random.Uniform(0.7, 1));
      const int index = grid.MostAlike(position, descriptor.data(), limit);
      found += index >= 0;
      EXPECT_EQ(index, MostAlikeByBruteForce(features, radius, position, descriptor.data(), limit))
          << "radius " << radius << " at " << position.transpose();
    }
    EXPECT_GT(found, 20) << "radius " << radius;
  }
}

TEST(KeypointGrid, FindsNothingOutsideTheImageOrTooFarAway) {
  Random random(4);
  const Features features = RandomFeatures(50, random);
  const KeypointGrid grid(features, 3);
  const Keypoint& k = features.keypoints[7];
  const uint8_t* descriptor = features.descriptors.row(7);
  EXPECT_EQ(grid.MostAlike({k.x_px, k.y_px}, descriptor, 0), 7);
  EXPECT_NE(grid.MostAlike({k.x_px + 3.5, k.y_px}, descriptor, 0), 7);
  EXPECT_EQ(grid.MostAlike({-1, 10}, descriptor, 1e9), -1);
  EXPECT_EQ(grid.MostAlike({10, 151}, descriptor, 1e9), -1);
  EXPECT_EQ(grid.MostAlike({NAN, 10}, descriptor, 1e9), -1);
  EXPECT_EQ(grid.MostAlike({10, INFINITY}, descriptor, 1e9), -1);
}

TEST(KeypointGrid, MayBeEmpty) {
  Random random(5);
  const Features none{FeatureType::kSift, 200, 150, 200, 150, {}, Descriptors(128), {}};
  EXPECT_EQ(KeypointGrid(none, 3).MostAlike({10, 10}, RandomDescriptor(random).data(), 1e9), -1);
}

}  // namespace
}  // namespace waystone
