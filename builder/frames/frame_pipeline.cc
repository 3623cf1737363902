// SPDX-License-Identifier: Apache-2.0
#include "builder/frames/frame_pipeline.h"

#include <tbb/parallel_pipeline.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <memory>
#include <optional>
#include <sstream>
#include <utility>
#include <vector>

#include "core/base/check.h"
#include "core/base/clock.h"
#include "core/base/error.h"
#include "core/image/opencv_errors.h"

namespace waystone {
namespace {

struct TimedObservation {
  std::unique_ptr<Observation> observation;
  double seconds = 0;
};

struct FrameInFlight {
  std::optional<EncodedFrame> encoded;  // until it is observed
  FrameInfo info;
  double decode_s = 0;
  std::vector<TimedObservation> layers;
};

// Two frames a worker: enough that none waits, few enough that memory stays bounded.
size_t CountFramesInFlight() {
  return 2 * static_cast<size_t>(tbb::this_task_arena::max_concurrency()) + 1;
}

// One sequence on its way through the layers.
class SequencePipeline {
 public:
  SequencePipeline(Source& source, std::span<LayerBuilder* const> layers,
                   ProgressReporter& progress)
      : source_(source),
        layers_(layers),
        progress_(progress),
        join_(std::ranges::any_of(layers, &LayerBuilder::NeedsJoinedFrames)),
        reports_(layers.size()) {}

  // Each layer adds in a serial stage of its own, so that the layers work concurrently.
  void Run() {
    auto chain = tbb::make_filter<void, FrameInFlight*>(
                     tbb::filter_mode::serial_in_order,
                     [this](tbb::flow_control& control) { return Read(control); }) &
                 tbb::make_filter<FrameInFlight*, FrameInFlight*>(tbb::filter_mode::parallel,
                                                                  [this](FrameInFlight* frame) {
                                                                    Observe(*frame);
                                                                    return frame;
                                                                  });
    for (size_t i = 0; i < layers_.size(); ++i) {
      chain = chain & tbb::make_filter<FrameInFlight*, FrameInFlight*>(
                          tbb::filter_mode::serial_in_order, [this, i](FrameInFlight* frame) {
                            Add(i, *frame);
                            return frame;
                          });
    }
    tbb::parallel_pipeline(in_flight_.size(), chain & tbb::make_filter<FrameInFlight*, void>(
                                                          tbb::filter_mode::serial_in_order,
                                                          [this](FrameInFlight*) { Report(); }));
  }

  // Ends the sequence in every layer.
  std::vector<FrameReport> Finish() {
    for (size_t i = 0; i < layers_.size(); ++i) layers_[i]->FinishSequence(reports_[i]);
    return std::move(reports_);
  }

 private:
  // Frames leave the last stage in order, so the oldest one's place is the next to be free.
  FrameInFlight* Read(tbb::flow_control& control) {
    std::optional<EncodedFrame> next = source_.NextEncoded();
    if (!next) {
      control.stop();
      return nullptr;
    }
    FrameInFlight& frame = in_flight_[read_++ % in_flight_.size()];
    frame = {.encoded = std::move(next), .info = {}, .layers = {}};
    return &frame;
  }

  void Observe(FrameInFlight& observed) const {
    Clock::time_point start = Clock::now();
    const Frame frame = observed.encoded->Decode(join_);
    observed.encoded.reset();
    observed.info = frame.info;
    observed.decode_s = SecondsSince(start);
    for (const LayerBuilder* layer : layers_) {
      start = Clock::now();
      std::unique_ptr<Observation> observation = layer->Observe(frame);
      observed.layers.push_back({std::move(observation), SecondsSince(start)});
    }
  }

  void Add(size_t layer, FrameInFlight& frame) {
    TimedObservation& observed = frame.layers[layer];
    FrameReport& report = reports_[layer];
    report.Count(frame.info, observed.observation->error);
    report.decode_s += frame.decode_s;
    report.observe_s += observed.seconds;
    const Clock::time_point start = Clock::now();
    layers_[layer]->Add(std::move(observed.observation), progress_);
    report.add_s += SecondsSince(start);
  }

  void Report() {
    ++done_;
    progress_.Report(layers_.front()->stage(), done_, std::max(done_, source_.size()));
  }

  Source& source_;
  std::span<LayerBuilder* const> layers_;
  ProgressReporter& progress_;
  bool join_;
  std::vector<FrameReport> reports_;  // of each layer; written only by its own stage
  // Held here, because TBB never frees what it holds of an interrupted pipeline.
  std::vector<FrameInFlight> in_flight_{CountFramesInFlight()};
  size_t read_ = 0;
  int done_ = 0;
};

// Throws for a sequence of which the layer skipped too much.
void CheckSkipped(const std::string& name, const FrameReport& report, double max_share) {
  const bool none = report.frames > 0 && report.skipped == report.frames;
  if (!none && report.skipped <= max_share * report.frames) return;
  std::ostringstream message;
  message << (none ? "none" : std::to_string(report.frames - report.skipped)) << " of the "
          << report.frames << " frames of '" << name
          << "' can be used (first: " << report.skipped_names.front()
          << "); check that the images open in a viewer";
  if (!none) message << ", or raise the option max_skipped_share from " << max_share;
  throw MapError(none ? ErrorCode::kBadSource : ErrorCode::kUnreadableFrames, message.str());
}

}  // namespace

Sequence ObserveSequence(Source& source, SequenceId id, std::span<LayerBuilder* const> layers,
                         ProgressReporter& progress, double max_skipped_share) {
  WS_CHECK(!layers.empty(), "no layer observes the sequence");
  for (LayerBuilder* layer : layers) layer->StartSequence(id, source);
  SequencePipeline pipeline(source, layers, progress);
  pipeline.Run();
  const std::vector<FrameReport> reports = pipeline.Finish();
  for (const FrameReport& report : reports) CheckSkipped(source.name(), report, max_skipped_share);
  const FrameReport& first = reports.front();
  Sequence sequence;
  sequence.id = id;
  sequence.name = source.name();
  sequence.kind = source.kind();
  sequence.camera = source.camera();
  sequence.frames = first.frames;
  sequence.skipped = first.skipped;
  return sequence;
}

MapData BuildLayer(const std::vector<Source*>& sources, LayerBuilder& layer,
                   const ProgressCallback& callback) {
  if (sources.empty())
    throw MapError(ErrorCode::kBadSource, "no source given; at least one is required");
  cv::setNumThreads(1);  // frames run in parallel instead
  ThrowOpenCvErrors();
  ProgressReporter progress(callback);
  MapData map;
  LayerBuilder* const layers[] = {&layer};
  for (Source* source : sources) {
    const SequenceId id{std::ssize(map.sequences) + 1};
    map.sequences.push_back(ObserveSequence(*source, id, layers, progress));
  }
  layer.Finish(map, progress);
  return map;
}

}  // namespace waystone
