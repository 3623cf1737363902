// SPDX-License-Identifier: Apache-2.0
#include "core/homography/plane_in_space.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/check.h"
#include "core/geometry/decompose_homography.h"
#include "core/geometry/rotation.h"
#include "core/homography/space_fit.h"

namespace waystone {
namespace {

constexpr int kSeedSteps = 6;  // of refinement, before solutions are compared

// A sighting with its homography, of which the middle singular value is 1 and which keeps points in
// front of the cameras.
struct Measured {
  const PlaneSighting* seen = nullptr;
  Eigen::Matrix3d view_from_reference = Eigen::Matrix3d::Identity();
  double parallax = 0;  // difference of the outer singular values: about |t| / d
};

std::optional<Measured> MeasureHomography(const PlaneSighting& seen) {
  const auto h = HomographyByDlt(seen.points);
  if (!h) return std::nullopt;
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(*h);
  const Eigen::Vector3d& values = svd.singularValues();
  if (!(values(2) > 1e-9 * values(0))) return std::nullopt;
  int in_front = 0;
  for (const Eigen::Vector2d& a : seen.points.a) {
    in_front += (*h * a.homogeneous()).z() > 0 ? 1 : -1;
  }
  if (std::abs(in_front) != seen.points.size()) return std::nullopt;
  const double sign = in_front > 0 ? 1 : -1;
  return Measured{&seen, sign / values(1) * *h, (values(0) - values(2)) / values(1)};
}

// The motions of a sighting's homography whose plane lies in front of the reference camera.
std::vector<PlaneMotion> MotionsInFront(const Measured& measured) {
  std::vector<PlaneMotion> found;
  const std::vector<Eigen::Vector2d>& points = measured.seen->points.a;
  for (PlaneMotion motion : DecomposeHomography(measured.view_from_reference)) {
    if (motion.normal.dot(points.front().homogeneous()) < 0) {
      motion.normal *= -1;
      motion.translation *= -1;
    }
    const bool in_front = std::ranges::all_of(
        points, [&](const auto& a) { return motion.normal.dot(a.homogeneous()) > 0; });
    if (in_front) found.push_back(motion);
  }
  return found;
}

// A view's motion by planes that are known: H maps the directions across a plane's normal as R
// does, and t = (H - R) m / |m|^2.
std::optional<ViewMotion> MotionBy(const SpaceModel& model, std::span<const Measured> measured,
                                   int view) {
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  std::vector<std::pair<Eigen::Matrix3d, Eigen::Vector3d>> scaled;
  for (const Measured& one : measured) {
    const auto& m = model.planes[one.seen->plane];
    if (one.seen->view != view || !m) continue;
    const Eigen::Vector3d n = m->normalized();
    const Eigen::Vector3d u = n.unitOrthogonal();
    const Eigen::Vector3d w = n.cross(u);
    const Eigen::Matrix3d& h = one.view_from_reference;
    const double scale = 2 / ((h * u).norm() + (h * w).norm());
    const Eigen::Vector3d to_u = scale * h * u;
    const Eigen::Vector3d to_w = scale * h * w;
    const double weight = one.seen->points.size();
    sum += weight * (to_u * u.transpose() + to_w * w.transpose() +
                     to_u.cross(to_w) * u.cross(w).transpose());
    scaled.emplace_back(scale * h, *m);
  }
  if (scaled.empty()) return std::nullopt;
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(sum, Eigen::ComputeFullU | Eigen::ComputeFullV);
  ViewMotion motion;
  motion.rotation = svd.matrixU() * svd.matrixV().transpose();
  if (motion.rotation.determinant() < 0) return std::nullopt;
  for (const auto& [h, m] : scaled) {
    motion.translation += (h - motion.rotation) * m / m.squaredNorm();
  }
  motion.translation /= static_cast<double>(scaled.size());
  return motion;
}

// A plane by views whose motion is known: b x (R a + t (m . a)) = 0 is linear in m.
std::optional<Eigen::Vector3d> PlaneBy(const SpaceModel& model,
                                       std::span<const PlaneSighting> sightings, int plane) {
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  for (const PlaneSighting& seen : sightings) {
    const auto& motion = model.views[seen.view];
    if (seen.plane != plane || !motion) continue;
    for (int i = 0; i < seen.points.size(); ++i) {
      const Eigen::Vector3d x = seen.points.a[i].homogeneous();
      const Eigen::Vector3d turned = motion->rotation * x;
      for (int row = 0; row < 2; ++row) {
        const double b = seen.points.b[i](row);
        const Eigen::Vector3d equation =
            (b * motion->translation.z() - motion->translation(row)) * x;
        normal += equation * equation.transpose();
        right += equation * (turned(row) - b * turned.z());
      }
    }
  }
  const Eigen::LDLT<Eigen::Matrix3d> solver(normal);
  if (!(normal.trace() > 0) || solver.info() != Eigen::Success) return std::nullopt;
  const Eigen::Vector3d m = solver.solve(right);
  return m.allFinite() && m.norm() > 1e-9 ? std::optional(m) : std::nullopt;
}

// Adds every plane and view that follows from what is already known.
void Grow(SpaceModel& model, std::span<const PlaneSighting> sightings,
          std::span<const Measured> measured) {
  for (bool more = true; more;) {
    more = false;
    for (size_t p = 0; p < model.planes.size(); ++p) {
      if (model.planes[p]) continue;
      model.planes[p] = PlaneBy(model, sightings, static_cast<int>(p));
      more |= model.planes[p].has_value();
    }
    for (size_t v = 0; v < model.views.size(); ++v) {
      if (model.views[v]) continue;
      model.views[v] = MotionBy(model, measured, static_cast<int>(v));
      more |= model.views[v].has_value();
    }
  }
}

// The solutions that the decompositions of the best sightings grow to, best first.
std::vector<SpaceModel> Solutions(int planes, int views, std::span<const PlaneSighting> sightings,
                                  const SpaceOptions& options) {
  std::vector<Measured> measured;
  for (const PlaneSighting& seen : sightings) {
    if (const auto one = MeasureHomography(seen)) measured.push_back(*one);
  }
  std::ranges::stable_sort(measured, std::ranges::greater(), &Measured::parallax);
  std::vector<SpaceModel> solutions;
  for (size_t i = 0; i < measured.size() && std::cmp_less(i, options.seeds); ++i) {
    const Measured& seed = measured[i];
    if (seed.parallax < 3 * options.point_sigma) break;
    for (const PlaneMotion& motion : MotionsInFront(seed)) {
      SpaceModel model;
      model.planes.resize(planes);
      model.views.resize(views);
      model.planes[seed.seen->plane] = motion.normal;
      model.views[seed.seen->view] = ViewMotion{motion.b_from_a, motion.translation};
      Grow(model, sightings, measured);
      RefineSpace(model, sightings, options, kSeedSteps);
      solutions.push_back(std::move(model));
    }
  }
  std::ranges::stable_sort(solutions, {}, &SpaceModel::cost);
  return solutions;
}

// Planes for which another solution explains the points nearly as well with another normal.
std::vector<bool> AmbiguousPlanes(const SpaceModel& best, std::span<SpaceModel> rivals,
                                  std::span<const PlaneSighting> sightings,
                                  const SpaceOptions& options, double scale) {
  std::vector<bool> ambiguous(best.planes.size(), false);
  const double limit = best.cost + scale * options.rival_sigmas * options.rival_sigmas;
  for (SpaceModel& rival : rivals) {
    if (rival.cost > 4 * limit) break;  // hopeless after its first steps; sorted by that cost
    RefineSpace(rival, sightings, options, options.max_steps);
    if (rival.cost > limit) continue;
    for (size_t p = 0; p < ambiguous.size(); ++p) {
      if (!best.planes[p]) continue;
      ambiguous[p] = ambiguous[p] || !rival.planes[p] ||
                     AngleBetween(*best.planes[p], *rival.planes[p]) > options.rival_angle_rad;
    }
  }
  return ambiguous;
}

int UnitPlane(const SpaceModel& model, std::span<const PlaneSighting> sightings) {
  std::vector<int> points(model.planes.size());
  for (const PlaneSighting& seen : sightings) {
    if (model.planes[seen.plane] && model.views[seen.view]) {
      points[seen.plane] += seen.points.size();
    }
  }
  return static_cast<int>(std::ranges::max_element(points) - points.begin());
}

PlaneInSpace DescribePlane(const Eigen::Vector3d& m, const Eigen::Matrix3d& covariance, double unit,
                           const SpaceOptions& options) {
  PlaneInSpace plane;
  const double length = m.norm();
  plane.normal = m / length;
  plane.distance = unit / length;
  const Eigen::Matrix3d across =
      Eigen::Matrix3d::Identity() - plane.normal * plane.normal.transpose();
  plane.normal_sigma_rad = WorstAxisSigma(across * covariance * across) / length;
  plane.distance_sigma =
      std::sqrt(std::max(0.0, plane.normal.dot(covariance * plane.normal))) / length;
  const bool sure = plane.normal_sigma_rad <= options.max_normal_sigma_rad &&
                    plane.distance_sigma <= options.max_distance_sigma;
  plane.error = sure ? SpaceError::kNone : SpaceError::kUncertain;
  return plane;
}

}  // namespace

SpaceEstimate FindPlanesInSpace(int planes, int views, std::span<const PlaneSighting> sightings,
                                const SpaceOptions& options) {
  options.Check();
  for (const PlaneSighting& seen : sightings) {
    WS_CHECK(seen.plane >= 0 && seen.plane < planes, "no such plane");
    WS_CHECK(seen.view >= 0 && seen.view < views, "no such view");
  }
  SpaceEstimate estimate;
  estimate.planes.resize(planes);
  estimate.views.resize(views);
  std::vector<SpaceModel> solutions = Solutions(planes, views, sightings, options);
  if (solutions.empty()) return estimate;
  SpaceModel best = solutions.front();
  RefineSpace(best, sightings, options, options.max_steps);
  int points = 0;
  for (const PlaneSighting& seen : sightings) points += seen.points.size();
  estimate.sigmas = std::sqrt(best.cost / std::max(1, 2 * points));
  const double scale = std::max(1.0, estimate.sigmas * estimate.sigmas);
  const std::vector<bool> ambiguous =
      AmbiguousPlanes(best, std::span(solutions).subspan(1), sightings, options, scale);
  estimate.unit_plane = UnitPlane(best, sightings);
  const auto covariances = PlaneCovariances(best, sightings, options, estimate.unit_plane);
  const double unit = best.planes[estimate.unit_plane]->norm();
  for (int p = 0; p < planes; ++p) {
    if (!best.planes[p]) continue;
    estimate.planes[p] = DescribePlane(*best.planes[p], *covariances[p], unit, options);
    if (p == estimate.unit_plane) estimate.planes[p].distance_sigma = 0;
    if (ambiguous[p]) estimate.planes[p].error = SpaceError::kAmbiguous;
  }
  estimate.views = std::move(best.views);
  for (auto& view : estimate.views) {
    if (view) view->translation *= unit;
  }
  return estimate;
}

std::string_view NameOf(SpaceError error) {
  switch (error) {
    case SpaceError::kNone:
      return "none";
    case SpaceError::kNoParallax:
      return "no_parallax";
    case SpaceError::kAmbiguous:
      return "ambiguous";
    default:
      return "uncertain";
  }
}

void SpaceOptions::Check() const { CheckFields("space", *this); }

}  // namespace waystone
