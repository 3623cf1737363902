// SPDX-License-Identifier: Apache-2.0
#include "builder/poses/keyframe_reader.h"

#include <algorithm>
#include <iterator>
#include <optional>
#include <string>
#include <utility>

#include "builder/frames/frame_pipeline.h"
#include "builder/planes/plane_layer.h"
#include "core/base/error.h"
#include "core/base/text.h"

namespace waystone {
namespace {

// Takes the features of a sequence's keyframes, and of no other frame.
class KeyframeReader : public LayerBuilder {
 public:
  KeyframeReader(const std::vector<const Keyframe*>& keyframes, const std::optional<Camera>& camera,
                 const FeatureOptions& options)
      : keyframes_(keyframes), camera_(camera), options_(options) {}

  std::string stage() const override { return "frames"; }
  void StartSequence(SequenceId /*id*/, const Source& source) override { name_ = source.name(); }

  std::unique_ptr<Observation> Observe(const Frame& frame) const override {
    if (FindKeyframe(frame.info.number)) return ObserveFeatures(frame, options_, 0);
    auto skipped = std::make_unique<Observation>();
    skipped->info = frame.info;
    return skipped;
  }

  void Add(std::unique_ptr<Observation> observation, ProgressReporter& /*progress*/) override {
    const Keyframe* keyframe = FindKeyframe(observation->info.number);
    if (!keyframe) return;
    auto& observed = static_cast<PlaneObservation&>(*observation);
    RequireSame(*keyframe, observed);
    read_.push_back({keyframe->id, std::move(observed.features)});
  }

  void FinishSequence(const FrameReport& /*sequence*/) override {
    if (read_.size() == keyframes_.size()) return;
    Refuse("it has " + std::to_string(read_.size()) + " of the map's " +
           std::to_string(keyframes_.size()) + " keyframes");
  }
  void Finish(MapData& /*map*/, ProgressReporter& /*progress*/) override {}

  std::vector<SampledKeyframe> Take() { return std::move(read_); }

 private:
  const Keyframe* FindKeyframe(int frame) const {
    const auto found = std::ranges::lower_bound(keyframes_, frame, {}, &Keyframe::frame);
    return found != keyframes_.end() && (*found)->frame == frame ? *found : nullptr;
  }

  void RequireSame(const Keyframe& keyframe, const PlaneObservation& observed) const {
    if (!observed.error.empty()) Refuse(observed.info.source + ": " + observed.error);
    const std::string frame = "frame " + std::to_string(keyframe.frame);
    if (observed.info.source != keyframe.source) {
      Refuse(frame + " is " + observed.info.source + ", the map's is " + keyframe.source);
    }
    const cv::Size image = ImageSize(observed.features);
    const cv::Size of_map(keyframe.width, keyframe.height);
    if (!ReducesTo(image, of_map)) {
      Refuse(frame + " is " + SizeText(image.width, image.height) + " px, the map's is " +
             SizeText(of_map.width, of_map.height));
    }
    if (camera_ && cv::Size(camera_->width, camera_->height) != image) {
      Refuse(frame + " is " + SizeText(image.width, image.height) + " px, the map's camera has " +
             SizeText(camera_->width, camera_->height));
    }
  }

  // Whether one factor makes the map's working image of it (WorkingSize).
  static bool ReducesTo(const cv::Size& image, const cv::Size& working) {
    const double scale = working.width / static_cast<double>(image.width);
    return scale <= 1 && cvRound(scale * image.height) == working.height;
  }

  [[noreturn]] void Refuse(const std::string& cause) const {
    throw MapError(ErrorCode::kBadSource, "'" + name_ + "' isn't what the map was built from: " +
                                              cause + "; specify the map's own images");
  }

  const std::vector<const Keyframe*>& keyframes_;  // ordered by frame
  const std::optional<Camera>& camera_;
  const FeatureOptions& options_;
  std::string name_;
  std::vector<SampledKeyframe> read_;
};

}  // namespace

std::vector<SampledKeyframe> ReadKeyframes(const MapData& map,
                                           std::span<const std::unique_ptr<Source>> sources,
                                           const FeatureOptions& options,
                                           const ProgressCallback& progress) {
  options.Check();
  if (sources.size() != map.sequences.size()) {
    throw MapError(ErrorCode::kBadSource,
                   "the map was built from " + std::to_string(map.sequences.size()) +
                       " sequences, but " + std::to_string(sources.size()) +
                       " were given; specify each of them, in the order of the build");
  }
  ProgressReporter reporter(progress);
  std::vector<SampledKeyframe> read;
  for (size_t i = 0; i < sources.size(); ++i) {
    const SequenceId id = map.sequences[i].id;
    std::vector<const Keyframe*> keyframes;
    for (const Keyframe& keyframe : map.keyframes) {
      if (keyframe.sequence == id) keyframes.push_back(&keyframe);
    }
    std::ranges::stable_sort(keyframes, {}, &Keyframe::frame);
    KeyframeReader reader(keyframes, map.sequences[i].camera, options);
    LayerBuilder* const layers[] = {&reader};
    ObserveSequence(*sources[i], id, layers, reporter);
    std::ranges::move(reader.Take(), std::back_inserter(read));
  }
  std::ranges::sort(read, {}, &SampledKeyframe::keyframe);
  return read;
}

}  // namespace waystone
