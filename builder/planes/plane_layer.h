// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "builder/frames/layer_builder.h"
#include "builder/planes/keyframe_sample.h"
#include "builder/planes/keyframe_selector.h"
#include "builder/planes/landmarks.h"
#include "builder/planes/options.h"
#include "builder/planes/plane_tracker.h"
#include "core/features/features.h"

namespace waystone {

// Everything the plane layer is made with.
struct PlaneBuildOptions {
  FeatureOptions features;
  KeyframeOptions keyframes;
  PlaneLayerOptions planes;
  int image_width = 320;  // of the picture kept of each keyframe, px; 0 keeps none
  int max_samples = 40;   // keyframes that samples() returns, for calibration
  int max_images = 0;     // other images whose features are kept for TakeFeatures
};

// What building the layer did. FrameReport::add_s covers the choice of keyframes and planes.
struct PlaneReport : FrameReport {
  int stretches = 0;
  int rotation_only = 0;  // keyframe pairs that only rotated
  int planes_started = 0;
  int planes_rejected = 0;   // by the homology test
  int planes_merged = 0;     // by the homology test (identity) while tracking
  int planes_fused = 0;      // by eq. (6)
  int planes_dropped = 0;    // contradicted, or too few features left after the votes
  int features_dropped = 0;  // by the votes
  int keyframes_linked = 0;  // with others of the same place, by BuildMap (LinkRevisits)
  double choose_s = 0;       // choice of keyframes
  double fusion_s = 0;
  double calibrate_s = 0;  // of the verdict, by BuildMap
};

// A frame's features and the picture that is kept of it.
struct PlaneObservation : Observation {
  Features features;
  cv::Mat thumbnail;
};
std::unique_ptr<PlaneObservation> ObserveFeatures(const Frame& frame, const FeatureOptions& options,
                                                  int image_width);

// The plane layer: Algorithm 1 of Montijano and Sagues 2009. Chooses keyframes, follows planes from
// each to the next, fuses those seen again (eq. 6), and finishes keyframes, planes, edges and the
// index of the map. Deterministic on any number of threads.
class PlaneLayerBuilder : public LayerBuilder {
 public:
  // Throws MapError(kBadOptions).
  explicit PlaneLayerBuilder(const PlaneBuildOptions& options);

  std::string stage() const override { return "frames"; }
  void StartSequence(SequenceId id, const Source& source) override;
  std::unique_ptr<Observation> Observe(const Frame& frame) const override;
  void Add(std::unique_ptr<Observation> observation, ProgressReporter& progress) override;
  void FinishSequence(const FrameReport& sequence) override;
  // Throws MapError(kBadSource) when no frame could be decoded.
  void Finish(MapData& map, ProgressReporter& progress) override;

  const PlaneReport& report() const { return report_; }
  const std::vector<SampledKeyframe>& samples() const { return sample_.keyframes(); }
  // The features of all keyframes, ascending: 150 kB each.
  const std::vector<SampledKeyframe>& features() const { return features_; }
  // Moves out the features of all keyframes, and of at most max_images other images, evenly spread
  // over the sequences.
  std::vector<WalkImage> TakeFeatures();

 private:
  // An image, by its sequence and its number there.
  using ImageRef = std::pair<SequenceId, int>;

  void AddKeyframe(const ChosenKeyframe& chosen);
  void FinishTracking(MapData& map);
  void Fuse(MapData& map, ProgressReporter& progress);

  PlaneBuildOptions options_;
  PlaneTracker tracker_;
  LandmarkChooser landmarks_;
  KeyframeSample sample_;
  std::vector<SampledKeyframe> features_;
  std::vector<ImageRef> image_of_keyframe_;
  KeyframeSample images_;  // numbered as they came, from 1
  std::vector<ImageRef> images_seen_;
  SequenceId sequence_;
  std::optional<Camera> camera_;
  std::optional<KeyframeSelector> selector_;
  std::vector<Keyframe> keyframes_;
  PlaneReport report_;
};

}  // namespace waystone
