// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "builder/appearance/build_appearance.h"

// First step of BuildAppearanceLayer: sequences are read and described.
namespace waystone {

// What stays of a frame, besides what its trajectory is measured by, until the nodes are made.
struct TakenFrame {
  FrameInfo info;
  FourierSignature signature;
  std::vector<uint8_t> jpeg;
  NodeFeatures kept;
};

// A panorama whose features stay whole.
struct TakenSample {
  int panorama = 0;
  BearingFeatures features;
};

// The usable panoramas of all sources, one after the other.
struct TakenPanoramas {
  std::vector<FourierSignature> signatures;  // by which odometry and loops are measured
  std::vector<TakenFrame> frames;
  std::vector<PanoramaStretch> stretches;  // of each source
  std::vector<Sequence> sequences;
  std::vector<TakenSample> samples;
  ElevationBand band;  // of all signatures

  int size() const { return static_cast<int>(signatures.size()); }
  // Which stretch a panorama is of.
  size_t StretchOf(int panorama) const;
};

class PanoramaTaker {
 public:
  // All three must outlive it; `report` gets the counts and times of what is read.
  PanoramaTaker(const AppearanceOptions& options, const AppearanceProgress& progress,
                AppearanceReport& report)
      : options_(options),
        progress_(progress),
        report_(report),
        chooser_(options.describe.features) {}

  // Throws MapError as BuildAppearanceLayer does.
  void Add(Source& source);
  TakenPanoramas Finish() { return std::move(taken_); }

 private:
  void Take(DescribedFrame frame);
  void TakeFeatures(DescribedFrame& frame);
  void Skip(const DescribedFrame& frame);
  void ThinSamples();
  void CheckBand(const DescribedFrame& frame) const;
  void CheckSequence() const;

  const AppearanceOptions& options_;
  const AppearanceProgress& progress_;
  AppearanceReport& report_;
  NodeFeatureChooser chooser_;
  int stride_ = 1;  // every so-manieth panorama is a sample
  std::string first_skip_;
  TakenPanoramas taken_;
};

}  // namespace waystone
