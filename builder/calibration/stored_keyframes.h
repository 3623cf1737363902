// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "builder/calibration/plane_calibration.h"
#include "builder/planes/keyframe_sample.h"
#include "core/features/features.h"
#include "schema/map_data.h"

// Calibrating a finished map, whose images are gone.
namespace waystone {

// The features of the pictures that a map keeps of its keyframes, in the pixels of the keyframes:
// at most `max_keyframes`, evenly spread over those that have a picture that can be decoded and
// that isn't larger than its keyframe. Deterministic, on any number of threads.
std::vector<SampledKeyframe> FeaturesOfPictures(const std::vector<Keyframe>& keyframes,
                                                int max_keyframes, const FeatureOptions& options);

// CalibratePlaneLayer by these pictures in place of the images. They are smaller, so that places
// have fewer inliers than a photo of today gives. A map with too few pictures gets the model that
// holds for any map (FitVerdictModel).
void RecalibratePlaneLayer(MapData& map, const FeatureOptions& features,
                           const CalibrationOptions& options);

}  // namespace waystone
