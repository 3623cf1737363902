// SPDX-License-Identifier: Apache-2.0
#include "localizer/planes/surroundings.h"

#include <algorithm>
#include <cstdlib>
#include <utility>
#include <vector>

namespace waystone {
namespace {

// In a stretch, steps between keyframes that show one surrounding: each still shares
// min_matches_before_last features with the one two steps before, and so with a third view between
// them. Where a stretch ends nothing is shared by construction, but the camera has hardly moved.
constexpr int kNearKeyframes = 4;
constexpr int kNextKeyframes = 2;

// A visit is linked with some of those before it, not with all of them.
constexpr int kLinksInARow = 4;

// One poster, sign or door may hang in two places, and planes of both may be fused.
constexpr int kSharedPlanes = 2;

// Those to which the plane was followed from the keyframe of one of its views.
void AddFollowed(const MapIndex& index, const std::vector<PlaneView>& views, int view,
                 std::set<int>& followed) {
  const auto at = [&](int i) { return index.IndexOf(views[i].keyframe); };
  const int last = static_cast<int>(views.size()) - 1;
  for (int i = view; i < last && FollowEachOther(index, at(i), at(i + 1)); ++i) {
    followed.insert(at(i + 1));
  }
  for (int i = view; i > 0 && FollowEachOther(index, at(i), at(i - 1)); --i) {
    followed.insert(at(i - 1));
  }
}

// KeyframesNear without links.
std::set<int> KeyframesAround(const MapIndex& index, int keyframe) {
  std::set<int> around;
  const int last = static_cast<int>(index.map().keyframes.size()) - 1;
  for (int other = std::max(0, keyframe - kNearKeyframes);
       other <= std::min(last, keyframe + kNearKeyframes); ++other) {
    if (FollowEachOther(index, keyframe, other)) around.insert(other);
  }
  std::vector<int> seen_with;  // keyframes, once a plane
  for (const MapIndex::SeenPlane& seen : index.PlanesSeenBy(keyframe)) {
    const std::vector<PlaneView>& views = index.map().planes[seen.plane].views;
    AddFollowed(index, views, seen.view, around);
    for (const PlaneView& view : views) seen_with.push_back(index.IndexOf(view.keyframe));
  }
  std::ranges::sort(seen_with);
  for (size_t i = kSharedPlanes - 1; i < seen_with.size(); ++i) {
    if (seen_with[i] == seen_with[i + 1 - kSharedPlanes]) around.insert(seen_with[i]);
  }
  return around;
}

std::set<int> LinkedToAny(const MapIndex& index, const std::set<int>& keyframes) {
  std::set<int> linked;
  for (const int keyframe : keyframes) {
    linked.insert(index.LinkedTo(keyframe).begin(), index.LinkedTo(keyframe).end());
  }
  return linked;
}

// The keyframes that show one surrounding with any of these.
std::set<int> KeyframesNearAny(const MapIndex& index, const std::set<int>& keyframes) {
  std::set<int> near;
  for (const int keyframe : keyframes) near.merge(KeyframesAround(index, keyframe));
  std::set<int> reached;  // by links, each once
  std::set<int> last = near;
  for (int i = 0; i < kLinksInARow && !last.empty(); ++i) {
    std::set<int> next;
    for (const int linked : LinkedToAny(index, last)) {
      if (reached.insert(linked).second) next.insert(linked);
    }
    last = std::move(next);
  }
  for (const int other : reached) near.merge(KeyframesAround(index, other));
  return near;
}

// Whether a keyframe that saw the one plane is linked with one that saw the other.
bool LinkedKeyframesSaw(const MapIndex& index, const Plane& a, const Plane& b) {
  return std::ranges::any_of(a.views, [&](const PlaneView& view_a) {
    const std::vector<int>& linked = index.LinkedTo(index.IndexOf(view_a.keyframe));
    return std::ranges::any_of(b.views, [&](const PlaneView& view_b) {
      return std::ranges::binary_search(linked, index.IndexOf(view_b.keyframe));
    });
  });
}

}  // namespace

bool FollowEachOther(const MapIndex& index, int a, int b) {
  const Keyframe& x = index.map().keyframes[a];
  const Keyframe& y = index.map().keyframes[b];
  const int near = x.stretch == y.stretch ? kNearKeyframes : kNextKeyframes;
  return x.sequence == y.sequence && std::abs(a - b) <= near;
}

std::set<int> KeyframesNear(const MapIndex& index, int keyframe) {
  return KeyframesNearAny(index, {keyframe});
}

bool KeyframesAreNear(const MapIndex& index, int a, int b) {
  return KeyframesNear(index, a).contains(b);
}

std::set<int> KeyframesNearThird(const MapIndex& index, int keyframe) {
  return KeyframesNearAny(index, KeyframesAround(index, keyframe));
}

bool PlanesAreNear(const MapIndex& index, const Plane& a, const Plane& b) {
  for (const PlaneView& view_a : a.views) {
    for (const PlaneView& view_b : b.views) {
      if (view_a.keyframe == view_b.keyframe) return true;
    }
  }
  if (!index.map().links.empty() && LinkedKeyframesSaw(index, a, b)) return true;
  const std::vector<PlaneId>& of_a = index.Neighbours(a.id);
  const std::vector<PlaneId>& of_b = index.Neighbours(b.id);
  if (std::binary_search(of_a.begin(), of_a.end(), b.id)) return true;
  return std::any_of(of_a.begin(), of_a.end(),
                     [&](PlaneId id) { return std::binary_search(of_b.begin(), of_b.end(), id); });
}

}  // namespace waystone
