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

// More likely than not: enough of a place that was passed just before or after, which most images
// show again.
constexpr double kProbable = 0.5;

// An image's own keyframe, and places outside its surroundings that show what it shows: the best
// one and those that look as well. Keyframes are indices in the map's keyframes.
struct FoundAgain {
  int own = 0;
  std::vector<int> places;
  std::vector<int> sure;      // probable enough for a link; also others passed just before or after
  std::set<int> near;         // own, where there are places
  std::set<int> near_places;  // any of them
};

FoundAgain FindAgain(const MapIndex& index, const Features& image, int own,
                     const PlaneQueryOptions& options) {
  PlaneQueryOptions all = options;  // the image's own surroundings get most votes
  all.max_keyframes = static_cast<int>(index.map().keyframes.size());
  const std::set<int> surroundings = KeyframesNearThird(index, own);
  std::vector<VerifiedKeyframe> verified;
  int asked = 0;
  for (const ShortlistedKeyframe& candidate : VoteForPlaces(index, image, all).keyframes) {
    if (asked == options.max_keyframes) break;
    if (surroundings.contains(candidate.keyframe)) continue;
    ++asked;
    if (auto one = VerifyKeyframe(index, image, candidate.keyframe, options)) {
      verified.push_back(std::move(*one));
    }
  }
  std::ranges::stable_sort(verified, std::greater<>(), &VerifiedKeyframe::distinct);
  std::vector<Place> places;
  JoinKeyframes(index, image, verified, options, places);
  FoundAgain found;
  found.own = own;
  for (const Place& place : places) {
    const int keyframe = place.keyframe->keyframe;
    if (place.probability >= kProbable && WereTakenInARow(index, own, keyframe)) {
      found.sure.push_back(keyframe);
    }
  }
  if (places.empty() || places.front().probability < options.gates.min_probability) return found;
  std::vector<const Place*> alike = FindRivals(index, places, options);
  alike.insert(alike.begin(), &places.front());
  for (const Place* place : alike) {
    found.places.push_back(place->keyframe->keyframe);
    found.near_places.merge(KeyframesNear(index, place->keyframe->keyframe));
    if (place->probability >= options.gates.min_probability) {
      found.sure.push_back(place->keyframe->keyframe);
    }
  }
  found.near = KeyframesNear(index, own);
  return found;
}

// Tells places that are one from those that look alike: any two that are were passed one after the
// other, or an image near the one was found near the other.
class Places {
 public:
  Places(const MapIndex& index, const std::vector<FoundAgain>& images)
      : index_(index), near_(index.map().keyframes.size()) {
    for (const FoundAgain& image : images) {
      for (const int keyframe : image.near) near_[keyframe].push_back(&image);
    }
  }

  bool AreOne(const std::vector<int>& places) const {
    for (size_t i = 0; i < places.size(); ++i) {
      for (size_t k = 0; k < i; ++k) {
        if (!WereTakenInARow(index_, places[i], places[k]) && !Found(places[i], places[k]) &&
            !Found(places[k], places[i])) {
          return false;
        }
      }
    }
    return true;
  }

 private:
  bool Found(int from, int place) const {
    return std::ranges::any_of(
        near_[from], [&](const FoundAgain* image) { return image->near_places.contains(place); });
  }

  const MapIndex& index_;
  std::vector<std::vector<const FoundAgain*>> near_;  // images near each keyframe
};

// The keyframes near images that look like several places which aren't one.
std::set<int> FindLookAlikes(const MapIndex& index, const std::vector<FoundAgain>& images) {
  const Places places(index, images);
  std::set<int> look_alikes;
  for (const FoundAgain& image : images) {
    if (!places.AreOne(image.places)) look_alikes.insert(image.near.begin(), image.near.end());
  }
  return look_alikes;
}

// Whether the place is one that was passed just before or after, or the image before or after was
// found near it, too.
bool IsConfirmed(const MapIndex& index, const std::vector<FoundAgain>& images, int image,
                 int place) {
  const auto confirms = [&](int other) {
    return other >= 0 && other < std::ssize(images) &&
           FollowEachOther(index, images[image].own, images[other].own) &&
           std::ranges::any_of(images[other].sure,
                               [&](int found) { return KeyframesAreNear(index, found, place); });
  };
  return WereTakenInARow(index, images[image].own, place) || confirms(image - 1) ||
         confirms(image + 1);
}

}  // namespace

int LinkRevisits(const std::vector<SampledKeyframe>& images, const PlaneQueryOptions& options,
                 MapData& map, ProgressReporter& progress) {
  const auto index = MapIndex::Build(CopyPlanes(map));
  if (!index->HasLandmarks()) return 0;  // answered by its planes alone
  const auto count = static_cast<int>(images.size());
  std::vector<FoundAgain> found(images.size());
  std::atomic<int> done = 0;
  tbb::parallel_for(0, count, [&](int i) {
    found[i] = FindAgain(*index, images[i].features, index->IndexOf(images[i].keyframe), options);
    progress.Report("links", ++done, count);
  });
  const std::set<int> look_alikes = FindLookAlikes(*index, found);
  std::set<KeyframeLink> links;
  std::set<KeyframeId> linked;
  for (int i = 0; i < count; ++i) {
    if (look_alikes.contains(found[i].own)) continue;
    for (const int place : found[i].sure) {
      if (look_alikes.contains(place) || !IsConfirmed(*index, found, i, place)) continue;
      const auto [a, b] = std::minmax(images[i].keyframe, map.keyframes[place].id);
      links.insert({a, b});
      linked.insert({a, b});
    }
  }
  map.links.assign(links.begin(), links.end());
  return static_cast<int>(linked.size());
}

}  // namespace waystone
