// SPDX-License-Identifier: Apache-2.0
#include "bench/accuracy/settings.h"

#include "cli/commands/settings.h"

namespace waystone::bench {

BuildOptions TakeBuildSettings(Args& args) {
  std::vector<std::string> settings;
  for (std::string each; !(each = TakeOption(args, "set", "")).empty();) settings.push_back(each);
  BuildOptions options;
  ApplySettings(settings, options);
  return options;
}

}  // namespace waystone::bench
