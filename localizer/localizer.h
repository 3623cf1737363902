// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "core/features/features.h"
#include "core/image/decode.h"
#include "localizer/index/map_index.h"
#include "localizer/options.h"
#include "localizer/verdict/answer.h"

// The engine for one image; programs use it through localizer/session.h.
namespace waystone {

// Localizes an image from its encoded bytes (JPEG, PNG, ...). Bytes that aren't an image give the
// verdict kBadImage with its cause, not an exception.
// Thread-safe: any number of threads may query the same index. Deterministic except for deadlines.
// Both hold for all functions here.
// `name` is copied into the answer.
Answer Localize(const MapIndex& index, std::span<const uint8_t> bytes, const std::string& name,
                const LocalizeOptions& options);

// The same for several maps, with answers in their order: the image is decoded once, and its
// features are extracted once for each type and size of the working image.
std::vector<Answer> LocalizeAcross(const std::vector<const MapIndex*>& maps,
                                   std::span<const uint8_t> bytes, const std::string& name,
                                   const LocalizeOptions& options);
std::vector<Answer> LocalizeAcross(const std::vector<const MapIndex*>& maps, const cv::Mat& grey,
                                   const std::string& name, const LocalizeOptions& options);

// The same for a decoded image (8-bit grey). An image twice as wide as high, and every image with
// options.series, is answered by the map's appearance layer where it has one (LocalizePanorama,
// LocalizeInSeries), all others by its planes and landmarks; without any, by the appearance layer
// too (LocalizePhoto). An image with the shape of the layer's mirror images may be either: the
// keyframes are queried where the layer doesn't know the place. ...
Answer LocalizeImage(const MapIndex& index, const cv::Mat& grey, const LocalizeOptions& options);

// ... and for features that were extracted already (of the map's type, with QueryFeatureOptions).
// Pixels in the answer are then those of the features instead of the image's.
Answer LocalizeFeatures(const MapIndex& index, const Features& query,
                        const LocalizeOptions& options);

}  // namespace waystone
