// SPDX-License-Identifier: Apache-2.0
#include "core/homography/plane_in_space.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "core/base/error.h"
#include "core/geometry/angle.h"
#include "tests/core/homography/made_views.h"

namespace waystone {
namespace {

constexpr double kSigma = 0.001;  // half a pixel at a focal length of 500 px

// What a reference camera sees: planes n . X = d and views X_view = R X - t.
struct MadeSpace {
  std::vector<MadePlane> planes;
  std::vector<MadeViews> views;
};

MadeSpace RandomSpace(Random& random, int planes, int views) {
  MadeSpace space;
  for (int p = 0; p < planes; ++p) space.planes.push_back(RandomPlane(random));
  for (int v = 0; v < views; ++v) {
    MadeViews view = RandomViews(random);
    view.k.setIdentity();  // on the image plane z = 1
    space.views.push_back(view);
  }
  return space;
}

// Nine points of a patch of the plane's own, seen with noise.
PlaneSighting Sighting(const MadeSpace& space, int plane, int view, double sigma, Random& random) {
  PlaneSighting seen{plane, view, {}};
  const Eigen::Matrix3d h = space.views[view].HomographyOf(space.planes[plane]);
  const double left = -0.5 + 0.25 * (plane % 4);
  for (int i = 0; i < 9; ++i) {
    const int row = i / 3;
    const Eigen::Vector2d a(left + 0.12 * (i % 3), -0.3 + 0.3 * row);
    const Eigen::Vector2d noise(random.Normal(), random.Normal());
    seen.points.Add(a, Apply(h, a) + sigma * noise);
  }
  return seen;
}

std::vector<PlaneSighting> Sightings(const MadeSpace& space, double sigma, Random& random) {
  std::vector<PlaneSighting> sightings;
  for (size_t p = 0; p < space.planes.size(); ++p) {
    for (size_t v = 0; v < space.views.size(); ++v) {
      sightings.push_back(Sighting(space, static_cast<int>(p), static_cast<int>(v), sigma, random));
    }
  }
  return sightings;
}

SpaceEstimate Find(const MadeSpace& space, std::span<const PlaneSighting> sightings) {
  SpaceOptions options;
  options.point_sigma = kSigma;
  return FindPlanesInSpace(static_cast<int>(space.planes.size()),
                           static_cast<int>(space.views.size()), sightings, options);
}

double AngleOff(const PlaneInSpace& found, const MadePlane& truth) {
  return std::acos(std::min(1.0, found.normal.dot(truth.n)));
}

// Distance over its truth, in the truth's unit.
double RatioOff(const SpaceEstimate& estimate, const MadeSpace& space, size_t p) {
  const double unit = space.planes[estimate.unit_plane].d;
  return std::abs(estimate.planes[p].distance * unit / space.planes[p].d - 1);
}

TEST(PlanesInSpace, NormalsAndDistancesOfSeveralPlanesInSeveralViews) {
  Random random(11);
  int sure = 0;
  int all = 0;
  for (int trial = 0; trial < 40; ++trial) {
    const MadeSpace space = RandomSpace(random, 4, 5);
    const SpaceEstimate estimate = Find(space, Sightings(space, kSigma, random));
    ASSERT_GE(estimate.unit_plane, 0);
    EXPECT_NEAR(estimate.planes[estimate.unit_plane].distance, 1, 1e-9);
    EXPECT_LT(estimate.sigmas, 1.3);
    for (size_t p = 0; p < space.planes.size(); ++p, ++all) {
      const PlaneInSpace& plane = estimate.planes[p];
      if (plane.error != SpaceError::kNone) continue;
      ++sure;
      const double angle = AngleOff(plane, space.planes[p]);
      const double ratio = RatioOff(estimate, space, p);
      EXPECT_LT(angle, 5 * kDegree) << trial << ' ' << p;
      EXPECT_LT(ratio, 0.1) << trial << ' ' << p;
      EXPECT_LT(angle, 5 * plane.normal_sigma_rad + 1e-9) << trial << ' ' << p;
      EXPECT_LE(ratio, 5 * plane.distance_sigma + 1e-9) << trial << ' ' << p;
    }
  }
  EXPECT_GT(sure, 0.9 * all);
}

TEST(PlanesInSpace, MotionsAreThoseOfTheViews) {
  Random random(12);
  const MadeSpace space = RandomSpace(random, 3, 4);
  const SpaceEstimate estimate = Find(space, Sightings(space, 1e-9, random));
  const double unit = space.planes[estimate.unit_plane].d;
  for (size_t v = 0; v < space.views.size(); ++v) {
    ASSERT_TRUE(estimate.views[v]);
    EXPECT_TRUE(estimate.views[v]->rotation.isApprox(space.views[v].r, 1e-5));
    EXPECT_TRUE((unit * estimate.views[v]->translation).isApprox(-space.views[v].t, 1e-4));
  }
}

// Planes and views that hang together by others alone.
TEST(PlanesInSpace, ReachesWhatHangsTogether) {
  Random random(13);
  const MadeSpace space = RandomSpace(random, 3, 4);
  std::vector<PlaneSighting> sightings;
  for (const auto& [plane, view] :
       {std::pair{0, 0}, {0, 1}, {1, 0}, {1, 1}, {1, 2}, {1, 3}, {2, 2}, {2, 3}}) {
    sightings.push_back(Sighting(space, plane, view, 1e-6, random));
  }
  const SpaceEstimate estimate = Find(space, sightings);
  for (size_t p = 0; p < 3; ++p) {
    EXPECT_LT(AngleOff(estimate.planes[p], space.planes[p]), 0.5 * kDegree) << p;
    EXPECT_LT(RatioOff(estimate, space, p), 0.02) << p;
  }
}

// A homography alone has two decompositions; which is right isn't guessed.
TEST(PlanesInSpace, OnePlaneInOneViewIsAmbiguousOrRight) {
  Random random(14);
  int ambiguous = 0;
  for (int trial = 0; trial < 40; ++trial) {
    const MadeSpace space = RandomSpace(random, 1, 1);
    const SpaceEstimate estimate = Find(space, Sightings(space, kSigma, random));
    const PlaneInSpace& plane = estimate.planes[0];
    ambiguous += plane.error == SpaceError::kAmbiguous ? 1 : 0;
    if (plane.error != SpaceError::kNone) continue;
    EXPECT_LT(AngleOff(plane, space.planes[0]), 10 * kDegree) << trial;
  }
  EXPECT_GT(ambiguous, 10);
}

TEST(PlanesInSpace, AWrongHomographyIsOutvoted) {
  Random random(15);
  for (int trial = 0; trial < 10; ++trial) {
    const MadeSpace space = RandomSpace(random, 3, 5);
    std::vector<PlaneSighting> sightings = Sightings(space, kSigma, random);
    // Plane 1 in view 2 is a patch somewhere else.
    const MadeSpace other = RandomSpace(random, 3, 5);
    sightings[1 * 5 + 2] = Sighting(other, 1, 2, kSigma, random);
    const SpaceEstimate estimate = Find(space, sightings);
    for (size_t p = 0; p < 3; ++p) {
      if (estimate.planes[p].error != SpaceError::kNone) continue;
      EXPECT_LT(AngleOff(estimate.planes[p], space.planes[p]), 6 * kDegree) << trial << ' ' << p;
    }
  }
}

TEST(PlanesInSpace, ACameraThatOnlyTurnsTellsNothing) {
  Random random(16);
  MadeSpace space = RandomSpace(random, 3, 4);
  for (MadeViews& view : space.views) view.t.setZero();
  for (const PlaneInSpace& plane : Find(space, Sightings(space, kSigma, random)).planes) {
    EXPECT_NE(plane.error, SpaceError::kNone);
  }
  const SpaceEstimate exact = Find(space, Sightings(space, 1e-7, random));
  EXPECT_EQ(exact.unit_plane, -1);
  for (const PlaneInSpace& plane : exact.planes) {
    EXPECT_EQ(plane.error, SpaceError::kNoParallax);
  }
}

TEST(PlanesInSpace, NothingSeenIsNothingKnown) {
  const SpaceEstimate estimate = FindPlanesInSpace(2, 3, {});
  EXPECT_EQ(estimate.planes.size(), 2U);
  EXPECT_EQ(estimate.planes[0].distance, 0);
  SpaceOptions options;
  options.point_sigma = 0;
  EXPECT_THROW(FindPlanesInSpace(1, 1, {}, options), MapError);
}

}  // namespace
}  // namespace waystone
