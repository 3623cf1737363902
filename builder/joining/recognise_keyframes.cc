// SPDX-License-Identifier: Apache-2.0
#include "builder/joining/recognise_keyframes.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <map>
#include <optional>
#include <utility>

#include "builder/calibration/map_parts.h"
#include "builder/calibration/stored_keyframes.h"
#include "core/camera/image_plane.h"
#include "localizer/localizer.h"
#include "localizer/planes/surroundings.h"
#include "localizer/poses/locate_pose.h"

namespace waystone {
namespace {

Answer Localize(const AskedMap& map, const Features& features, const MapData& walk,
                SequenceId sequence) {
  Answer answer = LocalizeFeatures(*map.index, features, map.options);
  const auto taken_in = std::ranges::lower_bound(walk.sequences, sequence, {}, &Sequence::id);
  std::optional<Camera> camera = taken_in->camera;
  if (camera) {  // that of the images; pictures are in the pixels of their keyframes
    const cv::Size size = ImageSize(features);
    camera = ScaledCamera(*camera, size.width);
    camera->height = size.height;  // may be rounded otherwise
  }
  AddPose(*map.index, features, camera, map.options.pose, answer);
  return answer;
}

using ImageNumbers = std::map<std::pair<SequenceId, int>, size_t>;  // by sequence and frame

ImageNumbers NumberImages(const std::vector<WalkImage>& images) {
  ImageNumbers numbers;
  for (size_t i = 0; i < images.size(); ++i) {
    numbers.emplace(std::pair(images[i].sequence, images[i].frame), i);
  }
  return numbers;
}

// The map's answer to a keyframe's image, where that is at hand and was localized.
const Answer* AnswerToImage(const Keyframe& keyframe, const AskedMap& map,
                            const ImageNumbers& images) {
  const auto image = images.find({keyframe.sequence, keyframe.frame});
  if (image == images.end()) return nullptr;
  const Answer& answer = map.answers[image->second];
  return answer.verdict == Verdict::kLocalized ? &answer : nullptr;
}

using Found = std::vector<std::optional<RecognisedKeyframe>>;  // by the asking keyframes

// Only those whose neighbour was found near the same place, or just before or after it.
std::vector<RecognisedKeyframe> Supported(const MapIndex& index,
                                          const std::vector<Keyframe>& keyframes,
                                          const Found& found) {
  // Whether a keyframe and the next one were found near the same place.
  const auto agree = [&](size_t k) {
    if (k + 1 >= keyframes.size() || keyframes[k].sequence != keyframes[k + 1].sequence ||
        !found[k] || !found[k + 1]) {
      return false;
    }
    const auto one = static_cast<int>(found[k]->found);
    const auto next = static_cast<int>(found[k + 1]->found);
    return WereTakenInARow(index, one, next) || KeyframesAreNear(index, one, next);
  };
  std::vector<RecognisedKeyframe> supported;
  bool with_last = false;
  for (size_t k = 0; k < keyframes.size(); ++k) {
    const bool with_next = agree(k);
    if (with_last || with_next) supported.push_back(*found[k]);
    with_last = with_next;
  }
  return supported;
}

}  // namespace

AskedMap AskMap(const MapData& map, const MapData& walk, const std::vector<WalkImage>& images,
                const LocalizeOptions& options) {
  AskedMap asked{MapIndex::Build(CopyPlanes(map)), options, std::vector<Answer>(images.size())};
  if (map.keyframes.empty()) return asked;
  tbb::parallel_for(size_t{0}, images.size(), [&](size_t i) {
    asked.answers[i] = Localize(asked, images[i].features, walk, images[i].sequence);
  });
  return asked;
}

std::vector<std::vector<RecognisedKeyframe>> RecogniseKeyframes(
    const std::vector<const AskedMap*>& maps, const MapData& other,
    const std::vector<WalkImage>& images, const FeatureOptions& options) {
  const std::vector<Keyframe>& keyframes = other.keyframes;
  const ImageNumbers numbers = NumberImages(images);
  std::vector<Found> found(maps.size(), Found(keyframes.size()));
  tbb::parallel_for(size_t{0}, keyframes.size(), [&](size_t k) {
    // Features of the stored picture, which is smaller than the image and so sometimes matches a
    // map's camera better.
    std::optional<Features> features;
    bool described = false;
    for (size_t m = 0; m < maps.size(); ++m) {
      const AskedMap& map = *maps[m];
      const Answer* to_image = AnswerToImage(keyframes[k], map, numbers);
      if (!to_image && !described) {
        features = FeaturesOfPicture(keyframes[k], options);
        described = true;
      }
      if (!to_image && !features) continue;
      const Answer answer =
          to_image ? *to_image : Localize(map, *features, other, keyframes[k].sequence);
      if (answer.verdict != Verdict::kLocalized) continue;
      const int nearest = map.index->IndexOf(answer.planes.keyframe->id);
      found[m][k] = RecognisedKeyframe{k, static_cast<size_t>(nearest), answer.pose};
    }
  });
  std::vector<std::vector<RecognisedKeyframe>> recognised;
  for (size_t m = 0; m < maps.size(); ++m) {
    recognised.push_back(Supported(*maps[m]->index, keyframes, found[m]));
  }
  return recognised;
}

}  // namespace waystone
