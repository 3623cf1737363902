// SPDX-License-Identifier: Apache-2.0
#include "builder/planes/revisits.h"

#include <tbb/parallel_for.h>

#include <Eigen/Dense>
#include <algorithm>
#include <atomic>
#include <map>
#include <optional>
#include <set>
#include <utility>

#include "builder/planes/fusion.h"
#include "builder/planes/fusion_candidates.h"
#include "builder/planes/outline.h"
#include "builder/planes/plane_features.h"
#include "core/homography/estimate_homography.h"
#include "schema/layers/planes/surfaces.h"

namespace waystone {
namespace {

using Eigen::Vector2d;

constexpr double kMinSpanned = 0.5;  // of what a plane and an image have in common

// A plane that an image shows.
struct Sighting {
  int plane = 0;                  // index
  std::optional<PlaneView> view;  // if it wasn't tracked to the image's keyframe
  std::vector<bool> shows;  // of each keypoint of the image: it is one of the plane's features
};

// Everything that an image shows, as if it were one plane.
Plane AsPlane(const SampledKeyframe& image) {
  Plane plane;
  plane.reference = image.keyframe;
  plane.descriptors = image.features.descriptors;
  for (const Keypoint& keypoint : image.features.keypoints) {
    plane.features.push_back({.reference = keypoint});
  }
  return plane;
}

// The share of the image's features on the plane that lie within the convex hull of the matched
// ones: a poster that hangs in two places matches only on itself, and most of the wall is around
// it.
double SpannedShare(const Plane& plane, const FusionMatch& match, const Plane& image) {
  std::vector<Vector2d> matched;
  for (const Match& inlier : match.inliers) {
    matched.push_back(PositionOf(plane.features[inlier.a].reference));
  }
  const Eigen::Matrix3d& to_reference = match.m_from_n.b_from_a;
  const size_t on_plane = FeaturesInsideHull(image, to_reference, PositionsOf(plane)).size();
  const size_t within = FeaturesInsideHull(image, to_reference, matched).size();
  return static_cast<double>(within) / static_cast<double>(std::max<size_t>(1, on_plane));
}

const PlaneView* FindView(const Plane& plane, KeyframeId keyframe) {
  const auto view = std::ranges::lower_bound(plane.views, keyframe, {}, &PlaneView::keyframe);
  return view != plane.views.end() && view->keyframe == keyframe ? &*view : nullptr;
}

class RevisitFinder {
 public:
  RevisitFinder(const std::vector<Plane>& planes, const std::vector<Edge>& edges,
                const std::vector<Keyframe>& keyframes, const std::vector<SampledKeyframe>& images,
                FeatureType type, const PlaneLayerOptions& options)
      : planes_(planes),
        keyframes_(keyframes),
        images_(images),
        type_(type),
        options_(options),
        surface_of_(FindSurfaces(planes, edges)) {
    std::map<PlaneId, int> index;
    for (const Plane& plane : planes) {
      const int p = index.emplace(plane.id, static_cast<int>(index.size())).first->second;
      for (const PlaneView& view : plane.views) followed_to_[view.keyframe].push_back(p);
    }
    for (const Edge& edge : edges) {
      joined_.insert(Ordered(surface_of_[index.at(edge.a)], surface_of_[index.at(edge.b)]));
    }
  }

  // candidates[i]: planes that image i may show.
  Revisits Run(const std::vector<std::vector<int>>& candidates, ProgressReporter& progress) const {
    const auto count = static_cast<int>(images_.size());
    std::vector<Revisits> found(images_.size());
    std::atomic<int> done = 0;
    tbb::parallel_for(0, count, [&](int i) {
      found[i] = FindIn(i, candidates[i]);
      progress.Report("revisits", ++done, count);
    });
    Revisits all;
    std::map<PlanePair, Edge> edges;  // the first image that shows a pair of planes counts
    for (const Revisits& of_image : found) {
      all.seen.insert(all.seen.end(), of_image.seen.begin(), of_image.seen.end());
      for (const Edge& edge : of_image.edges) edges.emplace(PlanePair{edge.a, edge.b}, edge);
    }
    for (const auto& [pair, edge] : edges) all.edges.push_back(edge);
    return all;
  }

 private:
  Revisits FindIn(int image, const std::vector<int>& candidates) const {
    const std::vector<Sighting> sightings = Search(image, candidates);
    Revisits found;
    for (const Sighting& sighting : sightings) {
      if (sighting.view) found.seen.push_back({planes_[sighting.plane].id, *sighting.view});
    }
    for (const int neighbour : {image - 1, image + 1}) {
      if (!sightings.empty() && InOneStretch(image, neighbour)) {
        JoinAcross(image, neighbour, sightings, found.edges);
      }
    }
    return found;
  }

  // The planes seen again in an image, and those that were tracked to it; nothing when there are
  // none of the first kind.
  std::vector<Sighting> Search(int image, const std::vector<int>& candidates) const {
    const Plane all = AsPlane(images_[image]);
    std::vector<Sighting> sightings;
    for (const int p : candidates) {
      const Plane& plane = planes_[p];
      if (FindView(plane, all.reference) != nullptr) continue;
      const auto match = MatchPlanes(plane, PackedRows(type_, plane.descriptors), all, options_);
      if (!match || SpannedShare(plane, *match, all) < kMinSpanned) continue;
      const PlaneView view = {all.reference, Normalised(match->m_from_n.b_from_a),
                              static_cast<int>(match->inliers.size())};
      sightings.push_back({p, view, std::vector<bool>(all.features.size())});
      for (const Match& inlier : match->inliers) sightings.back().shows[inlier.b] = true;
    }
    if (sightings.empty()) return sightings;
    const auto followed = followed_to_.find(all.reference);
    if (followed == followed_to_.end()) return sightings;
    for (const int p : followed->second) {
      const PlaneView& view = *FindView(planes_[p], all.reference);
      sightings.push_back({p, std::nullopt, KeypointsOf(planes_[p], view, all)});
    }
    return sightings;
  }

