// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "core/homography/homology.h"
#include "core/homography/local_ransac.h"

namespace waystone {

struct SegmentationOptions {
  LocalRansacOptions ransac;
  HomologyOptions homology;
  // Matches that a plane needs. Lower finds smaller planes and more that aren't any.
  int min_inliers = 16;
  // Planes looked for in one pair of images.
  int max_planes = 24;
  // A match belongs to a plane only if at least `min_companions` of its `companions` nearest
  // matches do: planes are regions, and a lone match far from its plane fits by chance.
  int companions = 8;
  int min_companions = 2;
  // Share of the companions of a plane's matches, on average, that must be the plane's too. What is
  // left over along the edges of several planes fits one homography now and then, but is scattered.
  double min_coherence = 0.5;
  // Two planes are one only if this share of the smaller one's matches also fits the larger one,
  // within twice its bound on errors: an uncertain homology alone is no proof.
  double min_shared = 0.6;

  void Check() const;  // throws MapError(kBadOptions)
};

// One plane seen in two images.
struct PlaneSegment {
  HomographyEstimate to_from;
  std::vector<int> rows;  // of the matches, ascending
};

struct Segmentation {
  std::vector<PlaneSegment> planes;  // the known ones first, in their order, then the new ones
  int rejected = 0;                  // candidates whose homologies were invalid
  int merged = 0;                    // candidates that were another plane again
};

// The planes seen in two images, from their matches (`points.reference` is not used).
// `known` are planes that are already found (tracked ones): matches that fit them are theirs, new
// planes are looked for among what is left, and each candidate must pass the homology test against
// the planes found before it (sec. II-B). A known plane's rows may grow but it never disappears.
// Deterministic for a seed; thread-safe.
Segmentation SegmentPlanes(const MatchedPoints& points, std::vector<PlaneSegment> known,
                           const SegmentationOptions& options, uint64_t seed);

}  // namespace waystone
