// SPDX-License-Identifier: Apache-2.0
#include "core/homography/homology.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <Eigen/Geometry>
#include <cmath>
#include <limits>

#include "core/base/error.h"
#include "core/base/random.h"
#include "tests/core/homography/made_views.h"

namespace waystone {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kSigma_px = 0.5;
constexpr int kPairs = 60;

// A homography as it is measured from noisy points.
HomographyEstimate Measured(const Matrix3d& truth, Random& random, const Box& box = {}) {
  const auto estimate =
      RefineHomography(PairsOf(truth, kPairs, kSigma_px, random, box), Normalised(truth));
  EXPECT_TRUE(estimate);
  return estimate.value_or(HomographyEstimate{});
}

struct Counts {
  int same = 0;
  int two = 0;
  int invalid = 0;

  void Add(HomologyKind kind) {
    same += kind == HomologyKind::kSamePlane;
    two += kind == HomologyKind::kTwoPlanes;
    invalid += kind == HomologyKind::kInvalid;
  }
};

// Planes that differ enough for their homographies to: 6 px somewhere in the image.
bool Differ(const MadeViews& views, const MadePlane& m, const MadePlane& n) {
  return LargestDifference(views.HomographyOf(m), views.HomographyOf(n)) > 6;
}

TEST(ComputeEigenvalues, FindsTheClosestPairWhateverTheOrderAndScale) {
  for (const Vector3d& values :
       {Vector3d(1, 1.01, 3), Vector3d(3, 1, 1.01), Vector3d(1.01, 3, 1)}) {
    Random random(1);
    const Matrix3d basis = RandomHomography(random);
    const Matrix3d matrix = basis * (2.0 * values).asDiagonal() * basis.inverse();
    const HomologyEigenvalues found = ComputeEigenvalues(matrix);
    EXPECT_NEAR(found.scale, 2 * 1.005, 1e-6);
    EXPECT_NEAR(found.split, 0.01 / 1.005, 1e-6);
    EXPECT_NEAR(found.third, 3 / 1.005, 1e-6);
  }
}

TEST(ComputeEigenvalues, TheIdentityHasThreeOnes) {
  const HomologyEigenvalues found = ComputeEigenvalues(Matrix3d::Identity());
  EXPECT_DOUBLE_EQ(found.scale, 1);
  EXPECT_DOUBLE_EQ(found.split, 0);
  EXPECT_DOUBLE_EQ(found.third, 1);
}

TEST(ComputeEigenvalues, AComplexPairIsSplit) {
  Matrix3d turn = Matrix3d::Identity();
  turn.topLeftCorner<2, 2>() = Eigen::Rotation2Dd(0.1).matrix();
  const HomologyEigenvalues found = ComputeEigenvalues(turn * 4);
  EXPECT_GT(found.split, 0.05);
}

TEST(ComputeEigenvalues, ANegativeScaleCancels) {
  const Matrix3d matrix = Vector3d(-2, -2, -5).asDiagonal();
  const HomologyEigenvalues found = ComputeEigenvalues(matrix);
  EXPECT_NEAR(found.scale, -2, 1e-12);
  EXPECT_NEAR(found.third, 2.5, 1e-12);
}

// Eqs. (2) and (3). With H = K (R - t n^T / d) K^-1, the denominator of eq. (2) has a minus sign:
// by Sherman and Morrison (R - t n^T / d)^-1 = (I + u n^T / (d - n^T u)) R^-1 for u = R^-1 t.
TEST(TestHomology, TheThirdEigenvalueIsThatOfTheEquations) {
  Random random(2);
  for (int trial = 0; trial < 300; ++trial) {
    const MadeViews views = RandomViews(random);
    const MadePlane m = RandomPlane(random);
    const MadePlane n = RandomPlane(random);
    if (!Differ(views, m, n)) continue;
    const Vector3d u = views.r.transpose() * views.t;
    const Vector3d v = views.k * u / (1 - m.n.dot(u) / m.d);
    const Vector3d p = ((m.n / m.d - n.n / n.d).transpose() * views.k.inverse()).transpose();
    HomographyEstimate of_m;
    HomographyEstimate of_n;
    of_m.b_from_a = Normalised(views.HomographyOf(m));
    of_n.b_from_a = Normalised(views.HomographyOf(n));
    const Homology homology = TestHomology(of_m, of_n, {});
    const double third = 1 + v.dot(p);
    // A third eigenvalue near one can't be told from the pair.
    if (std::abs(third - 1) < 1e-3) continue;
    EXPECT_NEAR(homology.third_eigenvalue, third, 1e-4) << "trial " << trial;
    EXPECT_LT(homology.split, 1e-5);
    EXPECT_TRUE(homology.matrix.isApprox(Matrix3d::Identity() + v * p.transpose(), 1e-4));
  }
}

// What pairs of planes of one motion are found to be, once their homographies are measured so.
template <class Measure>
Counts CountPairs(int trials, Random& random, const Measure& measure) {
  Counts counts;
  for (int trial = 0; trial < trials; ++trial) {
    const MadeViews views = RandomViews(random);
    const MadePlane m = RandomPlane(random);
    const MadePlane n = RandomPlane(random);
    if (!Differ(views, m, n)) continue;
    counts.Add(
        TestHomology(measure(views.HomographyOf(m)), measure(views.HomographyOf(n)), {}).kind);
  }
  return counts;
}

TEST(TestHomology, TwoPlanesOfOneMotionAreTwoPlanes) {
  Random random(3);
  const Counts counts =
      CountPairs(300, random, [&](const Matrix3d& truth) { return Measured(truth, random); });
  const int all = counts.same + counts.two + counts.invalid;
  ASSERT_GT(all, 200);
  EXPECT_GE(counts.two, 0.95 * all) << counts.same << " same, " << counts.invalid << " invalid";
}

// A lens that distorts moves neighbours alike: however many matches a plane has, its homography is
// no better than that.
TEST(TestHomology, TwoPlanesSeenThroughADistortingLensAreTwoPlanes) {
  constexpr double kDistortion = -0.01;  // of the squared distance, in half widths
  const Eigen::Vector2d centre(kMadeWidth / 2.0, kMadeHeight / 2.0);
  const auto distorted = [&](const Eigen::Vector2d& x) -> Eigen::Vector2d {
    return centre + (1 + kDistortion * ((x - centre) / centre.x()).squaredNorm()) * (x - centre);
  };
  Random random(5);
  const Counts counts = CountPairs(200, random, [&](const Matrix3d& truth) {
    PointPairs pairs = PairsOf(truth, 300, 0.3, random, {40, 40, 560, 400});
    for (Eigen::Vector2d& x : pairs.a) x = distorted(x);
    for (Eigen::Vector2d& x : pairs.b) x = distorted(x);
    return RefineHomography(pairs, Normalised(truth)).value_or(HomographyEstimate{});
  });
  const int all = counts.same + counts.two + counts.invalid;
  ASSERT_GT(all, 130);
  EXPECT_GE(counts.two, 0.9 * all) << counts.same << " same, " << counts.invalid << " invalid";
}

TEST(TestHomology, PlanesSideBySideAreTwoPlanes) {
  Random random(4);
  Counts counts;
  for (int trial = 0; trial < 300; ++trial) {
    const MadeViews views = RandomViews(random);
    const MadePlane m = RandomPlane(random);
    const MadePlane n = RandomPlane(random);
    if (!Differ(views, m, n)) continue;
    counts.Add(TestHomology(Measured(views.HomographyOf(m), random, {0, 0, 320, 480}),
                            Measured(views.HomographyOf(n), random, {320, 0, 320, 480}), {})
                   .kind);
  }
  const int all = counts.same + counts.two + counts.invalid;
  ASSERT_GT(all, 200);
  // Each plane fills a half: what differs by little there can't be told apart from one plane.
  EXPECT_GE(counts.two, 0.85 * all) << counts.same << " same, " << counts.invalid << " invalid";
  EXPECT_LE(counts.invalid, 0.05 * all);
}

TEST(TestHomology, OnePlaneMeasuredTwiceIsTheSamePlane) {
  Random random(5);
  for (const bool halves : {false, true}) {
    Counts counts;
    for (int trial = 0; trial < 300; ++trial) {
      const MadeViews views = RandomViews(random);
      const Matrix3d truth = views.HomographyOf(RandomPlane(random));
      const Box left = halves ? Box{0, 0, 320, 480} : Box{};
      const Box right = halves ? Box{320, 0, 320, 480} : Box{};
      counts.Add(
          TestHomology(Measured(truth, random, left), Measured(truth, random, right), {}).kind);
    }
    EXPECT_GE(counts.same, 0.95 * 300)
        << counts.two << " two, " << counts.invalid << " invalid, halves " << halves;
  }
}

TEST(TestHomology, AHomographyOfAnotherMotionIsInvalid) {
  Random random(6);
  Counts counts;
  for (int trial = 0; trial < 300; ++trial) {
    const MadeViews views = RandomViews(random);
    const MadeViews others = RandomViews(random);
    counts.Add(TestHomology(Measured(views.HomographyOf(RandomPlane(random)), random),
                            Measured(others.HomographyOf(RandomPlane(random)), random), {})
                   .kind);
  }
  EXPECT_GE(counts.invalid, 0.9 * 300) << counts.same << " same, " << counts.two << " two";
}

TEST(TestHomology, SwappingThePlanesInvertsTheThirdEigenvalue) {
  Random random(7);
  for (int trial = 0; trial < 50; ++trial) {
    const MadeViews views = RandomViews(random);
    const HomographyEstimate m = Measured(views.HomographyOf(RandomPlane(random)), random);
    const HomographyEstimate n = Measured(views.HomographyOf(RandomPlane(random)), random);
    const Homology forth = TestHomology(m, n, {});
    const Homology back = TestHomology(n, m, {});
    if (std::abs(forth.third_eigenvalue - 1) < 0.1) continue;
    EXPECT_NEAR(forth.third_eigenvalue * back.third_eigenvalue, 1, 0.05) << "trial " << trial;
  }
}

TEST(TestHomology, IsDeterministicForASeed) {
  Random random(8);
  const MadeViews views = RandomViews(random);
  const HomographyEstimate m = Measured(views.HomographyOf(RandomPlane(random)), random);
  const HomographyEstimate n = Measured(views.HomographyOf(RandomPlane(random)), random);
  const Homology once = TestHomology(m, n, {});
  const Homology again = TestHomology(m, n, {});
  EXPECT_EQ(once.kind, again.kind);
  EXPECT_EQ(once.matrix, again.matrix);
  EXPECT_EQ(once.split_sigma, again.split_sigma);
  EXPECT_EQ(once.third_sigma, again.third_sigma);
  HomologyOptions other;
  other.seed = 2;
  EXPECT_NE(TestHomology(m, n, other).split_sigma, once.split_sigma);
}

TEST(HaveHomology, PlanesOfOneSceneDo) {
  Random random(9);
  int of_one = 0;
  int of_two = 0;
  for (int trial = 0; trial < 100; ++trial) {
    const MadeViews views = RandomViews(random);
    const MadeViews others = trial % 2 == 0 ? views : RandomViews(random);
    const HomographyEstimate m = Measured(views.HomographyOf(RandomPlane(random)), random);
    const HomographyEstimate n = Measured(others.HomographyOf(RandomPlane(random)), random);
    (trial % 2 == 0 ? of_one : of_two) += HaveHomology(m, n, {});
  }
  EXPECT_GE(of_one, 47);
  EXPECT_LE(of_two, 5);
}

TEST(TestHomology, ASingularHomographyIsInvalid) {
  HomographyEstimate singular;
  singular.b_from_a = Matrix3d::Zero();
  EXPECT_EQ(TestHomology(singular, HomographyEstimate{}, {}).kind, HomologyKind::kInvalid);
}

TEST(HomologyOptions, OutOfTheirRangeAreRefused) {
  const auto expect_refused = [](const HomologyOptions& options) {
    try {
      options.Check();
      ADD_FAILURE() << options.max_sigmas << ", " << options.draws << " were taken";
    } catch (const MapError& error) {
      EXPECT_EQ(error.code(), ErrorCode::kBadOptions);
    }
  };
  expect_refused({.max_sigmas = 0});
  expect_refused({.max_sigmas = std::numeric_limits<double>::quiet_NaN()});
  expect_refused({.draws = 9});
  EXPECT_NO_THROW(HomologyOptions{}.Check());
}

}  // namespace
}  // namespace waystone
