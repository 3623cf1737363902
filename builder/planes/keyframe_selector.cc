// SPDX-License-Identifier: Apache-2.0
#include "builder/planes/keyframe_selector.h"

#include <algorithm>

#include "core/base/error.h"

namespace waystone {
namespace {

// The largest share of a keyframe's features that must match, so that a camera in front of a bare
// wall, or one that sees little, doesn't get more keyframes than others.
constexpr double kLastShare = 0.6;
constexpr double kBeforeLastShare = 0.3;
constexpr double kStretchShare = 0.3;

// Whether it has the eight features that an epipolar geometry needs.
bool CanBeRecognised(const Features& frame) { return frame.size() >= 8; }

int AtMostShare(int matches, double share, const Features& keyframe) {
  return std::min(matches, static_cast<int>(share * keyframe.size()));
}

}  // namespace

void KeyframeOptions::Check() const {
  CheckFields("keyframes", *this);
  if (min_matches_before_last >= min_matches_stretch && min_matches_last >= min_matches_before_last)
    return;
  throw MapError(ErrorCode::kBadOptions,
                 "keyframes.min_matches_last must be at least keyframes.min_matches_before_last, "
                 "and that at least keyframes.min_matches_stretch");
}

KeyframeSelector::KeyframeSelector(const KeyframeOptions& options, const MatchOptions& match)
    : options_(options), match_(match) {
  options_.Check();
}

std::vector<ChosenKeyframe> KeyframeSelector::Add(ExtractedFrame frame) {
  std::vector<ChosenKeyframe> chosen;
  Consider(std::move(frame), chosen);
  return chosen;
}

std::vector<ChosenKeyframe> KeyframeSelector::Finish() {
  std::vector<ChosenKeyframe> chosen;
  while (best_ || !beyond_.empty()) Decide(chosen);
  return chosen;
}

int KeyframeSelector::CountMatches(const Features& a, const Features& b) const {
  return static_cast<int>(MatchDescriptors(a.descriptors, b.descriptors, a.type, match_).size());
}

void KeyframeSelector::Consider(ExtractedFrame frame, std::vector<ChosenKeyframe>& chosen) {
  ++gap_;
  if (!last_) {
    if (CanBeRecognised(frame.features)) Choose(std::move(frame), true, chosen);
    return;
  }
  const int matches_last = CountMatches(frame.features, *last_);
  if (FulfilsConditions(frame.features, matches_last)) {
    best_ = std::move(frame);
    beyond_.clear();
  } else {
    beyond_.push_back({std::move(frame), matches_last});
  }
  if (gap_ >= options_.max_gap || static_cast<int>(beyond_.size()) > options_.lookahead) {
    Decide(chosen);
  }
}

// Whether it shares M features with the last keyframe and N with the one before.
bool KeyframeSelector::FulfilsConditions(const Features& frame, int matches_last) const {
  if (!CanBeRecognised(frame)) return false;
  if (matches_last < AtMostShare(options_.min_matches_last, kLastShare, *last_)) return false;
  return !before_last_ ||
         CountMatches(frame, *before_last_) >=
             AtMostShare(options_.min_matches_before_last, kBeforeLastShare, *before_last_);
}

// Whether the last keyframe or the next one shows enough of a frame: N matches, or half of the
// features of a frame that has few.
bool KeyframeSelector::IsShownBy(const Candidate& candidate, const Features& next) const {
  const Features& features = candidate.frame.features;
  const int enough = std::min(options_.min_matches_before_last, features.size() / 2);
  return candidate.matches_last >= enough || CountMatches(features, next) >= enough;
}

// No later frame can fulfil the conditions: takes the farthest frame that fulfilled them, else the
// best of the others, else starts a new stretch. A frame before the best one isn't skipped if it
// shows what neither the best one nor the last keyframe does: photos may be far apart. Later frames
// are considered again.
void KeyframeSelector::Decide(std::vector<ChosenKeyframe>& chosen) {
  std::deque<Candidate> rest = std::move(beyond_);
  beyond_.clear();
  if (best_) {
    ExtractedFrame frame = std::move(*best_);
    Choose(std::move(frame), false, chosen);
  } else {
    std::erase_if(rest, [](const auto& one) { return !CanBeRecognised(one.frame.features); });
    if (rest.empty()) return;
    const auto most = std::max_element(rest.begin(), rest.end(), [](const auto& a, const auto& b) {
      return a.matches_last < b.matches_last;
    });
    const auto pick = std::find_if(rest.begin(), most, [&](const Candidate& candidate) {
      return !IsShownBy(candidate, most->frame.features);
    });
    const bool broken =
        pick->matches_last < AtMostShare(options_.min_matches_stretch, kStretchShare, *last_);
    ExtractedFrame frame = std::move(pick->frame);
    rest.erase(rest.begin(), pick + 1);
    Choose(std::move(frame), broken, chosen);
  }
  for (Candidate& candidate : rest) Consider(std::move(candidate.frame), chosen);
}

void KeyframeSelector::Choose(ExtractedFrame frame, bool starts_stretch,
                              std::vector<ChosenKeyframe>& chosen) {
  before_last_ = starts_stretch ? std::nullopt : std::move(last_);
  last_ = frame.features;
  best_.reset();
  gap_ = 0;
  chosen.push_back({std::move(frame), starts_stretch});
}

}  // namespace waystone
