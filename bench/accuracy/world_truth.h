// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <set>
#include <string>
#include <vector>

#include "bench/accuracy/world_source.h"
#include "core/features/features.h"
#include "schema/map_data.h"
#include "world/truth.h"

namespace waystone::bench {

// A match is on a plane if it agrees with the true homography to within this.
constexpr double kTrueMatch_px = 3;

// The planes that a frame shows within 3 px of a point: features lie on edges. `plane_ids` is
// RenderedFrame's; outside the image it is 0.
std::set<int> PlanesNear(const cv::Mat& plane_ids, const Eigen::Vector2d& x);

// What is true of a map that was built from a rendered walk. Pixels are those of its working
// images, errors those of the rendered ones.
class WorldTruth {
 public:
  // `features` are the map's.
  WorldTruth(const World& world, const WorldSource& source, const Walk& walk, const MapData& map,
             const FeatureOptions& features);

  // The true plane on which most of a map plane's features lie, and their share, each looked up
  // where it was first seen: a surface that grows into view may be hidden in the reference image.
  struct Owner {
    int plane = 0;
    double share = 0;
  };
  Owner OwnerOf(const Plane& plane) const;

  // The matched features that a true plane carries between two keyframes (indices in
  // map.keyframes): those whose match agrees with the plane's true homography.
  std::map<int, int> CarriedMatches(int from, int to) const;

  // The true homography to_from of a plane between two keyframes.
  Eigen::Matrix3d ToFrom(int true_plane, KeyframeId from, KeyframeId to) const;

  // Whether a keyframe shows any of a true plane; a grid of every fourth pixel in both directions.
  bool Shows(KeyframeId keyframe, int true_plane) const;

  // Pixels of a plane's reference image inside its outline, and those of them that show the true
  // plane; a grid of every fourth pixel in both directions.
  struct Outlined {
    int pixels = 0;
    int of_plane = 0;
  };
  Outlined PixelsInside(const std::vector<Eigen::Vector2d>& outline, KeyframeId reference,
                        int true_plane) const;

  // Errors of a view's homography at the plane's features that lie in the view's image, px in the
  // reference image.
  std::vector<double> ViewErrors(const Plane& plane, const PlaneView& view, int true_plane) const;

 private:
  int IndexOf(KeyframeId id) const { return static_cast<int>(id.value) - 1; }

  const World& world_;
  const Walk& walk_;
  const MapData& map_;
  Camera camera_;                   // of the working images
  double image_px_;                 // pixels of a rendered image to one of these
  std::vector<cv::Mat> plane_ids_;  // of each keyframe
  std::vector<Features> features_;  // of each keyframe
  // Keyframe and keypoint that a descriptor was taken from.
  std::map<std::string, std::pair<int, int>> seen_;
};

}  // namespace waystone::bench
