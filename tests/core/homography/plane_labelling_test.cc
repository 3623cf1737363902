// SPDX-License-Identifier: Apache-2.0
#include "core/homography/plane_labelling.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "core/base/error.h"
#include "tests/core/homography/made_views.h"

namespace waystone {
namespace {

constexpr double kNoise_px = 0.5;

// Two walls side by side, the first 120 matches on the left one, the next 80 on the right one, and
// 60 mismatches.
struct TwoWalls {
  MatchedPoints points;
  Eigen::Matrix3d left;
  Eigen::Matrix3d right;

  explicit TwoWalls(uint64_t seed) {
    Random random(seed);
    MadeViews views = RandomViews(random);
    views.t = Eigen::Vector3d(0.3, 0.1, 0.2);
    left = Normalised(views.HomographyOf({Eigen::Vector3d(0.3, 0, 1).normalized(), 4}));
    right = Normalised(views.HomographyOf({Eigen::Vector3d(-0.6, 0, 1).normalized(), 3}));
    Add(PairsOf(left, 120, kNoise_px, random, {20, 20, 280, 440}));
    Add(PairsOf(right, 80, kNoise_px, random, {340, 20, 280, 440}));
    for (int i = 0; i < 60; ++i) {
      points.from.push_back(RandomPoint(random));
      points.to.push_back(RandomPoint(random));
    }
  }

