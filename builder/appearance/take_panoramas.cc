// SPDX-License-Identifier: Apache-2.0
#include "builder/appearance/take_panoramas.h"

#include <algorithm>
#include <utility>

#include "core/base/error.h"
#include "core/camera/panorama.h"

namespace waystone {
namespace {

constexpr int kFewestPanoramas = 2;

}  // namespace

size_t TakenPanoramas::StretchOf(int panorama) const {
  size_t s = 0;
  while (panorama >= stretches[s].last) ++s;
  return s;
}

void PanoramaTaker::StartSequence(SequenceId id, const std::string& name) {
  taken_.sequences.push_back(id);
  name_ = name;
}

void PanoramaTaker::Take(DescribedPanorama panorama) {
  if (taken_.signatures.empty()) taken_.band = panorama.band;
  CheckBand(panorama);
  if (!taken_.mirror) taken_.mirror = panorama.mirror;
  TakeFeatures(std::move(panorama.features));
  taken_.signatures.push_back(std::move(panorama.trajectory_signature));
  taken_.frames.push_back(
      {std::move(panorama.info), std::move(panorama.signature), std::move(panorama.picture), {}});
}

void PanoramaTaker::FinishSequence(const FrameReport& sequence) {
  const int first = taken_.stretches.empty() ? 0 : taken_.stretches.back().last;
  if (taken_.size() > first) taken_.frames.back().kept = chooser_.Last();
  taken_.stretches.push_back({first, taken_.size()});
  CheckSequence(sequence);
}

// What is kept of a panorama is known once the next one has come.
void PanoramaTaker::TakeFeatures(BearingFeatures features) {
  const int size = taken_.size();
  if (size % stride_ == 0 && options_.max_samples > 0) {
    taken_.samples.push_back({size, features});
    if (std::ssize(taken_.samples) > options_.max_samples) ThinSamples();
  }
  const bool is_first = taken_.stretches.empty() ? size == 0 : size == taken_.stretches.back().last;
  NodeFeatures before = chooser_.Next(std::move(features));
  if (!is_first) taken_.frames.back().kept = std::move(before);
}

// Keeps every other sample, and takes them half as often from now on.
void PanoramaTaker::ThinSamples() {
  stride_ *= 2;
  std::erase_if(taken_.samples,
                [&](const TakenSample& sample) { return sample.panorama % stride_ != 0; });
}

// Signatures can be compared when their rows are the same elevations.
void PanoramaTaker::CheckBand(const DescribedPanorama& panorama) const {
  if (BandsAgree(panorama.band, taken_.band)) return;
  throw MapError(ErrorCode::kBadSource,
                 name_ + "/" + panorama.info.source +
                     " covers other elevations than the previous panoramas; set --band to a "
                     "range covered by all, or build separate maps");
}

void PanoramaTaker::CheckSequence(const FrameReport& sequence) const {
  const int usable = sequence.frames - sequence.skipped;
  const std::string counts = "'" + name_ + "' has " + std::to_string(usable) +
                             (usable == 1 ? " usable panorama" : " usable panoramas") + " of " +
                             std::to_string(sequence.frames) +
                             (sequence.frames == 1 ? " frame" : " frames");
  const std::string first =
      sequence.skipped == 0 ? "" : " (first: " + sequence.skipped_names.front() + ")";
  if (usable < kFewestPanoramas) {
    throw MapError(ErrorCode::kBadSource,
                   counts + first + "; a sequence requires at least two consecutive ones");
  }
}

}  // namespace waystone
