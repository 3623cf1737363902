// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "core/features/features.h"

namespace waystone {

// Features of `count` pictures of a made building that no map shows: textures follow from a seed
// of their own. The same on any number of threads; thread-safe.
std::vector<Features> RenderedNegatives(int count, const FeatureOptions& options);

}  // namespace waystone
