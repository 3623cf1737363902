// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <set>
#include <vector>

#include "localizer/index/map_index.h"

namespace waystone {

// Which keyframes and planes of a map show the same surroundings. Keyframes are indices in the
// map's keyframes. All functions are pure; thread-safe.

// The keyframes that a link joins with each one, by keyframe; of all links or of some.
using LinkedKeyframes = std::vector<std::vector<int>>;

// Whether two keyframes follow each other in one stretch of a sequence, with at most three between
// them. Removed keyframes end a stretch, too.
bool FollowEachOther(const MapIndex& index, int a, int b);

// The same within a sequence: stretches may end between them, where it is unknown how far the
// camera moved.
bool WereTakenInARow(const MapIndex& index, int a, int b);

// The keyframes that show the same surroundings as `keyframe`, itself too: they follow each other,
// or a plane was followed from one to the other, or two planes were seen by both, or up to four
// links in a row lead from one to the other, as where a place was visited often. One plane that was
// seen by both isn't enough: it may be a poster that hangs in two places. The links are the map's,
// or those given.
std::set<int> KeyframesNear(const MapIndex& index, int keyframe);
std::set<int> KeyframesNear(const MapIndex& index, const LinkedKeyframes& linked, int keyframe);

// Whether `b` is among KeyframesNear(a), and so `a` among those near `b`.
bool KeyframesAreNear(const MapIndex& index, int a, int b);

// KeyframesNear, and those that are near one of them without links. The relation is symmetric.
std::set<int> KeyframesNearThird(const MapIndex& index, int keyframe);
std::set<int> KeyframesNearThird(const MapIndex& index, const LinkedKeyframes& linked,
                                 int keyframe);

// Whether two planes are parts of the same surroundings: a keyframe saw both, or a link joins
// keyframes that saw them, or an edge or a common neighbour joins the planes.
bool PlanesAreNear(const MapIndex& index, const Plane& a, const Plane& b);

}  // namespace waystone
