// SPDX-License-Identifier: Apache-2.0
#include "localizer/planes/verify_keyframe.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "core/homography/homography.h"
#include "core/two_view/fundamental.h"
#include "localizer/planes/spread.h"

namespace waystone {
namespace {

using Eigen::Vector2d;

bool IsInside(const Vector2d& x, int width, int height) {
  return x.x() >= 0 && x.y() >= 0 && x.x() < width && x.y() < height;  // not for NaN
}

// The affinity query_from_keyframe that fits the inliers best, linear part and shift. An epipolar
// geometry only gives the line on which a feature lies; an affinity suffices to tell whether it is
// inside the image.
Eigen::Matrix<double, 2, 3> FitAffinity(const VerifiedKeyframe& verified) {
  const auto n = static_cast<Eigen::Index>(verified.query_points.size());
  Eigen::MatrixXd from(n, 3);
  Eigen::MatrixXd to(n, 2);
  for (Eigen::Index i = 0; i < n; ++i) {
    from.row(i) = verified.keyframe_points[i].homogeneous().transpose();
    to.row(i) = verified.query_points[i].transpose();
  }
  return from.colPivHouseholderQr().solve(to).transpose();
}

// EpipolarSignificance for `counted` inliers, with the matches reduced in the same proportion as
// the distinct inliers.
double SignificanceOf(int counted, const VerifiedKeyframe& verified, const Features& query,
                      double max_error_px) {
  if (counted == 0) return 0;
  const double share = static_cast<double>(counted) / verified.distinct;
  return EpipolarSignificance(static_cast<int>(std::lround(share * verified.matches)), counted,
                              max_error_px, query.width, query.height);
}

// Features of the keyframe that the query should show.
int CountExpected(const KeyframeFeatures& target, const VerifiedKeyframe& verified,
                  const Features& query, double distinct_px) {
  const Eigen::Matrix<double, 2, 3> query_from_keyframe = FitAffinity(verified);
  std::vector<Vector2d> expected;
  for (const Vector2d& x : target.positions) {
    const Vector2d there = query_from_keyframe * x.homogeneous();
    if (CanShow(query, there)) expected.push_back(there);
  }
  return CountApart(expected, distinct_px);
}

}  // namespace

KeyframeFeatures CollectKeyframeFeatures(const MapIndex& index, int keyframe) {
  const MapData& map = index.map();
  const Keyframe& image = map.keyframes[keyframe];
  KeyframeFeatures target;
  target.descriptors = index.LandmarkDescriptorsOf(keyframe);
  for (const ImagePosition& position : image.landmarks.positions) {
    target.rows.push_back(index.FirstLandmarkRow(keyframe) +
                          static_cast<int>(target.positions.size()));
    target.positions.push_back(DecodePosition(position, image.width, image.height));
  }
  if (target.descriptors.bytes() == 0) {
    target.descriptors = Descriptors(DescriptorBytes(map.info.feature_type));
  }
  for (const MapIndex::SeenPlane& seen : index.PlanesSeenBy(keyframe)) {
    const Plane& plane = map.planes[seen.plane];
    const Eigen::Matrix3d keyframe_from_reference =
        plane.views[seen.view].reference_from_keyframe.inverse();
    const Descriptors descriptors = index.DescriptorsOf(seen.plane);
    for (int i = 0; i < static_cast<int>(plane.features.size()); ++i) {
      const Vector2d reference = PositionOf(plane.features[i].reference);
      const Vector2d x = Apply(keyframe_from_reference, reference);
      if (!IsInside(x, image.width, image.height)) continue;
      if (!IsInFront(keyframe_from_reference, reference)) continue;
      target.positions.push_back(x);
      target.descriptors.Append(descriptors.row(i));
      target.rows.push_back(index.FirstRow(seen.plane) + i);
    }
  }
  return target;
}

VerifiedKeyframe VerifyKeyframe(const MapIndex& index, const Features& query, int keyframe,
                                const PlaneQueryOptions& options) {
  const KeyframeFeatures target = CollectKeyframeFeatures(index, keyframe);
  const std::vector<Match> matches =
      MatchDescriptors(target.descriptors, query.descriptors, query.type, options.keyframe_match);
  std::vector<Vector2d> in_query;
  std::vector<Vector2d> in_keyframe;
  for (const Match& match : matches) {
    in_query.push_back(PositionOf(query.keypoints[match.b]));
    in_keyframe.push_back(target.positions[match.a]);
  }
  VerifiedKeyframe verified;
  verified.keyframe = keyframe;
  verified.matches = static_cast<int>(matches.size());
  const auto fit = FindEpipolarGeometry(in_keyframe, in_query, options.epipolar);
  if (!fit) return verified;
  std::vector<Keypoint> keypoints;
  for (const int row : fit->inliers) {
    keypoints.push_back(query.keypoints[matches[row].b]);
    verified.query_points.push_back(in_query[row]);
    verified.keyframe_points.push_back(in_keyframe[row]);
    verified.inliers.push_back({matches[row].b, target.rows[matches[row].a]});
  }
  verified.distinct = CountApart(verified.query_points, options.gates.distinct_px);
  verified.independent = std::min(verified.distinct, CountIndependent(keypoints, query.type));
  verified.expected = CountExpected(target, verified, query, options.gates.distinct_px);
  verified.coverage = ComputeCoverage(verified.query_points, query.width, query.height);
  const double max_error_px = options.epipolar.max_error_px;
  verified.significance = SignificanceOf(verified.distinct, verified, query, max_error_px);
  verified.independent_significance =
      SignificanceOf(verified.independent, verified, query, max_error_px);
  return verified;
}

}  // namespace waystone