  void Add(const PointPairs& pairs) {
    points.from.insert(points.from.end(), pairs.a.begin(), pairs.a.end());
    points.to.insert(points.to.end(), pairs.b.begin(), pairs.b.end());
  }
};

int CountOf(const std::vector<int>& labels, int from, int to, int label) {
  return static_cast<int>(std::count(labels.begin() + from, labels.begin() + to, label));
}

TEST(PlaneLabelling, GivesEachMatchToItsPlaneAndMismatchesToNone) {
  for (uint64_t seed = 1; seed <= 10; ++seed) {
    const TwoWalls walls(seed);
    const Neighbourhoods neighbourhoods(walls.points.from, 20);
    PlaneLabelling labelling(walls.points, neighbourhoods, {});
    labelling.Add(walls.left, 1, false);
    labelling.Add(walls.right, 1, false);
    labelling.Settle();
    EXPECT_GE(CountOf(labelling.labels(), 0, 120, 0), 112) << "seed " << seed;
    EXPECT_GE(CountOf(labelling.labels(), 120, 200, 1), 72) << "seed " << seed;
    EXPECT_GE(CountOf(labelling.labels(), 200, 260, kNoPlane), 54) << "seed " << seed;
  }
}

TEST(PlaneLabelling, MeasuresTheNoiseOfAPlane) {
  const TwoWalls walls(1);
  const Neighbourhoods neighbourhoods(walls.points.from, 20);
  PlaneLabelling labelling(walls.points, neighbourhoods, {});
  labelling.Add(walls.left, 2, false);
  labelling.Add(walls.right, 2, false);
  labelling.Settle();
  const double first = labelling.sigma_px(0);
  EXPECT_GT(first, 0.5 * kNoise_px);
  EXPECT_LT(first, 2 * kNoise_px);
}

TEST(PlaneLabelling, AFixedPlaneKeepsItsHomographyAndNoise) {
  const TwoWalls walls(2);
  const Neighbourhoods neighbourhoods(walls.points.from, 20);
  Eigen::Matrix3d shifted = walls.left;
  shifted(0, 2) += 0.4;
  PlaneLabelling labelling(walls.points, neighbourhoods, {});
  labelling.Add(shifted, 0.7, true);
  labelling.Settle();
  EXPECT_EQ(labelling.to_from(0), shifted);
  EXPECT_EQ(labelling.sigma_px(0), 0.7);
  EXPECT_FALSE(labelling.RowsOf(0).empty());
}

TEST(PlaneLabelling, ATruePlaneLowersTheEnergyAndASecondCopyOfItRaisesIt) {
  for (uint64_t seed = 1; seed <= 10; ++seed) {
    const TwoWalls walls(seed);
    const Neighbourhoods neighbourhoods(walls.points.from, 20);
    PlaneLabelling labelling(walls.points, neighbourhoods, {});
    labelling.Settle();
    const double none = labelling.Energy();
    labelling.Add(walls.left, 1, false);
    labelling.Settle();
    const double one = labelling.Energy();
    labelling.Add(walls.right, 1, false);
    labelling.Settle();
    const double both = labelling.Energy();
    labelling.Add(walls.right, 1, false);
    labelling.Settle();
    EXPECT_LT(one, none) << "seed " << seed;
    EXPECT_LT(both, one) << "seed " << seed;
    EXPECT_GT(labelling.Energy(), both) << "seed " << seed;
  }
}

// Energy of labels as it is defined (Isack and Boykov 2012, eq. 2), of planes whose noise is 1 px.
double EnergyOf(const std::vector<int>& labels, const MatchedPoints& points,
                const Neighbourhoods& neighbourhoods, const std::vector<Eigen::Matrix3d>& planes,
                const LabellingOptions& options) {
  double energy = options.plane_cost * static_cast<double>(planes.size());
  for (int row = 0; row < points.size(); ++row) {
    const int label = labels[row];
    if (label == kNoPlane) {
      energy += options.outlier_cost;
      continue;
    }
    const double error2 = SymmetricTransferError2(planes[label], planes[label].inverse(),
                                                  points.from[row], points.to[row]);
    energy += (options.tail + 2) / 2 * std::log(1 + error2 / options.tail);
    for (int i = 0; i < options.companions; ++i) {
      const int other = labels[neighbourhoods.of(row)[i]];
      if (other != label && other != kNoPlane) energy += options.smoothness / options.companions;
    }
  }
  return energy;
}

// Matches that lie on or between two planes 3 px apart: no other labels cost less.
TEST(PlaneLabelling, EndsAtTheLeastEnergyOfAllLabels) {
  constexpr int kMatches = 9;
  LabellingOptions options;
  options.companions = 3;
  options.rounds = 1;
  for (uint64_t seed = 1; seed <= 30; ++seed) {
    Random random(seed);
    std::vector<Eigen::Matrix3d> planes(2, Eigen::Matrix3d::Identity());
    planes[1](0, 2) = 3;
    MatchedPoints points;
    for (int i = 0; i < kMatches; ++i) {
      points.from.push_back(RandomPoint(random));
      points.to.push_back(
          RandomPoint(random, points.from.back().x() - 1, points.from.back().y() - 1, 5, 2));
    }
    const Neighbourhoods neighbourhoods(points.from, 3);
    PlaneLabelling labelling(points, neighbourhoods, options);
    for (const Eigen::Matrix3d& plane : planes) labelling.Add(plane, 1, true);
    labelling.Settle();
    std::vector<int> labels(kMatches, kNoPlane);
    double least = EnergyOf(labels, points, neighbourhoods, planes, options);
    for (size_t digit = 0; digit < labels.size();) {  // counts through all labels
      digit = 0;
      while (digit < labels.size() && ++labels[digit] == 2) labels[digit++] = kNoPlane;
      least = std::min(least, EnergyOf(labels, points, neighbourhoods, planes, options));
    }
    const double own = EnergyOf(labelling.labels(), points, neighbourhoods, planes, options);
    EXPECT_NEAR(labelling.Energy(), own, 1e-3) << "seed " << seed;
    EXPECT_NEAR(own, least, 1e-3) << "seed " << seed;
  }
}

TEST(PlaneLabelling, RemovingAPlaneFreesItsMatchesAndKeepsTheOthers) {
  const TwoWalls walls(3);
  const Neighbourhoods neighbourhoods(walls.points.from, 20);
  PlaneLabelling labelling(walls.points, neighbourhoods, {});
  labelling.Add(walls.left, 1, false);
  labelling.Add(walls.right, 1, false);
  labelling.Settle();
  const std::vector<int> right = labelling.RowsOf(1);
  labelling.Remove(0);
  EXPECT_EQ(labelling.planes(), 1);
  EXPECT_EQ(labelling.RowsOf(0), right);
  EXPECT_EQ(CountOf(labelling.labels(), 0, 260, 0), static_cast<int>(right.size()));
}

TEST(PlaneLabelling, NoMatchesAreNoError) {
  const MatchedPoints points;
  const Neighbourhoods neighbourhoods(points.from, 20);
  PlaneLabelling labelling(points, neighbourhoods, {});
  labelling.Add(Eigen::Matrix3d::Identity(), 1, false);
  labelling.Settle();
  EXPECT_TRUE(labelling.RowsOf(0).empty());
}

}  // namespace
}  // namespace waystone
