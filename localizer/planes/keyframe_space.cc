// SPDX-License-Identifier: Apache-2.0
#include "localizer/planes/keyframe_space.h"

#include <algorithm>
#include <map>
#include <optional>
#include <utility>

#include "core/base/error.h"
#include "core/camera/image_plane.h"
#include "schema/layers/planes/keyframe_camera.h"

namespace waystone {
namespace {

// How many views are used, those that share most planes. Bounds the time.
constexpr size_t kMostViews = 12;
// How many points of a plane represent its homography: three times the four that determine it, so
// that they cover the plane; and the fewest that leave some to check it by.
constexpr size_t kMostPoints = 12;
constexpr size_t kLeastPoints = 6;
// Standard deviation of a point that a stored homography transfers: one pixel, times
// sqrt(kMostPoints / 4), since all the points contain no more information than the homography's
// four.
constexpr double kPointSigmaPx = 1.7;

std::optional<Camera> PerspectiveCamera(const MapIndex& index, const Keyframe& keyframe) {
  const Sequence* sequence = index.FindSequence(keyframe.sequence);
  if (!sequence || !sequence->camera) return std::nullopt;
  if (sequence->camera->model == CameraModel::kEquirectangular) return std::nullopt;
  return CameraOfKeyframe(*sequence, keyframe);
}

// The planes of each keyframe that shares one with `keyframe`, itself among them.
std::map<KeyframeId, std::vector<PlaneInView>> SeenTogether(const MapIndex& index,
                                                            const Keyframe& keyframe) {
  std::map<KeyframeId, std::vector<PlaneInView>> seen;
  for (const Plane& plane : index.map().planes) {
    const bool here = std::ranges::any_of(
        plane.views, [&](const PlaneView& view) { return view.keyframe == keyframe.id; });
    if (!here) continue;
    for (const PlaneView& view : plane.views) seen[view.keyframe].push_back({&plane, &view});
  }
  return seen;
}

bool Inside(const Keyframe& keyframe, const Eigen::Vector2d& px) {
  return px.x() >= 0 && px.y() >= 0 && px.x() < keyframe.width && px.y() < keyframe.height;
}

// Pairs that are far from each other in a, at most kMostPoints.
PointPairs SpreadOut(const PointPairs& pairs) {
  std::vector<int> chosen{0};
  std::vector<double> nearest(pairs.a.size(), 1e300);
  while (chosen.size() < std::min(kMostPoints, pairs.a.size())) {
    for (size_t i = 0; i < nearest.size(); ++i) {
      nearest[i] = std::min(nearest[i], (pairs.a[i] - pairs.a[chosen.back()]).squaredNorm());
    }
    chosen.push_back(static_cast<int>(std::ranges::max_element(nearest) - nearest.begin()));
  }
  return pairs.Subset(chosen);
}

// The positions of the plane's features in both keyframes by its homographies.
PointPairs CollectPairs(const Plane& plane, const Keyframe& a, const Camera& camera_a,
                        const PlaneView& in_a, const Keyframe& b, const Camera& camera_b,
                        const PlaneView& in_b) {
  const Eigen::Matrix3d a_from_reference = in_a.reference_from_keyframe.inverse();
  const Eigen::Matrix3d b_from_reference = in_b.reference_from_keyframe.inverse();
  PointPairs pairs;
  for (const PlaneFeature& feature : plane.features) {
    const Eigen::Vector2d reference(feature.reference.x_px, feature.reference.y_px);
    const Eigen::Vector2d at_a = Apply(a_from_reference, reference);
    const Eigen::Vector2d at_b = Apply(b_from_reference, reference);
    if (!Inside(a, at_a) || !Inside(b, at_b)) continue;
    const auto x_a = OnImagePlane(camera_a, at_a);
    const auto x_b = OnImagePlane(camera_b, at_b);
    if (x_a && x_b) pairs.Add(*x_a, *x_b);
  }
  return pairs.a.size() < kLeastPoints ? PointPairs{} : SpreadOut(pairs);
}

struct Question {
  std::vector<PlaneInView> planes;  // of the keyframe
  std::vector<PlaneSighting> sightings;
  int views = 0;
};

Question PoseQuestion(const MapIndex& index, const Keyframe& keyframe, const Camera& camera) {
  std::map<KeyframeId, std::vector<PlaneInView>> seen = SeenTogether(index, keyframe);
  Question question{.planes = seen[keyframe.id], .sightings = {}};
  seen.erase(keyframe.id);
  std::vector<std::pair<KeyframeId, std::vector<PlaneInView>>> views(seen.begin(), seen.end());
  std::ranges::stable_sort(views, std::ranges::greater(),
                           [](const auto& view) { return view.second.size(); });
  for (const auto& [id, shared] : views) {
    const Keyframe* other = index.FindKeyframe(id);
    const auto other_camera = other ? PerspectiveCamera(index, *other) : std::nullopt;
    if (!other_camera || std::cmp_equal(question.views, kMostViews)) continue;
    const size_t before = question.sightings.size();
    for (size_t p = 0; p < question.planes.size(); ++p) {
      const auto it = std::ranges::find(shared, question.planes[p].plane, &PlaneInView::plane);
      if (it == shared.end()) continue;
      PointPairs pairs = CollectPairs(*it->plane, keyframe, camera, *question.planes[p].view,
                                      *other, *other_camera, *it->view);
      if (pairs.a.empty()) continue;
      question.sightings.push_back({static_cast<int>(p), question.views, std::move(pairs)});
    }
    question.views += question.sightings.size() > before ? 1 : 0;
  }
  return question;
}

}  // namespace

KeyframeSpace EstimateSpace(const MapIndex& index, const Keyframe& keyframe) {
  const std::optional<Camera> camera = PerspectiveCamera(index, keyframe);
  if (!camera) {
    throw MapError(ErrorCode::kNotAvailable,
                   "planes in 3D require a perspective or fisheye camera, and this keyframe's "
                   "sequence has none; build the map with --camera");
  }
  Question question = PoseQuestion(index, keyframe, *camera);
  SpaceOptions options;
  options.point_sigma = kPointSigmaPx / camera->params[0];
  SpaceEstimate estimate = FindPlanesInSpace(static_cast<int>(question.planes.size()),
                                             question.views, question.sightings, options);
  return {*camera, std::move(question.planes), question.views, std::move(estimate)};
}

}  // namespace waystone
