// SPDX-License-Identifier: Apache-2.0
#include "bench/accuracy/walk_map.h"

#include <utility>
#include <vector>

namespace waystone::bench {

BuildResult BuildWalk(std::unique_ptr<Source> source, const std::string& name,
                      BuiltFeatures features) {
  std::vector<std::unique_ptr<Source>> sources;
  sources.push_back(std::move(source));
  BuildOptions options;
  options.map_name = name;
  BuildResult built = BuildMap(sources, options, {}, std::nullopt, features);
  built.map.info.version = "sha256:" + name;  // a file's would be its hash
  return built;
}

}  // namespace waystone::bench
