// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "core/camera/panorama.h"
#include "localizer/appearance/appearance_match.h"
#include "localizer/index/map_index.h"
#include "localizer/verdict/answer.h"

// Answers about panoramas from a map's appearance layer.
namespace waystone {

// The panorama as the layer describes its own.
// Images of a mirror are unwrapped as the layer's own. Throws MapError(kBadImage) for an image that
// is no panorama or doesn't show the layer's elevations (ToPanorama, UsedBand). The map has an
// appearance layer (WS_CHECK).
PanoramaQuery DescribeQuery(const MapIndex& index, const cv::Mat& grey,
                            const PanoramaQueryOptions& options);

// Whether an image is for the map's appearance layer: a panorama, or, where the layer was made of a
// mirror's images, of their shape.
bool IsForPanoramas(const MapIndex& index, const cv::Size& size);

// Whether such an image may be a photo as well: it has the shape of the mirror's images alone,
// which is that of many cameras, and the map has keyframes to ask.
bool MayBePhoto(const MapIndex& index, const cv::Size& size);

// A mirror's ring in an image that is larger by this factor, as ScaledCamera has points.
MirrorRing ScaledRing(const MirrorRing& ring, double factor);

// Where was this panorama taken? The nearest signatures are ranked again by the phases (eq. 1's
// turn); where the nodes have features, they are verified by relative poses over bearings. The
// place is interpolated among those that agree, or intersected from the directions in which they
// see the query. `left_out` passes over nodes, as for AppearanceIndex::Nearest. Thread-safe,
// deterministic. The map has an appearance layer (WS_CHECK).
Answer LocatePanorama(const MapIndex& index, const PanoramaQuery& query,
                      const PanoramaQueryOptions& options, const std::vector<bool>& left_out = {});

// The answer for nodes that a query was compared with (CompareQuery), best first; for whoever has
// compared already. `verified` says whether features were. No nodes are "not in the map".
Answer JudgeNodes(const MapIndex& index, const FourierSignature& query,
                  std::vector<ComparedNode> nodes, bool verified,
                  const PanoramaQueryOptions& options);

// The same in steps, as LocalizePanorama: the query's features, if any, are only looked at where
// the appearance doesn't settle it.
Answer LocalizeDescribed(const MapIndex& index, const PanoramaQuery& query,
                         const PanoramaQueryOptions& options);

// Both steps, with times and the belief that a series begins with; features are taken only where
// the appearance doesn't settle it. Nothing is thrown for a bad panorama: the verdict is kBadImage.
Answer LocalizePanorama(const MapIndex& index, const cv::Mat& grey,
                        const PanoramaQueryOptions& options);

}  // namespace waystone
