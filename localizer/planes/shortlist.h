// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "localizer/index/map_index.h"
#include "localizer/planes/plane_query_options.h"

namespace waystone {

// A plane that the query may show.
struct ShortlistedPlane {
  int plane = 0;  // index in the map's planes
  int votes = 0;
};

// A keyframe that the query may be near.
struct ShortlistedKeyframe {
  int keyframe = 0;   // index in the map's keyframes
  double excess = 0;  // weight of the votes beyond that by chance, in sigmas of the latter
};

struct Shortlist {
  std::vector<ShortlistedPlane> planes;        // most votes first, at most max_candidates
  std::vector<ShortlistedKeyframe> keyframes;  // most excess first, at most max_keyframes
};

// Planes and keyframes by descriptor votes. Every query feature votes once for each plane among its
// nearest descriptors, and once for each keyframe that has a landmark among them. A keyframe has
// the votes of the planes that it saw too, each by the share of the plane's features that it saw.
// Planes are ranked by their votes. Keyframes are ranked by how far the weight of their votes is
// beyond what as many features get by chance: one that saw more isn't likelier to be seen again. No
// minimum number of votes is required of keyframes, since votes are spread over all visits.
// A vote weighs more the nearer its descriptor is compared with the background, and less where many
// features of the query vote for the same descriptor. Deterministic; thread-safe.
Shortlist VoteForPlaces(const MapIndex& index, const Features& query,
                        const PlaneQueryOptions& options);

// Only the planes of VoteForPlaces.
std::vector<ShortlistedPlane> ShortlistPlanes(const MapIndex& index, const Features& query,
                                              const PlaneQueryOptions& options);

}  // namespace waystone
