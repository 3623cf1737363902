// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "bench/accuracy/common.h"

namespace waystone::bench {

// Takes every `--set NAME=VALUE` out of the arguments: build options as for `waystone build`.
// Throws MapError as it does.
BuildOptions TakeBuildSettings(Args& args);

// The options of `waystone build --features TYPE`.
BuildOptions BuildOptionsFor(FeatureType type);

}  // namespace waystone::bench
