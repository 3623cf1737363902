// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "core/camera/panorama.h"
#include "localizer/appearance/appearance_match.h"
#include "localizer/index/map_index.h"
#include "localizer/verdict/answer.h"

// Answers about panoramas from a map's appearance layer. All functions are thread-safe.
namespace waystone {

// Describes the panorama as the layer's own are described; a mirror's images are unwrapped like the
// layer's. Throws MapError(kBadImage) for an image that isn't a panorama or doesn't show the
// layer's elevations (ToPanorama, UsedBand). The map has an appearance layer (WS_CHECK).
PanoramaQuery DescribeQuery(const MapIndex& index, const cv::Mat& grey,
                            const PanoramaQueryOptions& options);

// Whether an image is for the map's appearance layer: a panorama, or, where the layer was made from
// a mirror's images, an image of their shape.
bool IsForPanoramas(const MapIndex& index, const cv::Size& size);

// Whether such an image may also be a photo: it only has the shape of the mirror's images, which
// many cameras share, and the map has keyframes to query.
bool MayBePhoto(const MapIndex& index, const cv::Size& size);

// A mirror's ring in an image that is larger by this factor; points scale as in ScaledCamera.
MirrorRing ScaledRing(const MirrorRing& ring, double factor);

// Where was this panorama taken? The nearest signatures are ranked again by the phases (eq. 1's
// turn); where the nodes have features, they are verified by relative poses over bearings. The
// place is interpolated among those that agree, or intersected from the directions in which they
// see the query. `left_out` excludes nodes, as for AppearanceIndex::Nearest. Deterministic. The map
// has an appearance layer (WS_CHECK).
Answer LocatePanorama(const MapIndex& index, const PanoramaQuery& query,
                      const PanoramaQueryOptions& options, const std::vector<bool>& left_out = {});

// The answer for nodes that a query has already been compared with (CompareQuery), best first.
// `verified` says whether features were compared. Without nodes the answer is "not in the map".
Answer JudgeNodes(const MapIndex& index, const FourierSignature& query,
                  std::vector<ComparedNode> nodes, bool verified,
                  const PanoramaQueryOptions& options);

// LocatePanorama in steps, as LocalizePanorama: the query's features, if any, are only used where
// the appearance doesn't settle the place.
Answer LocalizeDescribed(const MapIndex& index, const PanoramaQuery& query,
                         const PanoramaQueryOptions& options);

// DescribeQuery and LocalizeDescribed, with times and the belief that a series begins with;
// features are extracted only where the appearance doesn't settle the place. Nothing is thrown for
// a bad panorama: the verdict is kBadImage.
Answer LocalizePanorama(const MapIndex& index, const cv::Mat& grey,
                        const PanoramaQueryOptions& options);

}  // namespace waystone
