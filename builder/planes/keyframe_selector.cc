// SPDX-License-Identifier: Apache-2.0
#include "builder/planes/keyframe_selector.h"

#include <algorithm>

#include "core/base/error.h"

namespace waystone {

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
  if (!last_) {
    Choose(std::move(frame), true, chosen);
    return;
  }
  ++gap_;
  const int matches_last = CountMatches(frame.features, *last_);
  const bool fulfils = matches_last >= options_.min_matches_last &&
                       (!before_last_ || CountMatches(frame.features, *before_last_) >=
                                             options_.min_matches_before_last);
  if (fulfils) {
    best_ = std::move(frame);
    beyond_.clear();
  } else {
    beyond_.push_back({std::move(frame), matches_last});
  }
  if (gap_ >= options_.max_gap || static_cast<int>(beyond_.size()) > options_.lookahead) {
    Decide(chosen);
  }
}

// Whether the last keyframe or the next one has enough of what a frame shows: N matches, or half of
// what a frame has that shows little.
bool KeyframeSelector::IsShownBy(const Candidate& candidate, const Features& next) const {
  const Features& features = candidate.frame.features;
  const int enough = std::min(options_.min_matches_before_last, features.size() / 2);
  return candidate.matches_last >= enough || CountMatches(features, next) >= enough;
}

// The conditions can't be fulfilled any farther: takes the farthest frame that fulfilled them, else
// the best of the others, else starts a new stretch. No frame before the best is passed over that
// shows what neither it nor the last keyframe does: photos may lie far apart. What comes after is
// looked at again.
void KeyframeSelector::Decide(std::vector<ChosenKeyframe>& chosen) {
  std::deque<Candidate> rest = std::move(beyond_);
  beyond_.clear();
  if (best_) {
    ExtractedFrame frame = std::move(*best_);
    Choose(std::move(frame), false, chosen);
  } else {
    const auto most = std::max_element(rest.begin(), rest.end(), [](const auto& a, const auto& b) {
      return a.matches_last < b.matches_last;
    });
    const auto pick = std::find_if(rest.begin(), most, [&](const Candidate& candidate) {
      return !IsShownBy(candidate, most->frame.features);
    });
    const bool broken = pick->matches_last < options_.min_matches_stretch;
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
