// SPDX-License-Identifier: Apache-2.0
#include "localizer/planes/verify.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "core/homography/estimate_homography.h"
#include "localizer/planes/spread.h"
#include "localizer/planes/surroundings.h"
#include "schema/layers/planes/shared_views.h"

namespace waystone {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;

std::vector<Vector2d> QueryPoints(const Features& query, const std::vector<Match>& inliers) {
  std::vector<Vector2d> points;
  for (const Match& match : inliers) points.push_back(PositionOf(query.keypoints[match.a]));
  return points;
}

// Enlargement of the homography where the inliers lie, as a ratio of lengths; negative when it
// turns the plane over.
double ScaleAt(const Matrix3d& h, const Vector2d& x) {
  const double w = h.row(2).dot(x.homogeneous());
  const double area = h.determinant() / (w * w * w);  // determinant of the local affinity
  return std::copysign(std::sqrt(std::abs(area)), area);
}

// Ratio of lengths in an image to those in another one with the same field of view.
double SizeRatio(const Features& query, const Keyframe& reference) {
  return std::sqrt((static_cast<double>(query.width) * query.height) /
                   (static_cast<double>(reference.width) * reference.height));
}

// By fields of view, not by pixels: a photo of 48 megapixels wasn't taken from closer.
bool ScalesSensibly(const VerifiedPlane& verified, const Features& query, const Keyframe& reference,
                    double max_scale) {
  const double size_ratio = SizeRatio(query, reference);
  for (const Match& match : verified.inliers) {
    const double scale = size_ratio * ScaleAt(verified.reference_from_query.b_from_a,
                                              PositionOf(query.keypoints[match.a]));
    if (!(scale > 1 / max_scale && scale < max_scale)) return false;
  }
  return true;
}

Gate FirstFailedGate(const VerifiedPlane& verified, const Features& query,
                     const Keyframe& reference, const GateOptions& gates) {
  if (verified.distinct < gates.min_inliers) return Gate::kMinInliers;
  if (verified.distinct < gates.min_inlier_share * verified.matches) return Gate::kMinInlierShare;
  if (!ScalesSensibly(verified, query, reference, gates.max_scale)) return Gate::kMaxScale;
  return Gate::kPassed;
}

}  // namespace

std::optional<VerifiedPlane> VerifyPlane(const MapIndex& index, const PackedFeatures& packed,
                                         int plane, const PlaneQueryOptions& options) {
  const Features& query = packed.features;
  const Plane& target = index.map().planes[plane];
  const std::vector<Match> matches =
      MatchDescriptors(packed.rows, query.size(), index.DescriptorsOf(plane), options.match);
  MatchedPoints points;
  for (const Match& match : matches) {
    points.from.push_back(PositionOf(query.keypoints[match.a]));
    points.to.push_back(PositionOf(target.features[match.b].reference));
  }
  const uint64_t seed = options.seed ^ static_cast<uint64_t>(target.id.value);
  const auto estimate = EstimateHomography(points, options.ransac, seed);
  if (!estimate) return std::nullopt;
  VerifiedPlane verified;
  verified.plane = plane;
  verified.reference_from_query = estimate->to_from;
  for (const int row : estimate->inliers) verified.inliers.push_back(matches[row]);
  verified.matches = static_cast<int>(matches.size());
  verified.distinct = CountApart(QueryPoints(query, verified.inliers), options.gates.distinct_px);
  verified.stopped_by =
      FirstFailedGate(verified, query, *index.FindKeyframe(target.reference), options.gates);
  verified.accepted = verified.stopped_by == Gate::kPassed;
  return verified;
}

bool IsBeaten(const MapIndex& index, const ShortlistedPlane& candidate, const VerifiedPlane& best,
              const PlaneQueryOptions& options) {
  if (best.distinct < options.settled_inliers) return false;
  if (candidate.votes >= options.settled_share * best.distinct) return false;
  const std::vector<Plane>& planes = index.map().planes;
  return !PlanesAreNear(index, planes[best.plane], planes[candidate.plane]);
}

std::vector<VerifiedPlane> TryPlanes(const MapIndex& index, const Features& query,
                                     const std::vector<ShortlistedPlane>& shortlist,
                                     const PlaneQueryOptions& options, const Deadline& deadline) {
  const PackedFeatures packed(query);
  std::vector<VerifiedPlane> tried;
  int best = -1;  // of those that were accepted
  for (const ShortlistedPlane& candidate : shortlist) {
    if (HasPassed(deadline)) break;
    if (best >= 0 && IsBeaten(index, candidate, tried[best], options)) continue;
    auto verified = VerifyPlane(index, packed, candidate.plane, options);
    if (!verified) continue;
    tried.push_back(std::move(*verified));
    if (!tried.back().accepted) continue;
    if (best < 0 || tried.back().distinct > tried[best].distinct) {
      best = static_cast<int>(tried.size()) - 1;
    }
  }
  return tried;
}

std::optional<bool> PlanesAgree(const MapIndex& index, const VerifiedPlane& m,
                                const VerifiedPlane& n, const PlaneQueryOptions& options) {
  const std::vector<Plane>& planes = index.map().planes;
  const std::vector<SharedView> shared = SharedViews(planes[m.plane], planes[n.plane]);
  if (shared.empty()) return std::nullopt;
  const auto via = [](const PlaneView& view, const VerifiedPlane& plane) {
    return Composed(view.reference_from_keyframe.inverse(), plane.reference_from_query);
  };
  return std::ranges::any_of(shared, [&](const SharedView& view) {
    return HaveHomology(via(*view.of_m, m), via(*view.of_n, n), options.homology);
  });
}

}  // namespace waystone
