// SPDX-License-Identifier: Apache-2.0
#include "quality/audit_views.h"

#include <Eigen/Dense>
#include <algorithm>
#include <optional>
#include <set>
#include <unordered_map>

#include "core/homography/homography.h"

namespace waystone {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;

int CountInImage(const Plane& plane, const PlaneView& view, const Keyframe& keyframe) {
  const Matrix3d keyframe_from_reference = view.reference_from_keyframe.inverse();
  return static_cast<int>(
      std::count_if(plane.features.begin(), plane.features.end(), [&](const PlaneFeature& feature) {
        const Vector2d x =
            Apply(keyframe_from_reference, {feature.reference.x_px, feature.reference.y_px});
        return x.x() >= 0 && x.y() >= 0 && x.x() < keyframe.width && x.y() < keyframe.height;
      }));
}

// Keyframes first to last of a map, by their index.
struct Run {
  int first = 0;
  int last = 0;
};

bool SameStretch(const Keyframe& a, const Keyframe& b) {
  return a.sequence == b.sequence && a.stretch == b.stretch;
}

// The map's keyframes, split where `together` is false for two consecutive ones.
template <class Predicate>
std::vector<Run> Split(const std::vector<Keyframe>& keyframes, Predicate together) {
  std::vector<Run> runs;
  for (int k = 0; k < static_cast<int>(keyframes.size()); ++k) {
    if (k > 0 && together(k - 1, k)) {
      runs.back().last = k;
    } else {
      runs.push_back({k, k});
    }
  }
  return runs;
}

std::optional<Weakness> FindWeakness(const KeyframeView& view, const AuditOptions& options) {
  if (view.planes.empty()) return Weakness::kSeesNoPlane;
  if (view.features < options.min_view_features) return Weakness::kFewFeatures;
  return std::nullopt;
}

// Whether tracking was lost at one end of a run: the sequence continues beyond it in another
// stretch.
bool EndsAtBreak(const std::vector<Keyframe>& keyframes, const Run& run) {
  const auto breaks = [&](int a, int b) {
    return a >= 0 && b < static_cast<int>(keyframes.size()) &&
           keyframes[a].sequence == keyframes[b].sequence &&
           keyframes[a].stretch != keyframes[b].stretch;
  };
  return breaks(run.first - 1, run.first) || breaks(run.last, run.last + 1);
}

WeakRun Described(const MapData& map, const std::vector<KeyframeView>& views, const Run& run,
                  Weakness weakness, const AuditOptions& options) {
  WeakRun weak{map.keyframes[run.first].id, map.keyframes[run.last].id, run.last - run.first + 1};
  std::set<PlaneId> planes;
  weak.features = views[run.first].features;
  for (int k = run.first; k <= run.last; ++k) {
    planes.insert(views[k].planes.begin(), views[k].planes.end());
    weak.features = std::min(weak.features, views[k].features);
  }
  weak.planes = static_cast<int>(planes.size());
  weak.weakness = weakness;
  const bool too_fast = EndsAtBreak(map.keyframes, run);
  weak.remedy = too_fast                             ? Remedy::kSlowerPass
                : weak.keyframes < options.short_run ? Remedy::kMoreViews
                                                     : Remedy::kMarker;
  return weak;
}

}  // namespace

std::vector<KeyframeView> CollectViews(const MapData& map) {
  std::vector<KeyframeView> views(map.keyframes.size());
  std::unordered_map<KeyframeId, int> index;
  for (size_t k = 0; k < views.size(); ++k) {
    views[k].keyframe = map.keyframes[k].id;
    index[views[k].keyframe] = static_cast<int>(k);
  }
  for (const Plane& plane : map.planes) {
    for (const PlaneView& view : plane.views) {
      const int k = index.at(view.keyframe);
      views[k].planes.push_back(plane.id);
      views[k].features += CountInImage(plane, view, map.keyframes[k]);
    }
  }
  return views;
}

int FeaturesInView(const std::vector<KeyframeView>& views, KeyframeId keyframe) {
  const auto found =
      std::lower_bound(views.begin(), views.end(), keyframe,
                       [](const KeyframeView& view, KeyframeId id) { return view.keyframe < id; });
  return found == views.end() || found->keyframe != keyframe ? 0 : found->features;
}

std::vector<WeakRun> FindWeakRuns(const MapData& map, const std::vector<KeyframeView>& views,
                                  const AuditOptions& options) {
  const std::vector<Keyframe>& keyframes = map.keyframes;
  std::vector<WeakRun> weak;
  for (const Run& stretch :
       Split(keyframes, [&](int a, int b) { return SameStretch(keyframes[a], keyframes[b]); })) {
    const WeakRun whole = Described(map, views, stretch, Weakness::kFewPlanes, options);
    if (whole.planes > 0 && whole.planes < options.min_stretch_planes) weak.push_back(whole);
  }
  for (const Run& run : Split(keyframes, [&](int a, int b) {
         return SameStretch(keyframes[a], keyframes[b]) &&
                FindWeakness(views[a], options) == FindWeakness(views[b], options);
       })) {
    const std::optional<Weakness> weakness = FindWeakness(views[run.first], options);
    if (weakness) weak.push_back(Described(map, views, run, *weakness, options));
  }
  std::stable_sort(weak.begin(), weak.end(),
                   [](const WeakRun& a, const WeakRun& b) { return a.first < b.first; });
  return weak;
}

}  // namespace waystone
