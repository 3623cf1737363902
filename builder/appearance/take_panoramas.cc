// SPDX-License-Identifier: Apache-2.0
#include "builder/appearance/take_panoramas.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/error.h"

namespace waystone {
namespace {

constexpr int kMaxNamedSkips = 20;
constexpr int kFewestPanoramas = 2;
constexpr double kBandTolerance_rad = 1e-6;

}  // namespace

size_t TakenPanoramas::StretchOf(int panorama) const {
  size_t s = 0;
  while (panorama >= stretches[s].last) ++s;
  return s;
}

void PanoramaTaker::Add(Source& source) {
  Sequence sequence;
  sequence.id = SequenceId{std::ssize(taken_.sequences) + 1};
  sequence.name = source.name();
  sequence.kind = source.kind();
  sequence.camera = source.camera();
  taken_.sequences.push_back(sequence);
  first_skip_.clear();
  const int first = taken_.size();
  bool stopped = false;
  DescribeFrames(source, options_.describe, [&](DescribedFrame frame) {
    Take(std::move(frame));
    const int done = taken_.sequences.back().frames;
    stopped = progress_ && !progress_("panoramas", done, std::max(done, source.size()));
    return !stopped;
  });
  if (stopped) throw MapError(ErrorCode::kInterrupted, "interrupted; nothing was written");
  if (taken_.size() > first) taken_.frames.back().kept = chooser_.Last();
  taken_.stretches.push_back({first, taken_.size()});
  CheckSequence();
}

void PanoramaTaker::Take(DescribedFrame frame) {
  ++report_.frames;
  ++taken_.sequences.back().frames;
  report_.decode_s += frame.decode_s;
  report_.describe_s += frame.describe_s;
  if (!frame.error.empty()) {
    Skip(frame);
    return;
  }
  if (taken_.signatures.empty()) taken_.band = frame.band;
  CheckBand(frame);
  TakeFeatures(frame);
  taken_.signatures.push_back(std::move(frame.trajectory_signature));
  taken_.frames.push_back(
      {std::move(frame.info), std::move(frame.signature), std::move(frame.jpeg), {}});
}

void PanoramaTaker::Skip(const DescribedFrame& frame) {
  Sequence& sequence = taken_.sequences.back();
  ++report_.skipped;
  ++sequence.skipped;
  const std::string named = frame.info.source + ": " + frame.error;
  if (sequence.skipped == 1) first_skip_ = named;
  if (std::ssize(report_.skipped_names) < kMaxNamedSkips) report_.skipped_names.push_back(named);
}

// What is kept of a panorama is known once the next one has come.
void PanoramaTaker::TakeFeatures(DescribedFrame& frame) {
  const int size = taken_.size();
  if (size % stride_ == 0 && options_.max_samples > 0) {
    taken_.samples.push_back({size, frame.features});
    if (std::ssize(taken_.samples) > options_.max_samples) ThinSamples();
  }
  const bool is_first = taken_.stretches.empty() ? size == 0 : size == taken_.stretches.back().last;
  NodeFeatures before = chooser_.Next(std::move(frame.features));
  if (!is_first) taken_.frames.back().kept = std::move(before);
}

// Every other one, from now on as well.
void PanoramaTaker::ThinSamples() {
  stride_ *= 2;
  std::erase_if(taken_.samples,
                [&](const TakenSample& sample) { return sample.panorama % stride_ != 0; });
}

// Signatures can be compared when their rows are the same elevations.
void PanoramaTaker::CheckBand(const DescribedFrame& frame) const {
  if (std::abs(frame.band.top_rad - taken_.band.top_rad) < kBandTolerance_rad &&
      std::abs(frame.band.bottom_rad - taken_.band.bottom_rad) < kBandTolerance_rad) {
    return;
  }
  throw MapError(ErrorCode::kBadSource,
                 taken_.sequences.back().name + "/" + frame.info.source +
                     " covers other elevations than the previous panoramas; set --band to a "
                     "range covered by all, or build separate maps");
}

void PanoramaTaker::CheckSequence() const {
  const Sequence& sequence = taken_.sequences.back();
  const int usable = sequence.frames - sequence.skipped;
  const std::string counts = "'" + sequence.name + "' has " + std::to_string(usable) +
                             (usable == 1 ? " usable panorama" : " usable panoramas") + " of " +
                             std::to_string(sequence.frames) +
                             (sequence.frames == 1 ? " frame" : " frames");
  const std::string first = first_skip_.empty() ? "" : " (first: " + first_skip_ + ")";
  if (usable < kFewestPanoramas) {
    throw MapError(ErrorCode::kBadSource,
                   counts + first + "; a sequence requires at least two consecutive ones");
  }
  if (sequence.skipped > options_.max_skipped_share * sequence.frames) {
    throw MapError(ErrorCode::kBadSource,
                   counts + first + "; use panoramas of one size with sufficient texture");
  }
}

}  // namespace waystone
