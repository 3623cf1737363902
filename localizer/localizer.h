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

// The engine for one image; programs ask through localizer/session.h.
namespace waystone {

// Where was this image taken? Encoded bytes (JPEG, PNG, ...) in, an answer out. Bytes that are no
// image give the verdict kBadImage with its cause, not an exception.
// Thread-safe and deterministic: any number of threads may ask the same index.
// `name` is copied into the answer.
Answer Localize(const MapIndex& index, std::span<const uint8_t> bytes, const std::string& name,
                const LocalizeOptions& options);

// The same asked of several maps, whose answers come in their order: the image is decoded once, and
// its features are extracted once for each type and size of the working image.
std::vector<Answer> LocalizeAcross(const std::vector<const MapIndex*>& maps,
                                   std::span<const uint8_t> bytes, const std::string& name,
                                   const LocalizeOptions& options);
std::vector<Answer> LocalizeAcross(const std::vector<const MapIndex*>& maps, const cv::Mat& grey,
                                   const std::string& name, const LocalizeOptions& options);

// The same for an image that is decoded already (8-bit grey). An image twice as wide as high, and
// every image with options.series, is answered by the map's appearance layer where it has one
// (LocalizePanorama, LocalizeInSeries), all others by its planes and landmarks; without any, by the
// appearance layer too (LocalizePhoto). An image of the shape of the layer's mirror may be either:
// the keyframes are asked where the layer doesn't know the place. ...
Answer LocalizeImage(const MapIndex& index, const cv::Mat& grey, const LocalizeOptions& options);

// ... and for features that were extracted already (of the map's type, as QueryFeatureOptions has
// it). Pixels of the query are then those of the features, where the others have the image's.
Answer LocalizeFeatures(const MapIndex& index, const Features& query,
                        const LocalizeOptions& options);

}  // namespace waystone
