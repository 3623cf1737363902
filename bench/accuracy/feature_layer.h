// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <utility>

#include "builder/planes/plane_layer.h"

namespace waystone::bench {

// The decoding and features of the plane layer only: passes each usable frame to `take`.
class FeatureLayer : public LayerBuilder {
 public:
  FeatureLayer(const FeatureOptions& options, std::function<void(ExtractedFrame)> take)
      : options_(options), take_(std::move(take)) {}

  std::string stage() const override { return "frames"; }
  void StartSequence(SequenceId, const Source&) override {}
  std::unique_ptr<Observation> Observe(const Frame& frame) const override {
    return ObserveFeatures(frame, options_, 0);
  }
  void Add(std::unique_ptr<Observation> observation, ProgressReporter&) override {
    auto& observed = static_cast<PlaneObservation&>(*observation);
    if (observed.error.empty()) take_({observed.info, {}, std::move(observed.features)});
  }
  void FinishSequence(const FrameReport&) override {}
  void Finish(MapData&, ProgressReporter&) override {}

 private:
  FeatureOptions options_;
  std::function<void(ExtractedFrame)> take_;
};

}  // namespace waystone::bench
