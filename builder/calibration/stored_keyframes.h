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

// The features of a keyframe's stored picture, in the pixels of the keyframe, to whose size a
// larger picture is reduced first. Nothing where it has none, or one that can't be decoded.
// Thread-safe.
std::optional<Features> FeaturesOfPicture(const Keyframe& keyframe, const FeatureOptions& options);

// The same of a map's keyframes: at most `max_keyframes`, evenly spread over those that have such a
// picture. Deterministic, on any number of threads.
std::vector<SampledKeyframe> FeaturesOfPictures(const std::vector<Keyframe>& keyframes,
                                                int max_keyframes, const FeatureOptions& options);

// CalibratePlaneLayer with these pictures in place of the images. They are smaller, so places have
// fewer inliers than with a new photo; and they are described anew, so the features that the map
// took from their keyframe aren't left out. A map with too few pictures gets the default model
// (FitVerdictModel).
void RecalibratePlaneLayer(MapData& map, const FeatureOptions& features,
                           const CalibrationOptions& options);

}  // namespace waystone
