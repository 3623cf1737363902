// SPDX-License-Identifier: Apache-2.0
#include "cli/files/kept_plans.h"

#include <cerrno>
#include <cstring>
#include <fstream>
#include <utility>

#include "api/names_file.h"
#include "cli/files/map_file.h"
#include "core/base/error.h"
#include "core/image/encode.h"
#include "schema/file/file_replacer.h"
#include "schema/file/map_store.h"

namespace waystone {
namespace {

namespace fs = std::filesystem;

// ".png" of "image/png".
std::string ExtensionOf(const FloorPlanImage& plan) {
  const std::string type = MediaTypeOf(plan.image);
  return "." + type.substr(type.find('/') + 1);
}

fs::path WriteBeside(const FloorPlanImage& plan, const fs::path& map) {
  const fs::path stem = map.parent_path() / (MapNameOf(map) + ".plan");
  fs::path path = stem.string() + ExtensionOf(plan);
  for (int number = 2; fs::exists(path); ++number) {
    path = stem.string() + "-" + std::to_string(number) + ExtensionOf(plan);
  }
  FileReplacer file(path, false);
  std::ofstream out(file.temporary(), std::ios::binary);
  out.write(reinterpret_cast<const char*>(plan.image.data()),
            static_cast<std::streamsize>(plan.image.size()));
  if (!out.flush()) throw UnwritableError(path, std::strerror(errno), 0);
  file.Commit();
  return path;
}

}  // namespace

std::optional<KeptPlans> PlansOfOldMap(const fs::path& path) {
  if (ReadMap(path, {.images = false}).floor_plans.empty()) return std::nullopt;
  MapData map = ReadMap(path);
  return KeptPlans{AreaFrameJson(map), std::move(map.floor_plans)};
}

std::vector<PlanApart> KeepPlans(const KeptPlans& kept, const fs::path& path, MapData& map) {
  const std::optional<std::string> misfit = FindFrameMisfit(kept.frame, "the floor plans", map);
  std::vector<PlanApart> apart;
  for (const FloorPlanImage& plan : kept.plans) {
    if (misfit) {
      apart.push_back({plan.name, *misfit, WriteBeside(plan, path)});
    } else if (plan.heights && !map.poses) {
      apart.push_back({plan.name, "at heights, and the map has no poses", WriteBeside(plan, path)});
    } else {
      map.floor_plans.push_back(plan);
    }
  }
  return apart;
}

}  // namespace waystone
