// SPDX-License-Identifier: Apache-2.0
#include "localizer/planes/surroundings.h"

#include <algorithm>
#include <cstdlib>
#include <utility>
#include <vector>

namespace waystone {
namespace {

// Steps in a stretch between keyframes with the same surroundings: each still shares
// min_matches_before_last features with the one two steps before, and so with a third view between
// them. Across the end of a stretch nothing is shared: the next photo may have been taken anywhere.
constexpr int kNearKeyframes = 4;

// A visit is linked with only some of those before it.
constexpr int kLinksInARow = 4;

// The same poster, sign or door may be in two places, and planes of both may be fused.
constexpr int kSharedPlanes = 2;

// Keyframes, each once, in the order in which they were added.
class KeyframeSet {
 public:
  explicit KeyframeSet(const MapIndex& index) : has_(index.map().keyframes.size(), false) {}

  // Whether it is new.
  bool Add(int keyframe) {
    if (has_[keyframe]) return false;
    has_[keyframe] = true;
    all_.push_back(keyframe);
    return true;
  }
  const std::vector<int>& all() const { return all_; }

 private:
  std::vector<bool> has_;
  std::vector<int> all_;
};

// Finds what is near without links: keyframes that follow each other, or to which a plane was
// followed, or that saw the same two planes.
class Around {
 public:
  explicit Around(const MapIndex& index)
      : index_(index), shared_(index.map().keyframes.size(), 0) {}

  // The keyframes around any of these, themselves too.
  KeyframeSet Of(const std::vector<int>& keyframes) {
    KeyframeSet around(index_);
    for (const int keyframe : keyframes) Add(keyframe, around);
    return around;
  }

 private:
  void Add(int keyframe, KeyframeSet& around) {
    const int last = static_cast<int>(index_.map().keyframes.size()) - 1;
    for (int other = std::max(0, keyframe - kNearKeyframes);
         other <= std::min(last, keyframe + kNearKeyframes); ++other) {
      if (FollowEachOther(index_, keyframe, other)) around.Add(other);
    }
    const std::vector<MapIndex::SeenPlane>& planes = index_.PlanesSeenBy(keyframe);
    for (const MapIndex::SeenPlane& seen : planes) {
      AddFollowed(seen, around);
      for (const int other : index_.KeyframesThatSaw(seen.plane)) {
        if (++shared_[other] == kSharedPlanes) around.Add(other);
      }
    }
    for (const MapIndex::SeenPlane& seen : planes) {
      for (const int other : index_.KeyframesThatSaw(seen.plane)) shared_[other] = 0;
    }
  }

  // Adds the keyframes to which the plane was tracked from that of one of its views.
  void AddFollowed(const MapIndex::SeenPlane& seen, KeyframeSet& around) const {
    const std::vector<int>& saw = index_.KeyframesThatSaw(seen.plane);
    const int last = static_cast<int>(saw.size()) - 1;
    for (int i = seen.view; i < last && FollowEachOther(index_, saw[i], saw[i + 1]); ++i) {
      around.Add(saw[i + 1]);
    }
    for (int i = seen.view; i > 0 && FollowEachOther(index_, saw[i], saw[i - 1]); --i) {
      around.Add(saw[i - 1]);
    }
  }

  const MapIndex& index_;
  std::vector<int> shared_;  // planes, by keyframe; all 0 between calls
};

// The keyframes to which up to kLinksInARow links lead from any of these.
KeyframeSet LinkedInARow(const MapIndex& index, const LinkedKeyframes& links,
                         std::vector<int> keyframes) {
  KeyframeSet linked(index);
  for (int i = 0; i < kLinksInARow; ++i) {
    std::vector<int> next;
    for (const int keyframe : keyframes) {
      for (const int other : links[keyframe]) {
        if (linked.Add(other)) next.push_back(other);
      }
    }
    keyframes = std::move(next);
  }
  return linked;
}

std::set<int> Union(const KeyframeSet& a, const KeyframeSet& b) {
  std::set<int> all(a.all().begin(), a.all().end());
  all.insert(b.all().begin(), b.all().end());
  return all;
}

// Whether a keyframe saw both planes; their views are sorted by keyframe.
bool WereSeenTogether(const Plane& a, const Plane& b) {
  auto view_a = a.views.begin();
  auto view_b = b.views.begin();
  while (view_a != a.views.end() && view_b != b.views.end()) {
    if (view_a->keyframe == view_b->keyframe) return true;
    view_a->keyframe < view_b->keyframe ? ++view_a : ++view_b;
  }
  return false;
}

// Whether a keyframe that saw the one plane is linked with one that saw the other.
bool LinkedKeyframesSaw(const MapIndex& index, const Plane& a, const Plane& b) {
  return std::ranges::any_of(a.views, [&](const PlaneView& view) {
    return std::ranges::any_of(index.LinkedTo(index.IndexOf(view.keyframe)), [&](int linked) {
      return std::ranges::binary_search(b.views, index.map().keyframes[linked].id, {},
                                        &PlaneView::keyframe);
    });
  });
}

}  // namespace

bool FollowEachOther(const MapIndex& index, int a, int b) {
  return WereTakenInARow(index, a, b) &&
         index.map().keyframes[a].stretch == index.map().keyframes[b].stretch;
}

bool WereTakenInARow(const MapIndex& index, int a, int b) {
  return std::abs(a - b) <= kNearKeyframes &&
         index.map().keyframes[a].sequence == index.map().keyframes[b].sequence;
}

std::set<int> KeyframesNear(const MapIndex& index, int keyframe) {
  return KeyframesNear(index, index.linked(), keyframe);
}

std::set<int> KeyframesNear(const MapIndex& index, const LinkedKeyframes& linked, int keyframe) {
  Around around(index);
  const KeyframeSet near = around.Of({keyframe});
  return Union(near, around.Of(LinkedInARow(index, linked, near.all()).all()));
}

bool KeyframesAreNear(const MapIndex& index, int a, int b) {
  return KeyframesNear(index, a).contains(b);
}

std::set<int> KeyframesNearThird(const MapIndex& index, int keyframe) {
  return KeyframesNearThird(index, index.linked(), keyframe);
}

std::set<int> KeyframesNearThird(const MapIndex& index, const LinkedKeyframes& linked,
                                 int keyframe) {
  Around around(index);
  const KeyframeSet near = around.Of({keyframe});
  return Union(around.Of(near.all()), around.Of(LinkedInARow(index, linked, near.all()).all()));
}

bool PlanesAreNear(const MapIndex& index, const Plane& a, const Plane& b) {
  if (WereSeenTogether(a, b)) return true;
  if (!index.map().links.empty() && LinkedKeyframesSaw(index, a, b)) return true;
  const std::vector<PlaneId>& of_a = index.Neighbours(a.id);
  const std::vector<PlaneId>& of_b = index.Neighbours(b.id);
  if (std::binary_search(of_a.begin(), of_a.end(), b.id)) return true;
  return std::any_of(of_a.begin(), of_a.end(),
                     [&](PlaneId id) { return std::binary_search(of_b.begin(), of_b.end(), id); });
}

}  // namespace waystone
