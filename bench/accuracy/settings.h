// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "bench/accuracy/common.h"

namespace waystone::bench {

// Takes every `--set NAME=VALUE` out of the arguments: the options of a build as `waystone build`
// has them. Throws MapError as that does.
BuildOptions TakeBuildSettings(Args& args);

// Of `waystone build --features TYPE`.
BuildOptions BuildOptionsFor(FeatureType type);

}  // namespace waystone::bench
