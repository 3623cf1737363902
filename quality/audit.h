// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "core/base/ids.h"
#include "core/base/options.h"
#include "localizer/index/map_index.h"
#include "localizer/planes/plane_query_options.h"

namespace waystone {

struct AuditOptions {
  int min_alias_inliers = 15;
  // The options of future queries: their gates say which evidence suffices for an answer.
  PlaneQueryOptions query;
  int max_voters = 600;
  int votes_per_feature = 8;
  int max_candidates = 8;
  double same_surface_share = 0.15;
  int min_view_features = 40;
  int min_stretch_planes = 2;
  int short_run = 3;

  static constexpr auto Fields(const auto& use) {
    using Self = AuditOptions;
    return use(
        OptionField{"min_alias_inliers", &Self::min_alias_inliers, AtLeast(5), "",
                    "Number of inliers that two places must share to count as confusable. Lower "
                    "values list more pairs."},
        OptionGroup{"query", &Self::query},
        OptionField{
            "max_voters", &Self::max_voters, AtLeast(8), "",
            "Number of features of a plane, most votes first, that are used as a query. Bounds the "
            "cost on large planes; fewer features miss small objects that look alike."},
        OptionField{"votes_per_feature", &Self::votes_per_feature, AtLeast(2), "",
                    "Number of nearest map features for which each of them votes: the first ones "
                    "are the plane's own and those of its neighbours."},
        OptionField{
            "max_candidates", &Self::max_candidates, AtLeast(1), "",
            "Number of candidates whose homography is tried for each plane, most votes first."},
        OptionField{"same_surface_share", &Self::same_surface_share, Closed(0, 1), "",
                    "Two planes with at least this share of similar features where both were "
                    "visible are assumed to be one surface that was mapped twice rather than two "
                    "surfaces with the same object on them."},
        OptionField{"min_view_features", &Self::min_view_features, AtLeast(1), "",
                    "Queries may not be recognised at a keyframe with fewer features on planes in "
                    "view. A query redetects a third to a half of them, and a place with fewer "
                    "than about a dozen inliers is refused."},
        OptionField{"min_stretch_planes", &Self::min_stretch_planes, AtLeast(0), "",
                    "Queries are hardly recognised in a stretch with fewer planes."},
        OptionField{"short_run", &Self::short_run, AtLeast(1), "",
                    "If fewer consecutive keyframes than this are weak, there are too few views "
                    "rather than too little to see."});
  }
  void Check() const;  // throws MapError(kBadOptions)
};

// What to do about a finding.
enum class Remedy {
  kMarker,      // put up something unique there
  kJoin,        // record one sequence from one to the other, so that the builder joins them
  kMoreViews,   // pass again, from more positions
  kSlowerPass,  // pass again, slower: the camera lost what it saw there
};
// "marker", "join", "more_views", "slower_pass".
const char* NameOf(Remedy remedy);

// A pair of planes in different places of the map that look alike.
struct AliasPlanes {
  PlaneId a;
  PlaneId b;
  int inliers = 0;  // distinct features of the one that fit the other
  // Of the features that lie where both planes have some, the share that is alike, in [0, 1]: high
  // for one wall, low for two walls with the same poster.
  double shared = 0;
};

// Two places that could be mistaken for each other: no keyframe, edge or neighbour joins their
// planes.
struct AliasPair {
  KeyframeId a;                     // reference of the plane with the most inliers ...
  KeyframeId b;                     // ... and of the one that it looks like; a < b
  std::vector<AliasPlanes> planes;  // most inliers first; each `a` is near the others', and `b` too
  int inliers = 0;                  // of planes that look alike, none counted twice
  // The part of the features in view at `a` or `b`, whichever is larger, that looks alike: with
  // GateOptions' ambiguous_share or more, photos from there may be ambiguous. In [0, 1]
  double of_view = 0;
  double shared = 0;  // mean of the planes', weighted by their inliers
  Remedy remedy = Remedy::kMarker;
};

enum class Weakness {
  kSeesNoPlane,  // its keyframes see no plane of the map
  kFewFeatures,  // ... or too few features on planes
  kFewPlanes,    // the whole stretch has fewer planes than it should
};
// "no_plane", "few_features", "few_planes".
const char* NameOf(Weakness weakness);

// Keyframes in a row, of one stretch, at which a query may not be recognised.
struct WeakRun {
  KeyframeId first;
  KeyframeId last;
  int keyframes = 0;
  int planes = 0;    // seen by any of them
  int features = 0;  // in view at the poorest of them
  Weakness weakness = Weakness::kSeesNoPlane;
  Remedy remedy = Remedy::kMoreViews;
};

// Two visits that only one plane connects: no other plane was seen on both, and no edge leads from
// one to the other. Either one place that was barely recognised, or two places with the same thing
// on their walls that were fused.
struct LoneTie {
  PlaneId plane;
  KeyframeId a;     // of the one visit, where most of the plane was seen ...
  KeyframeId b;     // ... and of the other; a < b
  int inliers = 0;  // features of the plane that were found in either
};

struct AuditReport {
  std::vector<AliasPair> aliases;  // most inliers first
  std::vector<LoneTie> ties;       // in the order of the planes; at most one per plane
  std::vector<WeakRun> weak;       // in the map's order
};

// Finds where a map is weak: every plane is matched as a query against all others except those near
// it, and every keyframe is checked for enough features to be recognised by. Costs one query
// without extraction per plane, spread over TBB's threads. Deterministic on any number of threads;
// thread-safe. Throws MapError(kBadOptions).
AuditReport AuditMap(const MapIndex& index, const AuditOptions& options = {});

}  // namespace waystone
