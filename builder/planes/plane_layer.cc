// SPDX-License-Identifier: Apache-2.0
#include "builder/planes/plane_layer.h"

#include <algorithm>
#include <map>
#include <set>
#include <utility>

#include "builder/frames/shrink.h"
#include "builder/planes/fusion.h"
#include "builder/planes/one_surface.h"
#include "builder/planes/outline.h"
#include "builder/planes/plane_features.h"
#include "builder/planes/revisits.h"
#include "core/base/clock.h"
#include "core/base/error.h"
#include "core/camera/image_plane.h"
#include "core/image/encode.h"
#include "schema/layers/planes/index_features.h"

namespace waystone {
namespace {

constexpr int kThumbnailQuality = 80;  // of WebP

// The edges between remaining planes.
std::vector<Edge> KeepEdges(const std::vector<Edge>& edges, const std::vector<Plane>& planes) {
  std::set<PlaneId> ids;
  for (const Plane& plane : planes) ids.insert(plane.id);
  std::vector<Edge> kept;
  for (const Edge& edge : edges) {
    if (ids.contains(edge.a) && ids.contains(edge.b)) kept.push_back(edge);
  }
  std::ranges::sort(kept, {}, [](const Edge& edge) { return std::pair(edge.a, edge.b); });
  return kept;
}

// Returns how many features were dropped.
int DropSparse(const PlaneLayerOptions& options, std::vector<Plane>& planes) {
  size_t dropped = 0;
  for (Plane& plane : planes) {
    const size_t before = plane.features.size();
    DropSparseFeatures(options.plenty_of_features, options.votes_in_plenty, plane);
    dropped += before - plane.features.size();
  }
  return static_cast<int>(dropped);
}

// Ids without gaps, in the order in which the planes were found.
void Renumber(MapData& map) {
  std::map<PlaneId, PlaneId> renumbered;
  for (Plane& plane : map.planes) {
    const PlaneId id{std::ssize(renumbered) + 1};
    renumbered[plane.id] = id;
    plane.id = id;
  }
  for (Edge& edge : map.edges) {
    edge.a = renumbered.at(edge.a);
    edge.b = renumbered.at(edge.b);
  }
}

[[noreturn]] void FailWithoutFrames(const FrameReport& report) {
  const std::string first =
      report.skipped_names.empty() ? "" : " (first: " + report.skipped_names.front() + ")";
  throw MapError(ErrorCode::kBadSource, "none of the " + std::to_string(report.frames) +
                                            " frames could be decoded" + first +
                                            "; check that the images open in a viewer");
}

}  // namespace

std::unique_ptr<PlaneObservation> ObserveFeatures(const Frame& frame, const FeatureOptions& options,
                                                  int image_width) {
  auto observation = std::make_unique<PlaneObservation>();
  observation->info = frame.info;
  observation->error = frame.error;
  if (frame.grey.empty()) return observation;
  observation->features = ExtractFeatures(frame.grey, options);
  if (image_width > 0) observation->thumbnail = ShrinkToWidth(frame.grey, image_width);
  return observation;
}

PlaneLayerBuilder::PlaneLayerBuilder(const PlaneBuildOptions& options)
    : options_(options),
      tracker_(options.planes),
      landmarks_(options.planes.landmarks),
      sample_(options.max_samples),
      images_(options.max_images) {}

void PlaneLayerBuilder::StartSequence(SequenceId id, const Source& source) {
  sequence_ = id;
  camera_ = source.camera();
  selector_.emplace(options_.keyframes, options_.planes.match);
}

std::unique_ptr<Observation> PlaneLayerBuilder::Observe(const Frame& frame) const {
  return ObserveFeatures(frame, options_.features, options_.image_width);
}

void PlaneLayerBuilder::Add(std::unique_ptr<Observation> observation, ProgressReporter& progress) {
  auto& observed = static_cast<PlaneObservation&>(*observation);
  if (!observed.error.empty()) return;
  if (options_.max_images > 0) {
    images_seen_.emplace_back(sequence_, observed.info.number);
    images_.Add(KeyframeId{std::ssize(images_seen_)}, observed.features);
  }
  const Clock::time_point start = Clock::now();
  const std::vector<ChosenKeyframe> chosen =
      selector_->Add({std::move(observed.info), observed.thumbnail, std::move(observed.features)});
  report_.choose_s += SecondsSince(start);
  for (const ChosenKeyframe& keyframe : chosen) AddKeyframe(keyframe);
  progress.SetPlanes(static_cast<int>(keyframes_.size()), tracker_.plane_count());
}

void PlaneLayerBuilder::FinishSequence(const FrameReport& sequence) {
  report_.Append(sequence);
  const Clock::time_point start = Clock::now();
  for (const ChosenKeyframe& keyframe : selector_->Finish()) AddKeyframe(keyframe);
  report_.add_s += SecondsSince(start);
  selector_.reset();
}

void PlaneLayerBuilder::AddKeyframe(const ChosenKeyframe& chosen) {
  Keyframe keyframe;
  keyframe.id = KeyframeId{std::ssize(keyframes_) + 1};
  keyframe.sequence = sequence_;
  report_.stretches += chosen.starts_stretch;
  keyframe.stretch = report_.stretches - 1;
  keyframe.frame = chosen.frame.info.number;
  keyframe.source = chosen.frame.info.source;
  keyframe.time_s = chosen.frame.info.time_s;
  keyframe.width = chosen.frame.features.width;
  keyframe.height = chosen.frame.features.height;
  if (!chosen.frame.thumbnail.empty()) {
    keyframe.picture = EncodePicture(chosen.frame.thumbnail, kThumbnailQuality);
  }
  const std::optional<Camera> camera =
      camera_ ? std::optional(ScaledCamera(*camera_, keyframe.width)) : std::nullopt;
  tracker_.AddKeyframe(keyframe.id, chosen.frame.features, chosen.starts_stretch, camera);
  landmarks_.Add(keyframe.id, chosen.frame.features, chosen.starts_stretch);
  sample_.Add(keyframe.id, chosen.frame.features);
  features_.push_back({keyframe.id, chosen.frame.features});
  image_of_keyframe_.emplace_back(sequence_, keyframe.frame);
  keyframes_.push_back(std::move(keyframe));
}

std::vector<WalkImage> PlaneLayerBuilder::TakeFeatures() {
  std::vector<WalkImage> taken;
  const std::set<ImageRef> keyframes(image_of_keyframe_.begin(), image_of_keyframe_.end());
  for (SampledKeyframe& one : features_) {
    const auto& [sequence, frame] = image_of_keyframe_[static_cast<size_t>(one.keyframe.value - 1)];
    taken.push_back({sequence, frame, std::move(one.features)});
  }
  for (const SampledKeyframe& one : images_.keyframes()) {
    const ImageRef& image = images_seen_[static_cast<size_t>(one.keyframe.value - 1)];
    if (!keyframes.contains(image)) taken.push_back({image.first, image.second, one.features});
  }
  features_.clear();
  return taken;
}

void PlaneLayerBuilder::Finish(MapData& map, ProgressReporter& progress) {
  if (report_.frames == report_.skipped) FailWithoutFrames(report_);
  FinishTracking(map);
  const auto report = [&](int done) {
    progress.SetPlanes(static_cast<int>(map.keyframes.size()), static_cast<int>(map.planes.size()));
    progress.Report("fusion", done, 1);
  };
  report(0);
  Fuse(map, progress);
  Renumber(map);
  OutlinePlanes(map);
  landmarks_.Finish(map);
  map.index = IndexFeatures(map);
  report(1);
}

void PlaneLayerBuilder::FinishTracking(MapData& map) {
  tracker_.Finish();
  const TrackerReport& tracker = tracker_.report();
  report_.rotation_only = tracker.rotation_only;
  report_.planes_started = tracker.started;
  report_.planes_rejected = tracker.rejected;
  report_.planes_merged = tracker.merged;
  report_.planes_dropped = tracker.dropped;
  report_.features_dropped = tracker.features_dropped;
  map.keyframes = std::move(keyframes_);
  map.planes = std::move(tracker_.planes());
  std::ranges::sort(map.planes, {}, &Plane::id);
  map.edges = KeepEdges(tracker_.edges(), map.planes);
}

// Features that few keyframes found are dropped last, so that fusion sees everything that planes
// have in common.
void PlaneLayerBuilder::Fuse(MapData& map, ProgressReporter& progress) {
  const Clock::time_point start = Clock::now();
  FusionResult fusion = FusePlanes(std::move(map.planes), map.edges, map.keyframes,
                                   options_.features.type, options_.planes);
  map.planes = std::move(fusion.planes);
  map.edges = std::move(fusion.edges);
  report_.planes_fused = fusion.fused;
  const Revisits again = FindRevisits(map.planes, map.edges, map.keyframes, features_,
                                      options_.features.type, options_.planes, progress);
  for (const PlaneSeenAgain& one : again.seen) {
    std::vector<PlaneView>& views =
        std::ranges::lower_bound(map.planes, one.plane, {}, &Plane::id)->views;
    views.insert(std::ranges::lower_bound(views, one.view.keyframe, {}, &PlaneView::keyframe),
                 one.view);
  }
  map.edges.insert(map.edges.end(), again.edges.begin(), again.edges.end());
  std::ranges::sort(map.edges, {}, [](const Edge& edge) { return std::pair(edge.a, edge.b); });
  if (!again.seen.empty()) {
    JoinSurfaces(map.planes, map.keyframes, options_.planes.fusion.max_apart_px, map.edges);
  }
  report_.features_dropped += DropSparse(options_.planes, map.planes);
  report_.fusion_s = SecondsSince(start);
}

}  // namespace waystone
