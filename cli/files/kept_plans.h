// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "api/json.h"
#include "schema/map_data.h"

// Floor plans outlive the map that they were given to, as names do (cli/files/kept_names.h).
namespace waystone {

struct KeptPlans {
  Json frame;  // that the anchors are in (AreaFrameJson)
  std::vector<FloorPlanImage> plans;
};

// The floor plans of the map at `path`; nothing where it has none. Throws MapError for a map that
// can't be read.
std::optional<KeptPlans> PlansOfOldMap(const std::filesystem::path& path);

// A plan that wasn't kept.
struct PlanApart {
  std::string name;
  std::string cause;            // "in the frame 'hall', and the map in 'map'"
  std::filesystem::path image;  // where its image is now
};

// Puts the plans into `map` if its positions are in the same frame. If they aren't, the images are
// written beside `path`, where the map goes, under free names, and returned. Throws
// MapError(kFileUnwritable).
std::vector<PlanApart> KeepPlans(const KeptPlans& kept, const std::filesystem::path& path,
                                 MapData& map);

}  // namespace waystone
