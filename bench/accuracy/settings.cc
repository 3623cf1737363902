// SPDX-License-Identifier: Apache-2.0
#include "bench/accuracy/settings.h"

#include "cli/commands/build_flags.h"

namespace waystone::bench {

BuildOptions TakeBuildSettings(Args& args) {
  BuildFlags flags;
  for (std::string each; !(each = TakeOption(args, "set", "")).empty();) {
    flags.settings.push_back(each);
  }
  return MakeBuildOptions(flags, BuildOptions{}.map_name);
}

BuildOptions BuildOptionsFor(FeatureType type) {
  BuildFlags flags;
  flags.features = std::string(NameOf(type));
  return MakeBuildOptions(flags, BuildOptions{}.map_name);
}

}  // namespace waystone::bench
