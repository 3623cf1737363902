// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/two_view/bearings.h"
#include "schema/layers/appearance/appearance_layer.h"

namespace waystone {

// Features of a panorama as a map keeps them, and back: rays in units of kBearingUnit_rad,
// descriptors as codes; the camera that saw a feature isn't kept. Thread-safe.
NodeFeatures ToNodeFeatures(const BearingFeatures& features);
BearingFeatures ToBearingFeatures(const NodeFeatures& features, FeatureType type);

}  // namespace waystone
