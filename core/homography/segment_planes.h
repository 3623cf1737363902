// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "core/base/options.h"
#include "core/homography/find_plane.h"
#include "core/homography/homology.h"
#include "core/homography/plane_labelling.h"

namespace waystone {

struct SegmentationOptions {
  LocalRansacOptions ransac;
  LabellingOptions labelling;
  HomologyOptions homology;
  int min_inliers = 14;
  int max_planes = 24;
  int patch = 20;
  bool greedy = false;

  static constexpr auto Fields(const auto& use) {
    return use(
        OptionGroup{"ransac", &SegmentationOptions::ransac},
        OptionGroup{"labelling", &SegmentationOptions::labelling},
        OptionGroup{"homology", &SegmentationOptions::homology},
        OptionField{"min_inliers", &SegmentationOptions::min_inliers, AtLeast(5), "",
                    "Minimum number of matches of a plane. Lower values find smaller planes, but "
                    "also more that are not planes."},
        OptionField{"max_planes", &SegmentationOptions::max_planes, AtLeast(1), "",
                    "Maximum number of new planes per pair of images."},
        OptionField{"patch", &SegmentationOptions::patch, AtLeast(5), "",
                    "Number of neighbouring matches from which a plane is proposed, in addition to "
                    "a half and a quarter of that number. Lower values find smaller planes; higher "
                    "values determine them better."},
        OptionField{
            "greedy", &SegmentationOptions::greedy, AnyValue(), "",
            "Whether to extract planes one after the other, each with all matches that support it, "
            "as in the paper, instead of relabelling all matches for each plane.",
            OptionUse::kInternal});
  }
  void Check() const;  // throws MapError(kBadOptions)
};

// One plane seen in two images.
struct PlaneSegment {
  HomographyEstimate to_from;
  std::vector<int> rows;  // of the matches, ascending
};

struct Segmentation {
  std::vector<PlaneSegment> planes;  // the known ones first, in their order, then the new ones
  int rejected = 0;                  // proposals whose homologies were invalid
  int merged = 0;                    // planes that turned out to be the same as another one
};

// The planes seen in two images, from their matches (`points.reference` is not used): planes are
// proposed one after the other, from samples of matches that belong to none yet (sec. II) and from
// patches of neighbouring matches that so far share one label, and each proposal is verified by
// relabelling all matches with it. It is accepted if that explains the matches better
// (PlaneLabelling) and if its homology with one of the other planes is valid or there are no
// others; if the homology is the identity, the two are merged (sec. II-B). `known` are planes that
// were already found (tracked ones): they keep their homographies (unless a second part of them is
// found) and never disappear, but may lose matches to planes that explain them better, and gain
// others. With options.greedy, as in the paper instead: a plane takes and keeps all matches that
// support it and belong to no plane before it. Deterministic for a seed; thread-safe.
Segmentation SegmentPlanes(const MatchedPoints& points, std::vector<PlaneSegment> known,
                           const SegmentationOptions& options, uint64_t seed);

}  // namespace waystone
