// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "builder/calibration/plane_calibration.h"
#include "builder/planes/keyframe_sample.h"
#include "core/features/features.h"
#include "schema/map_data.h"

// Calibrating a finished map, whose images are gone.
namespace waystone {

// The features of the picture that a map keeps of a keyframe, in the pixels of the keyframe, at
// whose size they are found where the picture is larger. Nothing where it has none, or one that
// can't be decoded.
std::optional<Features> FeaturesOfPicture(const Keyframe& keyframe, const FeatureOptions& options);

// The same of a map's keyframes: at most `max_keyframes`, evenly spread over those that have such a
// picture. Deterministic, on any number of threads.
std::vector<SampledKeyframe> FeaturesOfPictures(const std::vector<Keyframe>& keyframes,
                                                int max_keyframes, const FeatureOptions& options);

// CalibratePlaneLayer by these pictures in place of the images. They are smaller, so that places
// have fewer inliers than a photo of today gives; and they are described anew, so that no feature
// is left out that the map has from their keyframe. A map with too few pictures gets the model that
// holds for any map (FitVerdictModel).
void RecalibratePlaneLayer(MapData& map, const FeatureOptions& features,
                           const CalibrationOptions& options);

}  // namespace waystone