  // The keypoints that are features of a plane whose view is known.
  std::vector<bool> KeypointsOf(const Plane& plane, const PlaneView& view,
                                const Plane& image) const {
    std::vector<bool> shows(image.features.size());
    for (const Match& match :
         MatchDescriptors(plane.descriptors, image.descriptors, type_, options_.match)) {
      const Vector2d x =
          Apply(view.reference_from_keyframe, PositionOf(image.features[match.b].reference));
      const Vector2d feature = PositionOf(plane.features[match.a].reference);
      shows[match.b] = (x - feature).norm() <= options_.reacquire_px;
    }
    return shows;
  }

  bool InOneStretch(int image, int neighbour) const {
    if (neighbour < 0 || neighbour >= static_cast<int>(images_.size())) return false;
    const auto stretch_of = [&](int i) {
      return std::ranges::lower_bound(keyframes_, images_[i].keyframe, {}, &Keyframe::id)->stretch;
    };
    return stretch_of(image) == stretch_of(neighbour);
  }

  // Carries the planes to a neighbouring image and appends edges between those seen again and
  // others that turn out to be the same plane.
  void JoinAcross(int image, int neighbour, const std::vector<Sighting>& sightings,
                  std::vector<Edge>& edges) const {
    const Features& here = images_[image].features;
    const Features& there = images_[neighbour].features;
    const std::vector<Match> matches =
        MatchDescriptors(here.descriptors, there.descriptors, type_, options_.match);
    // The earlier of the two images from the later one, as in the rest of the graph.
    const auto follow = [&](const Sighting& sighting) {
      MatchedPoints points;
      for (const Match& match : matches) {
        if (!sighting.shows[match.a]) continue;
        points.from.push_back(PositionOf(here.keypoints[match.a]));
        points.to.push_back(PositionOf(there.keypoints[match.b]));
      }
      if (image < neighbour) std::swap(points.from, points.to);
      return Follow(points, planes_[sighting.plane].id, image);
    };
    std::vector<std::optional<HomographyEstimate>> motions;
    for (const Sighting& sighting : sightings) motions.push_back(follow(sighting));
    const KeyframeId from = images_[std::min(image, neighbour)].keyframe;
    const KeyframeId to = images_[std::max(image, neighbour)].keyframe;
    for (size_t m = 0; m < sightings.size(); ++m) {
      for (size_t n = m + 1; n < sightings.size() && sightings[m].view; ++n) {
        if (!motions[m] || !motions[n]) continue;
        const bool ordered = sightings[m].plane < sightings[n].plane;
        const auto [a, b] = Ordered(planes_[sightings[m].plane].id, planes_[sightings[n].plane].id);
        const PlaneId surface_m = surface_of_[sightings[m].plane];
        const PlaneId surface_n = surface_of_[sightings[n].plane];
        if (surface_m == surface_n || joined_.contains(Ordered(surface_m, surface_n))) continue;
        const Homology homology = TestHomology(*motions[ordered ? m : n], *motions[ordered ? n : m],
                                               options_.segmentation.homology);
        if (homology.kind != HomologyKind::kSamePlane) continue;
        edges.push_back({a, b, from, to, homology.matrix, homology.third_eigenvalue});
      }
    }
  }

  std::optional<HomographyEstimate> Follow(const MatchedPoints& points, PlaneId plane,
                                           int image) const {
    if (static_cast<int>(points.from.size()) < options_.min_tracked) return std::nullopt;
    const auto estimate =
        EstimateHomography(points, options_.segmentation.ransac,
                           options_.seed ^ (plane.value << 20) ^ images_[image].keyframe.value);
    if (!estimate || static_cast<int>(estimate->inliers.size()) < options_.min_tracked ||
        static_cast<double>(estimate->inliers.size()) <
            options_.min_support * static_cast<double>(points.from.size())) {
      return std::nullopt;
    }
    return estimate->to_from;
  }

  const std::vector<Plane>& planes_;
  const std::vector<Keyframe>& keyframes_;
  const std::vector<SampledKeyframe>& images_;
  FeatureType type_;
  const PlaneLayerOptions& options_;
  std::vector<PlaneId> surface_of_;                     // of each plane
  std::set<PlanePair> joined_;                          // surfaces with an edge between them
  std::map<KeyframeId, std::vector<int>> followed_to_;  // planes, by the keyframe of a view
};

}  // namespace

Revisits FindRevisits(const std::vector<Plane>& planes, const std::vector<Edge>& edges,
                      const std::vector<Keyframe>& keyframes,
                      const std::vector<SampledKeyframe>& images, FeatureType type,
                      const PlaneLayerOptions& options, ProgressReporter& progress) {
  return RevisitFinder(planes, edges, keyframes, images, type, options)
      .Run(ProposeSightings(planes, images, type, options.fusion), progress);
}

}  // namespace waystone
