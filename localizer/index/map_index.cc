// SPDX-License-Identifier: Apache-2.0
#include "localizer/index/map_index.h"

#include <algorithm>
#if defined(__GLIBC__)
#include <malloc.h>
#endif

#include "core/base/check.h"
#include "core/base/error.h"
#include "core/features/descriptor_codes.h"
#include "localizer/index/spacing_parallax.h"
#include "schema/layers/planes/index_features.h"

namespace waystone {
namespace {

constexpr int64_t kTrimmedBytes = 16'000'000;

[[noreturn]] void FailReference(const std::string& what) {
  throw MapError(ErrorCode::kMapDamaged,
                 what + ", which is not in the map; run `waystone check` on it");
}

}  // namespace

std::shared_ptr<const MapIndex> MapIndex::Build(MapData map) {
  return std::shared_ptr<const MapIndex>(new MapIndex(std::move(map)));
}

MapIndex::MapIndex(MapData map) : map_(std::move(map)) {
  for (size_t i = 0; i < map_.sequences.size(); ++i) sequence_index_[map_.sequences[i].id] = i;
  for (size_t i = 0; i < map_.keyframes.size(); ++i) keyframe_index_[map_.keyframes[i].id] = i;
  for (size_t i = 0; i < map_.planes.size(); ++i) plane_index_[map_.planes[i].id] = i;
  if (map_.orientation) {
    const std::vector<OrientationFrame>& frames = map_.orientation->frames;
    for (size_t i = 0; i < frames.size(); ++i) {
      frame_index_[{frames[i].sequence, frames[i].frame}] = static_cast<int>(i);
    }
  }
  CheckReferences();
  points_ = LocateMapPoints(map_);
  if (map_.poses) horizontal_ = HorizontalOf(*map_.poses);
  names_ = NamedPlaces(map_);
  floor_plans_ = FloorPlanFinder(map_);
  TakeDescriptors();
  CollectViews();
  if (map_.appearance) TakeAppearance();
  for (const Edge& edge : map_.edges) {
    neighbours_[edge.a].push_back(edge.b);
    neighbours_[edge.b].push_back(edge.a);
  }
  for (auto& [id, ids] : neighbours_) std::sort(ids.begin(), ids.end());
  surface_of_plane_ = FindSurfaces(map_.planes, map_.edges);
  linked_.resize(map_.keyframes.size());
  for (const KeyframeLink& link : map_.links) {
    linked_[IndexOf(link.a)].push_back(IndexOf(link.b));
    linked_[IndexOf(link.b)].push_back(IndexOf(link.a));
  }
  for (std::vector<int>& keyframes : linked_) std::ranges::sort(keyframes);
}

// Their descriptors come after the planes'.
void MapIndex::TakeLandmarks() {
  const FeatureType type = map_.info.feature_type;
  keyframe_of_row_.assign(first_row_.back(), -1);
  for (int k = 0; k < static_cast<int>(map_.keyframes.size()); ++k) {
    Landmarks& landmarks = map_.keyframes[k].landmarks;
    const auto first = static_cast<int>(keyframe_of_row_.size());
    first_landmark_row_.push_back(first);
    const Descriptors descriptors = DecodeDescriptors(landmarks.codes, type);
    for (int i = 0; i < descriptors.rows(); ++i) search_.Set(first + i, descriptors.row(i));
    keyframe_of_row_.resize(first + descriptors.rows(), k);
    landmarks.codes = Descriptors(CodeBytes(type));
  }
  first_landmark_row_.push_back(static_cast<int>(keyframe_of_row_.size()));
}

void MapIndex::CollectViews() {
  seen_.resize(map_.keyframes.size());
  saw_.resize(map_.planes.size());
  for (int p = 0; p < static_cast<int>(map_.planes.size()); ++p) {
    const std::vector<PlaneView>& views = map_.planes[p].views;
    for (int v = 0; v < static_cast<int>(views.size()); ++v) {
      const int keyframe = keyframe_index_.at(views[v].keyframe);
      seen_[keyframe].push_back({p, v});
      saw_[p].push_back(keyframe);
    }
  }
}

void MapIndex::TakeAppearance() {
  appearance_ = AppearanceIndex(*map_.appearance, {}, map_.poses ? &*map_.poses : nullptr);
  const double measured =
      MeasureSpacingParallax(*map_.appearance, map_.info.feature_type, appearance_.spacing());
  if (measured > 0) spacing_parallax_rad_ = measured;
}

// Moves the descriptors plane by plane, so that they are never in memory twice.
void MapIndex::TakeDescriptors() {
  const FeatureType type = map_.info.feature_type;
  const auto rows = static_cast<int>(CountFeatures(map_));
  if (!map_.index) map_.index = IndexFeatures(map_);
  search_ = map_.index ? SearchIndex(type, *map_.index) : SearchIndex(type, rows);
  map_.index.reset();
  plane_of_row_.reserve(rows);
  for (int p = 0; p < static_cast<int>(map_.planes.size()); ++p) {
    Plane& plane = map_.planes[p];
    const auto first = static_cast<int>(plane_of_row_.size());
    first_row_.push_back(first);
    for (int f = 0; f < plane.descriptors.rows(); ++f) {
      search_.Set(first + f, plane.descriptors.row(f));
    }
    plane_of_row_.resize(first + plane.descriptors.rows(), p);
    plane.descriptors = Descriptors(DescriptorBytes(type));
  }
  first_row_.push_back(static_cast<int>(plane_of_row_.size()));
  plane_of_row_.resize(rows, -1);
  TakeLandmarks();
#if defined(__GLIBC__)
  // The memory of the planes' own blocks would stay with the process. For small maps the next one
  // reuses it: trimming releases all free memory, which running queries would have to fault in
  // again.
  if (int64_t{rows} * DescriptorBytes(type) >= kTrimmedBytes) malloc_trim(0);
#endif
}

void MapIndex::CheckReferences() const {
  for (const Keyframe& keyframe : map_.keyframes) {
    if (!FindSequence(keyframe.sequence)) {
      FailReference("keyframe " + std::to_string(keyframe.id.value) + " is of sequence " +
                    std::to_string(keyframe.sequence.value));
    }
  }
  for (const Plane& plane : map_.planes) {
    const std::string name = "plane " + std::to_string(plane.id.value);
    if (!FindKeyframe(plane.reference)) {
      FailReference(name + " refers to keyframe " + std::to_string(plane.reference.value));
    }
    for (const PlaneView& view : plane.views) {
      if (!FindKeyframe(view.keyframe)) {
        FailReference(name + " was seen by keyframe " + std::to_string(view.keyframe.value));
      }
    }
    if (plane.descriptors.rows() != static_cast<int>(plane.features.size()) ||
        (plane.descriptors.rows() > 0 &&
         plane.descriptors.bytes() != DescriptorBytes(map_.info.feature_type))) {
      throw MapError(ErrorCode::kMapDamaged,
                     name + " has " + std::to_string(plane.features.size()) + " features and " +
                         std::to_string(plane.descriptors.rows()) +
                         " descriptors; run `waystone check` on the map");
    }
  }
  for (const Edge& edge : map_.edges) {
    for (PlaneId id : {edge.a, edge.b}) {
      if (!FindPlane(id)) FailReference("an edge leads to plane " + std::to_string(id.value));
    }
  }
  CheckSignatures();
  CheckLandmarks();
  if (!map_.index) return;
  const std::string problem =
      InvertedFileProblem(*map_.index, CountFeatures(map_), map_.info.feature_type);
  if (problem.empty()) return;
  throw MapError(ErrorCode::kMapDamaged,
                 "the search index: " + problem + "; run `waystone check` on the map");
}

void MapIndex::CheckLandmarks() const {
  const int bytes = CodeBytes(map_.info.feature_type);
  for (const Keyframe& keyframe : map_.keyframes) {
    const Landmarks& landmarks = keyframe.landmarks;
    if (landmarks.codes.rows() == landmarks.size() &&
        (landmarks.size() == 0 || landmarks.codes.bytes() == bytes)) {
      continue;
    }
    throw MapError(ErrorCode::kMapDamaged, "keyframe " + std::to_string(keyframe.id.value) +
                                               " has " + std::to_string(landmarks.size()) +
                                               " landmarks and " +
                                               std::to_string(landmarks.codes.rows()) +
                                               " codes; run `waystone check` on the map");
  }
}

void MapIndex::CheckSignatures() const {
  if (!map_.appearance) return;
  const SignatureOptions& described = map_.appearance->described;
  for (const AppearanceNode& node : map_.appearance->nodes) {
    const HalfMatrix& magnitudes = node.signature.magnitudes;
    const HalfMatrix& phases = node.signature.phases;
    if (magnitudes.rows() == described.rows && magnitudes.cols() == described.k1 &&
        phases.rows() == described.rows && phases.cols() == described.k2) {
      continue;
    }
    throw MapError(ErrorCode::kMapDamaged, "appearance node " + std::to_string(node.id.value) +
                                               " has a signature whose size differs from the "
                                               "layer's; run `waystone check` on the map");
  }
}

const NodeFeatureIndex& MapIndex::node_features() const {
  WS_CHECK(map_.appearance, "the map has no appearance layer");
  std::call_once(node_features_made_, [this] {
    node_features_ =
        std::make_unique<const NodeFeatureIndex>(*map_.appearance, map_.info.feature_type);
  });
  return *node_features_;
}

const Plane* MapIndex::FindPlane(PlaneId id) const {
  const auto found = plane_index_.find(id);
  return found == plane_index_.end() ? nullptr : &map_.planes[found->second];
}

const Keyframe* MapIndex::FindKeyframe(KeyframeId id) const {
  const auto found = keyframe_index_.find(id);
  return found == keyframe_index_.end() ? nullptr : &map_.keyframes[found->second];
}

const Sequence* MapIndex::FindSequence(SequenceId id) const {
  const auto found = sequence_index_.find(id);
  return found == sequence_index_.end() ? nullptr : &map_.sequences[found->second];
}

const OrientationFrame* MapIndex::FindFrame(SequenceId sequence, int frame) const {
  const auto found = frame_index_.find({sequence, frame});
  return found == frame_index_.end() ? nullptr : &map_.orientation->frames[found->second];
}

const std::vector<PlaneId>& MapIndex::Neighbours(PlaneId id) const {
  static const std::vector<PlaneId> kNone;
  const auto found = neighbours_.find(id);
  return found == neighbours_.end() ? kNone : found->second;
}

PlaneId MapIndex::SurfaceOf(PlaneId id) const {
  const auto found = plane_index_.find(id);
  WS_CHECK(found != plane_index_.end(), "the plane must be in the map");
  return surface_of_plane_[static_cast<size_t>(found->second)];
}

Descriptors MapIndex::DescriptorsOf(int plane) const {
  return search_.Rows(first_row_[plane], first_row_[plane + 1] - first_row_[plane]);
}

Descriptors MapIndex::LandmarkDescriptorsOf(int keyframe) const {
  const int first = first_landmark_row_[keyframe];
  return search_.Rows(first, first_landmark_row_[keyframe + 1] - first);
}

int MapIndex::IndexOf(KeyframeId id) const {
  const auto found = keyframe_index_.find(id);
  WS_CHECK(found != keyframe_index_.end(), "a keyframe of another map");
  return found->second;
}

}  // namespace waystone
