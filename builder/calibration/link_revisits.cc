// SPDX-License-Identifier: Apache-2.0
#include "builder/calibration/link_revisits.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <functional>
#include <set>

#include "builder/calibration/map_parts.h"
#include "localizer/planes/decide.h"
#include "localizer/planes/shortlist.h"
#include "localizer/planes/sightings.h"
#include "localizer/planes/surroundings.h"

namespace waystone {
namespace {

// More likely than not: enough for a place that was passed just before or after, which most images
// show again.
constexpr double kProbable = 0.5;

// What an image shows of earlier places, and of neighbours: places passed just before or after it,
// in another stretch. Keyframes are indices in the map's keyframes.
struct FoundAgain {
  int own = 0;
  std::vector<int> neighbours;  // more likely than not
  std::vector<int> places;      // the best one, if it is sure enough for an answer, and its rivals
  std::vector<int> sure;        // of the places: sure enough, too
};

std::vector<VerifiedKeyframe> VerifyEarlier(const MapIndex& index, const Features& image, int own,
                                            const PlaneQueryOptions& options) {
  PlaneQueryOptions all = options;  // the image's own surroundings get most votes
  all.max_keyframes = static_cast<int>(index.map().keyframes.size());
  std::set<int> known = KeyframesNearThird(index, own);  // and what is near those verified
  std::vector<VerifiedKeyframe> verified;
  int asked = 0;
  for (const ShortlistedKeyframe& candidate : VoteForPlaces(index, image, all).keyframes) {
    if (asked == options.max_keyframes) break;
    if (known.contains(candidate.keyframe)) continue;
    if (candidate.keyframe > own && !WereTakenInARow(index, own, candidate.keyframe)) continue;
    ++asked;
    VerifiedKeyframe one = VerifyKeyframe(index, image, candidate.keyframe, options);
    if (one.distinct > 0) {
      verified.push_back(std::move(one));
      known.merge(KeyframesNear(index, candidate.keyframe));
    }
  }
  std::ranges::stable_sort(verified, std::greater<>(), &VerifiedKeyframe::distinct);
  return verified;
}

FoundAgain FindAgain(const MapIndex& index, const Features& image, int own,
                     const PlaneQueryOptions& options) {
  std::vector<Place> places;
  JoinKeyframes(index, image, VerifyEarlier(index, image, own, options), options, places);
  FoundAgain found;
  found.own = own;
  for (const Place& place : places) {
    const int keyframe = place.keyframe->keyframe;
    if (place.probability >= kProbable && WereTakenInARow(index, own, keyframe)) {
      found.neighbours.push_back(keyframe);
    }
  }
  if (places.empty() || places.front().probability < options.gates.min_probability) return found;
  std::vector<const Place*> alike = FindRivals(index, places, options);
  alike.insert(alike.begin(), &places.front());
  for (const Place* place : alike) {
    found.places.push_back(place->keyframe->keyframe);
    if (place->probability >= options.gates.min_probability) {
      found.sure.push_back(place->keyframe->keyframe);
    }
  }
  return found;
}

// Links the keyframes of images one after the other, so that each is judged by the links of those
// before it.
class Linker {
 public:
  Linker(const MapIndex& index, const std::vector<FoundAgain>& images)
      : index_(index), images_(images), linked_(index.map().keyframes.size()) {
    for (size_t i = 0; i < images_.size(); ++i) Link(i);
  }

  const std::set<KeyframeLink>& links() const { return links_; }

 private:
  void Link(size_t image) {
    const FoundAgain& found = images_[image];
    for (const int keyframe : found.neighbours) Add(found.own, keyframe);
    if (!AreOne(found.places)) return;
    for (const int place : found.sure) {
      if (IsConfirmed(image, place)) Add(found.own, place);
    }
  }

  void Add(int own, int keyframe) {
    const std::vector<Keyframe>& keyframes = index_.map().keyframes;
    const auto [a, b] = std::minmax(keyframes[own].id, keyframes[keyframe].id);
    if (!links_.insert({a, b}).second) return;
    linked_[own].push_back(keyframe);
    linked_[keyframe].push_back(own);
  }

  // Whether the best of the places has no rival left.
  bool AreOne(const std::vector<int>& places) const {
    if (places.size() < 2) return true;
    const std::set<int> near = KeyframesNearThird(index_, linked_, places.front());
    return std::ranges::all_of(places, [&](int place) { return near.contains(place); });
  }

  // Whether the image before or after it was also found near the place, or just before or after it.
  bool IsConfirmed(size_t image, int place) const {
    const std::set<int> near = KeyframesNear(index_, linked_, place);
    const auto confirms = [&](size_t other) {
      return other < images_.size() &&
             WereTakenInARow(index_, images_[image].own, images_[other].own) &&
             std::ranges::any_of(images_[other].sure, [&](int found) {
               return near.contains(found) || WereTakenInARow(index_, place, found);
             });
    };
    return (image > 0 && confirms(image - 1)) || confirms(image + 1);
  }

  const MapIndex& index_;
  const std::vector<FoundAgain>& images_;
  std::set<KeyframeLink> links_;
  LinkedKeyframes linked_;
};

}  // namespace

int LinkRevisits(const std::vector<SampledKeyframe>& images, const PlaneQueryOptions& options,
                 MapData& map, ProgressReporter& progress) {
  const auto index = MapIndex::Build(CopyPlanes(map));
  if (!index->HasLandmarks()) return 0;  // answered only by its planes
  const auto count = static_cast<int>(images.size());
  std::vector<FoundAgain> found(images.size());
  std::atomic<int> done = 0;
  tbb::parallel_for(0, count, [&](int i) {
    found[i] = FindAgain(*index, images[i].features, index->IndexOf(images[i].keyframe), options);
    progress.Report("links", ++done, count);
  });
  const Linker linker(*index, found);
  map.links.assign(linker.links().begin(), linker.links().end());
  std::set<KeyframeId> linked;
  for (const KeyframeLink& link : map.links) linked.insert({link.a, link.b});
  return static_cast<int>(linked.size());
}

}  // namespace waystone
