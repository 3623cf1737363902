// SPDX-License-Identifier: Apache-2.0
#include "builder/joining/recognise_keyframes.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <optional>

#include "builder/calibration/map_parts.h"
#include "builder/calibration/stored_keyframes.h"
#include "localizer/localizer.h"
#include "localizer/planes/sightings.h"
#include "localizer/poses/locate_pose.h"

namespace waystone {
namespace {

// Where a keyframe's picture was taken; nothing where it isn't localized.
std::optional<RecognisedKeyframe> Localize(const MapIndex& index, const MapData& other,
                                           size_t asking, const FeatureOptions& options) {
  const Keyframe& keyframe = other.keyframes[asking];
  const std::optional<Features> features = FeaturesOfPicture(keyframe, options);
  if (!features) return std::nullopt;
  Answer answer = LocalizeFeatures(index, *features, {});
  if (answer.verdict != Verdict::kLocalized) return std::nullopt;
  const int found = index.IndexOf(answer.planes.keyframe->id);
  const auto sequence =
      std::ranges::lower_bound(other.sequences, keyframe.sequence, {}, &Sequence::id);
  AddPose(index, *features, sequence->camera, {}, answer);
  return RecognisedKeyframe{asking, static_cast<size_t>(found), answer.pose};
}

}  // namespace

std::vector<RecognisedKeyframe> RecogniseKeyframes(const MapData& map, const MapData& other,
                                                   const FeatureOptions& options) {
  const auto index = MapIndex::Build(CopyPlanes(map));
  const std::vector<Keyframe>& keyframes = other.keyframes;
  std::vector<std::optional<RecognisedKeyframe>> found(keyframes.size());
  tbb::parallel_for(size_t{0}, keyframes.size(),
                    [&](size_t k) { found[k] = Localize(*index, other, k, options); });
  const auto agree = [&](size_t a, size_t b) {
    return keyframes[a].sequence == keyframes[b].sequence && found[a] && found[b] &&
           KeyframesAreNear(*index, static_cast<int>(found[a]->found),
                            static_cast<int>(found[b]->found));
  };
  std::vector<RecognisedKeyframe> recognised;
  for (size_t k = 0; k < keyframes.size(); ++k) {
    const bool confirmed =
        (k > 0 && agree(k - 1, k)) || (k + 1 < keyframes.size() && agree(k, k + 1));
    if (confirmed) recognised.push_back(*found[k]);
  }
  return recognised;
}

}  // namespace waystone
