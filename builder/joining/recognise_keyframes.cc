// SPDX-License-Identifier: Apache-2.0
#include "builder/joining/recognise_keyframes.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <optional>

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

// The answer to a keyframe's image, where that is at hand, else to its picture: smaller, and so
// sometimes nearer to what the map's camera saw. Nothing without either.
std::optional<Answer> AnswerTo(const Keyframe& keyframe, const AskedMap& map, const MapData& other,
                               const std::vector<WalkImage>& images,
                               const FeatureOptions& options) {
  const auto image = std::ranges::find_if(images, [&](const WalkImage& one) {
    return one.sequence == keyframe.sequence && one.frame == keyframe.frame;
  });
  if (image != images.end()) {
    const Answer& answer = map.answers[image - images.begin()];
    if (answer.verdict == Verdict::kLocalized) return answer;
  }
  const std::optional<Features> features = FeaturesOfPicture(keyframe, options);
  if (!features) return std::nullopt;
  return Localize(map, *features, other, keyframe.sequence);
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

std::vector<RecognisedKeyframe> RecogniseKeyframes(const AskedMap& map, const MapData& other,
                                                   const std::vector<WalkImage>& images,
                                                   const FeatureOptions& options) {
  const std::vector<Keyframe>& keyframes = other.keyframes;
  std::vector<std::optional<RecognisedKeyframe>> found(keyframes.size());
  tbb::parallel_for(size_t{0}, keyframes.size(), [&](size_t k) {
    const std::optional<Answer> answer = AnswerTo(keyframes[k], map, other, images, options);
    if (!answer || answer->verdict != Verdict::kLocalized) return;
    const int nearest = map.index->IndexOf(answer->planes.keyframe->id);
    found[k] = RecognisedKeyframe{k, static_cast<size_t>(nearest), answer->pose};
  });
  // Whether a keyframe and the next one were found near the same place.
  const auto agree = [&](size_t k) {
    return k + 1 < keyframes.size() && keyframes[k].sequence == keyframes[k + 1].sequence &&
           found[k] && found[k + 1] &&
           KeyframesAreNear(*map.index, static_cast<int>(found[k]->found),
                            static_cast<int>(found[k + 1]->found));
  };
  std::vector<RecognisedKeyframe> recognised;
  bool with_last = false;
  for (size_t k = 0; k < keyframes.size(); ++k) {
    const bool with_next = agree(k);
    if (with_last || with_next) recognised.push_back(*found[k]);
    with_last = with_next;
  }
  return recognised;
}

}  // namespace waystone
