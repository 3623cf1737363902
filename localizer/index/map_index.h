// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <unordered_map>
#include <utility>
#include <vector>

#include "core/search/search_index.h"
#include "localizer/index/appearance_index.h"
#include "localizer/index/floor_plan_finder.h"
#include "localizer/index/map_points.h"
#include "localizer/index/named_places.h"
#include "localizer/index/node_feature_index.h"
#include "schema/layers/planes/surfaces.h"
#include "schema/layers/poses/horizontal.h"
#include "schema/map_data.h"

namespace waystone {

// A map in memory, ready for queries. Immutable after Build, so any number of threads may share it.
class MapIndex {
 public:
  // Uses the map's search index; for a large map without one it is made here, which takes seconds.
  // Throws MapError(kMapDamaged) for a map whose parts don't refer to each other properly.
  static std::shared_ptr<const MapIndex> Build(MapData map);

  // The map, without its index, the planes' descriptors and the landmarks' codes, which are moved
  // into search().
  const MapData& map() const { return map_; }
  // Nothing for an id that isn't in the map.
  const Plane* FindPlane(PlaneId id) const;
  const Keyframe* FindKeyframe(KeyframeId id) const;
  const Sequence* FindSequence(SequenceId id) const;
  // Ids of the planes with an edge to `id`, ascending; empty for an id that isn't in the map.
  const std::vector<PlaneId>& Neighbours(PlaneId id) const;
  // The surface that a plane of the map is part of, by FindSurfaces; the plane is in the map
  // (WS_CHECK).
  PlaneId SurfaceOf(PlaneId id) const;
  int surface_count() const { return CountSurfaces(surface_of_plane_); }

  // The orientation of a sequence's frame; null where the layer doesn't have it.
  const OrientationFrame* FindFrame(SequenceId sequence, int frame) const;

  // Descriptors of all planes, plane after plane, then of all landmarks, keyframe after keyframe,
  // ready to be searched.
  const SearchIndex& search() const { return search_; }
  // Index in map().planes of the plane that a row of search() belongs to; -1 for a landmark's.
  int PlaneOfRow(int row) const { return plane_of_row_[row]; }
  // Index in map().keyframes of the keyframe whose landmark a row of search() is; -1 for others.
  int KeyframeOfRow(int row) const { return keyframe_of_row_[row]; }
  // The first row of map().planes[plane], and that of the landmarks of map().keyframes[keyframe].
  int FirstRow(int plane) const { return first_row_[plane]; }
  int FirstLandmarkRow(int keyframe) const { return first_landmark_row_[keyframe]; }
  // Where the features of search() are in the frame of the pose layer, by row; empty without one.
  const std::vector<MapPoint>& points() const { return points_; }
  // The frame of the pose layer from above; nothing without one.
  const std::optional<Horizontal>& horizontal() const { return horizontal_; }
  // In which place, as named by people, something is.
  const NamedPlaces& names() const { return names_; }
  // Where something is on the map's floor plans.
  const FloorPlanFinder& floor_plans() const { return floor_plans_; }
  // Descriptors of map().planes[plane], row i belonging to its feature i.
  Descriptors DescriptorsOf(int plane) const;
  bool HasLandmarks() const { return first_landmark_row_.front() < first_landmark_row_.back(); }
  // Whether the map's keyframes can be queried with a photo.
  bool HasKeyframeFeatures() const { return !map_.planes.empty() || HasLandmarks(); }
  // Descriptors of the landmarks of map().keyframes[keyframe], in their order.
  Descriptors LandmarkDescriptorsOf(int keyframe) const;

  // A plane as a keyframe saw it: map().planes[plane].views[view].
  struct SeenPlane {
    int plane = 0;
    int view = 0;
  };
  // What map().keyframes[keyframe] saw, by plane.
  const std::vector<SeenPlane>& PlanesSeenBy(int keyframe) const { return seen_[keyframe]; }
  // The keyframes of map().planes[plane].views, in their order; indices in map().keyframes.
  const std::vector<int>& KeyframesThatSaw(int plane) const { return saw_[plane]; }
  // The keyframes that a link joins with each one, ascending; indices in map().keyframes.
  const std::vector<std::vector<int>>& linked() const { return linked_; }
  const std::vector<int>& LinkedTo(int keyframe) const { return linked_[keyframe]; }
  // Index in map().keyframes; the keyframe is in the map (WS_CHECK).
  int IndexOf(KeyframeId id) const;

  // The appearance layer's signatures, node by node as in map().appearance; empty without one.
  const AppearanceIndex& appearance() const { return appearance_; }
  bool HasAppearance() const { return appearance_.size() > 0; }
  // The median parallax of two panoramas appearance().spacing() apart: measured on the layer's own
  // nodes, or the typical one where they keep no features.
  double spacing_parallax_rad() const { return spacing_parallax_rad_; }
  // The features that the layer's nodes keep, indexed for photos. Made at the first call (any
  // thread), which takes about a second for a million features: queries with panoramas don't need
  // it, and a server makes it before it takes queries. The map has an appearance layer (WS_CHECK).
  const NodeFeatureIndex& node_features() const;

 private:
  // A spacing is about a third of the distance to what is seen: nearer nodes are alike.
  static constexpr double kTypicalParallax_rad = 0.3;

  explicit MapIndex(MapData map);
  void CheckReferences() const;
  void CheckSignatures() const;
  void CheckLandmarks() const;
  void TakeDescriptors();
  void TakeLandmarks();
  void CollectViews();
  void TakeAppearance();

  MapData map_;
  SearchIndex search_;
  AppearanceIndex appearance_;
  double spacing_parallax_rad_ = kTypicalParallax_rad;
  mutable std::once_flag node_features_made_;
  mutable std::unique_ptr<const NodeFeatureIndex> node_features_;
  std::vector<int> plane_of_row_;
  std::vector<int> keyframe_of_row_;
  std::vector<int> first_row_;                // of each plane, and one more for the end
  std::vector<int> first_landmark_row_;       // of each keyframe, and one more for the end
  std::vector<std::vector<SeenPlane>> seen_;  // by each keyframe
  std::vector<std::vector<int>> saw_;         // each plane
  std::vector<std::vector<int>> linked_;      // of each keyframe
  std::vector<PlaneId> surface_of_plane_;
  std::vector<MapPoint> points_;
  std::optional<Horizontal> horizontal_;
  NamedPlaces names_;
  FloorPlanFinder floor_plans_;
  std::unordered_map<PlaneId, int> plane_index_;
  std::unordered_map<KeyframeId, int> keyframe_index_;
  std::unordered_map<SequenceId, int> sequence_index_;
  std::unordered_map<PlaneId, std::vector<PlaneId>> neighbours_;
  std::map<std::pair<SequenceId, int>, int> frame_index_;  // of the orientation layer
};

}  // namespace waystone
