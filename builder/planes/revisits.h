// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "builder/frames/progress.h"
#include "builder/planes/keyframe_sample.h"
#include "builder/planes/options.h"
#include "schema/map_data.h"

namespace waystone {

// A plane that an image shows although it wasn't tracked to the image's keyframe.
struct PlaneSeenAgain {
  PlaneId plane;
  PlaneView view;

  bool operator==(const PlaneSeenAgain&) const = default;
};

struct Revisits {
  std::vector<PlaneSeenAgain> seen;  // by keyframe, then by plane
  std::vector<Edge> edges;           // new ones, by (a, b)
};

// Closes loops that fusion leaves open. Fusion compares the features that planes have kept, of
// which two visits to a place may share few, while a keyframe's image shows everything: each of
// `images` is searched for the planes that weren't tracked to its keyframe, with all its features
// in place of another plane's (line 17 of Algorithm 1), and with matches that span half of what the
// two have in common, which those of a repeated poster don't. Such a plane and one that was tracked
// to the keyframe, or was found there in the same way, are carried to the images before and after
// it by matches (sec. II-A); where their homology is the identity (sec. II-B: one and the same
// plane), they get an edge with the measured homology, unless an edge already joins their surfaces.
// The arguments are ordered by id and (a, b); `images` are of `keyframes`, all or some.
// Reports the stage "revisits". Deterministic on any number of threads (it uses TBB's).
Revisits FindRevisits(const std::vector<Plane>& planes, const std::vector<Edge>& edges,
                      const std::vector<Keyframe>& keyframes,
                      const std::vector<SampledKeyframe>& images, FeatureType type,
                      const PlaneLayerOptions& options, ProgressReporter& progress);

}  // namespace waystone
