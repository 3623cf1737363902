// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "builder/appearance/options.h"
#include "builder/frames/frame_report.h"

// First step of the appearance layer: described panoramas are collected.
namespace waystone {

// What is kept of a frame, besides the signature for its trajectory, until the nodes are made.
struct TakenFrame {
  FrameInfo info;
  FourierSignature signature;
  std::vector<uint8_t> picture;
  NodeFeatures kept;
};

// A panorama that keeps all of its features.
struct TakenSample {
  int panorama = 0;
  BearingFeatures features;
};

// The usable panoramas of all sources, one after the other.
struct TakenPanoramas {
  std::vector<FourierSignature> signatures;  // from which odometry and loops are measured
  std::vector<TakenFrame> frames;
  std::vector<PanoramaStretch> stretches;  // of each sequence
  std::vector<SequenceId> sequences;
  std::vector<TakenSample> samples;
  ElevationBand band;                 // of all signatures
  std::optional<LayerMirror> mirror;  // of the first image that is a mirror's

  int size() const { return static_cast<int>(signatures.size()); }
  // Which stretch a panorama is of.
  size_t StretchOf(int panorama) const;
};

// Takes the described panoramas of sequences in order. Not thread-safe.
class PanoramaTaker {
 public:
  // The options must outlive it.
  explicit PanoramaTaker(const AppearanceOptions& options)
      : options_(options), chooser_(options.describe.features) {}

  void StartSequence(SequenceId id, const std::string& name);
  // The next usable panorama. Throws MapError as AppearanceLayerBuilder::Add does, and the
  // following as its FinishSequence.
  void Take(DescribedPanorama panorama);
  void FinishSequence(const FrameReport& sequence);
  TakenPanoramas Finish() { return std::move(taken_); }

 private:
  void TakeFeatures(BearingFeatures features);
  void ThinSamples();
  void CheckBand(const DescribedPanorama& panorama) const;
  void CheckSequence(const FrameReport& sequence) const;

  const AppearanceOptions& options_;
  NodeFeatureChooser chooser_;
  int stride_ = 1;    // every stride-th panorama is a sample
  std::string name_;  // of the sequence
  TakenPanoramas taken_;
};

}  // namespace waystone
