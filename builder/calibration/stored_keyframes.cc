// SPDX-License-Identifier: Apache-2.0
#include "builder/calibration/stored_keyframes.h"

#include <tbb/parallel_for.h>

#include <cstddef>
#include <optional>
#include <utility>

#include "builder/frames/shrink.h"
#include "core/base/error.h"
#include "core/image/decode.h"

namespace waystone {
namespace {

// Keyframes to decode, evenly spread: those that KeyframeSample would choose, before they have
// features.
std::vector<const Keyframe*> ChoosePictures(const std::vector<Keyframe>& keyframes,
                                            int max_keyframes) {
  std::vector<const Keyframe*> with_picture;
  KeyframeSample sample(max_keyframes);
  for (const Keyframe& keyframe : keyframes) {
    if (keyframe.picture.empty()) continue;
    // Ids stand for positions in the list.
    with_picture.push_back(&keyframe);
    sample.Add(KeyframeId{std::ssize(with_picture)}, {});
  }
  std::vector<const Keyframe*> chosen;
  for (const SampledKeyframe& one : sample.keyframes()) {
    chosen.push_back(with_picture[static_cast<size_t>(one.keyframe.value - 1)]);
  }
  return chosen;
}

}  // namespace

std::optional<Features> FeaturesOfPicture(const Keyframe& keyframe, const FeatureOptions& options) {
  if (keyframe.picture.empty()) return std::nullopt;
  cv::Mat picture;
  try {
    picture = ShrinkToWidth(DecodeGrey(keyframe.picture), keyframe.width);
  } catch (const MapError&) {
    return std::nullopt;
  }
  Features features = ExtractFeatures(picture, options);
  const float scale = static_cast<float>(keyframe.width) / static_cast<float>(picture.cols);
  for (Keypoint& keypoint : features.keypoints) {
    keypoint.x_px = scale * (keypoint.x_px + 0.5f) - 0.5f;
    keypoint.y_px = scale * (keypoint.y_px + 0.5f) - 0.5f;
    keypoint.scale_px *= scale;
  }
  features.width = features.image_width = keyframe.width;
  features.height = features.image_height = keyframe.height;
  return features;
}

std::vector<SampledKeyframe> FeaturesOfPictures(const std::vector<Keyframe>& keyframes,
                                                int max_keyframes, const FeatureOptions& options) {
  const std::vector<const Keyframe*> chosen = ChoosePictures(keyframes, max_keyframes);
  std::vector<std::optional<Features>> features(chosen.size());
  tbb::parallel_for(size_t{0}, chosen.size(),
                    [&](size_t i) { features[i] = FeaturesOfPicture(*chosen[i], options); });
  std::vector<SampledKeyframe> samples;
  for (size_t i = 0; i < chosen.size(); ++i) {
    if (features[i]) samples.push_back({chosen[i]->id, std::move(*features[i])});
  }
  return samples;
}

void RecalibratePlaneLayer(MapData& map, const FeatureOptions& features,
                           const CalibrationOptions& options) {
  CalibratePlaneLayer(map, FeaturesOfPictures(map.keyframes, options.max_keyframes, features),
                      features, options);
}

}  // namespace waystone
