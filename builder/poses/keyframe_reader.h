// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "builder/frames/progress.h"
#include "builder/planes/keyframe_sample.h"
#include "builder/sources/source.h"
#include "schema/map_data.h"

namespace waystone {

// Features per image for a reconstruction: with the 1,000 of a query, COLMAP left the keyframes of
// `waystone demo --write` in three models; with these they are one.
inline constexpr int kReconstructionFeatures = 4000;

// The features of a map's keyframes, extracted anew from the sources that the map was built from:
// one for each of map.sequences, in their order, opened without options that leave frames out. In
// the order of map.keyframes; deterministic on any number of threads. Throws MapError: kBadSource
// for sources that aren't the map's (their number, a keyframe's name or its shape differs, or its
// size from the sequence's camera) or can't be read; kInterrupted. `options` may take more pixels
// than the map's images have, for triangulation.
std::vector<SampledKeyframe> ReadKeyframes(const MapData& map,
                                           std::span<const std::unique_ptr<Source>> sources,
                                           const FeatureOptions& options,
                                           const ProgressCallback& progress = {});

}  // namespace waystone
