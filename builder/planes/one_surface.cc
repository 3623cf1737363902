// SPDX-License-Identifier: Apache-2.0
#include "builder/planes/one_surface.h"

#include <tbb/parallel_for.h>

#include <Eigen/Dense>
#include <algorithm>
#include <optional>

#include "core/features/features.h"
#include "core/homography/homography.h"
#include "core/robust/median.h"
#include "schema/layers/planes/shared_views.h"
#include "schema/layers/planes/surfaces.h"

namespace waystone {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;

constexpr size_t kFewestFeatures = 5;  // of a plane for a meaningful median

// The homographies of two planes between their reference images and a keyframe that saw both.
struct Sight {
  const Keyframe* keyframe;
  Matrix3d from_m;  // keyframe from reference image
  Matrix3d from_n;
  Matrix3d to_m;  // its inverse
  Matrix3d to_n;
};

std::vector<Sight> SightsOfBoth(const Plane& m, const Plane& n,
                                const std::vector<Keyframe>& keyframes) {
  std::vector<Sight> sights;
  for (const auto& [of_m, of_n] : SharedViews(m, n)) {
    const Keyframe& keyframe =
        *std::ranges::lower_bound(keyframes, of_m->keyframe, {}, &Keyframe::id);
    sights.push_back({&keyframe, of_m->reference_from_keyframe.inverse(),
                      of_n->reference_from_keyframe.inverse(), of_m->reference_from_keyframe,
                      of_n->reference_from_keyframe});
  }
  return sights;
}

// Where a keyframe shows a point, if it does.
std::optional<Vector2d> Shown(const Keyframe& keyframe, const Matrix3d& keyframe_from_point,
                              const Vector2d& point) {
  if (!IsInFront(keyframe_from_point, point)) return std::nullopt;
  const Vector2d x = Apply(keyframe_from_point, point);
  const bool inside = x.x() >= 0 && x.y() >= 0 && x.x() < keyframe.width && x.y() < keyframe.height;
  return inside ? std::optional(x) : std::nullopt;
}

// The median distance between the positions at which the homographies b_from_a of two planes put
// the features of `plane`.
std::optional<double> MedianApart(const Plane& plane, const Matrix3d& a_from_reference,
                                  const Matrix3d& own, const Matrix3d& other, const Keyframe& a,
                                  const Keyframe& b) {
  std::vector<double> apart_px;
  for (const PlaneFeature& feature : plane.features) {
    const std::optional<Vector2d> x_a = Shown(a, a_from_reference, PositionOf(feature.reference));
    if (!x_a) continue;
    const std::optional<Vector2d> x_b = Shown(b, own, *x_a);
    if (!x_b) continue;
    apart_px.push_back((*x_b - Apply(other, *x_a)).norm());
  }
  if (apart_px.size() < kFewestFeatures) return std::nullopt;
  return Median(std::move(apart_px));
}

}  // namespace

bool LieOnOneSurface(const Plane& m, const Plane& n, const std::vector<Keyframe>& keyframes,
                     double max_apart_px) {
  const std::vector<Sight> sights = SightsOfBoth(m, n, keyframes);
  bool compared = false;
  for (const Sight& b : sights) {
    for (const Sight& a : sights) {
      if (&a == &b) break;  // each pair once
      const Matrix3d by_m = b.from_m * a.to_m;
      const Matrix3d by_n = b.from_n * a.to_n;
      for (const auto& apart_px :
           {MedianApart(m, a.from_m, by_m, by_n, *a.keyframe, *b.keyframe),
            MedianApart(n, a.from_n, by_n, by_m, *a.keyframe, *b.keyframe)}) {
        if (!apart_px) continue;
        if (!(*apart_px <= max_apart_px)) return false;
        compared = true;
      }
    }
  }
  return compared;
}

void JoinSurfaces(const std::vector<Plane>& planes, const std::vector<Keyframe>& keyframes,
                  double max_apart_px, std::vector<Edge>& edges) {
  const auto plane_of = [&](PlaneId id) -> const Plane& {
    return *std::ranges::lower_bound(planes, id, {}, &Plane::id);
  };
  tbb::parallel_for(size_t{0}, edges.size(), [&](size_t i) {
    Edge& edge = edges[i];
    if (JoinsOneSurface(edge) ||
        !LieOnOneSurface(plane_of(edge.a), plane_of(edge.b), keyframes, max_apart_px)) {
      return;
    }
    edge.homology = Matrix3d::Identity();
    edge.third_eigenvalue = 1;
  });
}

}  // namespace waystone
