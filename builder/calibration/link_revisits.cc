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

// Places that show what an image shows: the best one, if it is sure enough for an answer, and its
// rivals. Keyframes are indices in the map's keyframes.
struct Alike {
  std::vector<int> places;
  std::vector<int> sure;  // those that are sure enough, too
};

// What is found again of an image outside the surroundings of its keyframe.
struct FoundAgain {
  int own = 0;
  std::vector<int> neighbours;  // passed just before or after, and probable
  Alike earlier;
  Alike all;  // later ones, too
};

std::vector<VerifiedKeyframe> VerifyOthers(const MapIndex& index, const Features& image, int own,
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
  return verified;
}

Alike FindAlike(const MapIndex& index, const std::vector<Place>& places,
                const PlaneQueryOptions& options) {
  Alike found;
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

FoundAgain FindAgain(const MapIndex& index, const Features& image, int own,
                     const PlaneQueryOptions& options) {
  std::vector<VerifiedKeyframe> verified = VerifyOthers(index, image, own, options);
  std::vector<Place> places;
  JoinKeyframes(index, image, verified, options, places);
  FoundAgain found;
  found.own = own;
  found.all = FindAlike(index, places, options);
  for (const Place& place : places) {
    const int keyframe = place.keyframe->keyframe;
    if (place.probability >= kProbable && WereTakenInARow(index, own, keyframe)) {
      found.neighbours.push_back(keyframe);
    }
  }
  std::erase_if(verified, [&](const VerifiedKeyframe& one) { return one.keyframe > own; });
  std::vector<Place> earlier;
  JoinKeyframes(index, image, verified, options, earlier);
  found.earlier = FindAlike(index, earlier, options);
  return found;
}

// Links the keyframes of images one after the other, so that each is judged by the links of those
// before it.
class Linker {
 public:
  Linker(const MapIndex& index, const std::vector<FoundAgain>& images)
      : index_(index), images_(images), linked_(index.map().keyframes.size()) {}

  // Links of all images but of those that look like several places.
  std::vector<KeyframeLink> Run() {
    for (size_t i = 0; i < images_.size(); ++i) Link(i);
    std::set<KeyframeId> look_alikes;
    for (const FoundAgain& image : images_) {
      if (!AreOneWithout(image)) look_alikes.insert(index_.map().keyframes[image.own].id);
    }
    std::vector<KeyframeLink> links(links_.begin(), links_.end());
    std::erase_if(links, [&](const KeyframeLink& link) {
      return look_alikes.contains(link.a) || look_alikes.contains(link.b);
    });
    return links;
  }

 private:
  void Link(size_t image) {
    const FoundAgain& found = images_[image];
    for (const int keyframe : found.neighbours) Add(found.own, keyframe);
    if (!AreOne(found.earlier.places)) return;
    for (const int place : found.earlier.sure) {
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

  // Whether the best of the places has no rival left: others are near it, or were passed just
  // before or after.
  bool AreOne(const std::vector<int>& places) const {
    if (places.size() < 2) return true;
    const std::set<int> near = KeyframesNearThird(index_, linked_, places.front());
    return std::ranges::all_of(places, [&](int place) {
      return near.contains(place) || WereTakenInARow(index_, places.front(), place);
    });
  }

  // The same of all places that an image shows, by the links of other keyframes than those near it.
  bool AreOneWithout(const FoundAgain& image) {
    if (image.all.places.size() < 2) return true;
    const std::set<int> near = KeyframesNear(index_, image.own);
    LinkedKeyframes left_out(linked_.size());
    for (const int keyframe : near) std::swap(linked_[keyframe], left_out[keyframe]);
    const bool are_one = AreOne(image.all.places);
    for (const int keyframe : near) std::swap(linked_[keyframe], left_out[keyframe]);
    return are_one;
  }

  // Whether the image before or after it was found near the place, too.
  bool IsConfirmed(size_t image, int place) const {
    const std::set<int> near = KeyframesNear(index_, linked_, place);
    const auto confirms = [&](size_t other) {
      return other < images_.size() &&
             FollowEachOther(index_, images_[image].own, images_[other].own) &&
             std::ranges::any_of(images_[other].earlier.sure,
                                 [&](int found) { return near.contains(found); });
    };
    return confirms(image - 1) || confirms(image + 1);
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
  if (!index->HasLandmarks()) return 0;  // answered by its planes alone
  const auto count = static_cast<int>(images.size());
  std::vector<FoundAgain> found(images.size());
  std::atomic<int> done = 0;
  tbb::parallel_for(0, count, [&](int i) {
    found[i] = FindAgain(*index, images[i].features, index->IndexOf(images[i].keyframe), options);
    progress.Report("links", ++done, count);
  });
  map.links = Linker(*index, found).Run();
  std::set<KeyframeId> linked;
  for (const KeyframeLink& link : map.links) linked.insert({link.a, link.b});
  return static_cast<int>(linked.size());
}

}  // namespace waystone
