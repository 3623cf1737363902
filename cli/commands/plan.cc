// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <iostream>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "api/floor_plans_json.h"
#include "api/query_request_json.h"
#include "cli/commands/commands.h"
#include "cli/files/map_file.h"
#include "core/base/error.h"
#include "core/base/text.h"
#include "core/image/decode.h"
#include "core/image/exif.h"
#include "schema/file/map_lock.h"
#include "schema/file/map_store.h"
#include "schema/layers/poses/horizontal.h"

namespace waystone {
namespace {

constexpr const char* kDefaultName = "Floor plan";
constexpr const char* kAnchorForm = "give it as 120,340=2.5,-1 or 120,340=keyframe:12";

struct PlanFlags {
  std::string map;
  std::string image;
  std::vector<std::string> anchors;
  std::string name;
  std::string heights;
  std::string remove;
  bool json = false;
};

[[noreturn]] void RefuseFlag(const std::string& cause) { throw MapError(ErrorCode::kUsage, cause); }

// "120,340".
std::optional<Eigen::Vector2d> ReadPoint(const std::string& text) {
  const size_t comma = text.find(',');
  if (comma == std::string::npos) return std::nullopt;
  const auto x = ToNumber(text.substr(0, comma)), y = ToNumber(text.substr(comma + 1));
  if (!x || !y) return std::nullopt;
  return Eigen::Vector2d(*x, *y);
}

Eigen::Vector2d PositionOfKeyframe(const MapData& map, int64_t id) {
  const KeyframePose* pose = map.poses ? map.poses->Find(KeyframeId{id}) : nullptr;
  if (pose) return HorizontalOf(*map.poses).Of(pose->position);
  throw MapError(ErrorCode::kNotFound, "--anchor: the map has no keyframe " + std::to_string(id) +
                                           " with a pose; choose another one, or give x and y");
}

Eigen::Vector2d PositionOfNode(const MapData& map, int64_t id) {
  if (map.poses && map.poses->nodes.empty()) {
    RefuseFlag("--anchor: panoramas are not in the frame of the map's poses; give keyframe:ID");
  }
  if (map.poses) {
    const NodePose* pose = map.poses->Find(AppearanceNodeId{id});
    if (pose) return HorizontalOf(*map.poses).Of(pose->position);
    throw MapError(ErrorCode::kNotFound,
                   "--anchor: the map has no panorama " + std::to_string(id) +
                       " with a pose; choose another one, give keyframe:ID, or x and y");
  }
  const std::vector<AppearanceNode>& nodes = map.appearance->nodes;
  const auto found = std::ranges::find(nodes, AppearanceNodeId{id}, &AppearanceNode::id);
  if (found != nodes.end()) return {found->pose.x, found->pose.y};
  throw MapError(ErrorCode::kNotFound, "--anchor: the map has no panorama " + std::to_string(id) +
                                           "; choose another one, or give x and y");
}

// The position right of the equals sign: "2.5,-1", "keyframe:12" or "node:3".
Eigen::Vector2d ReadPosition(const MapData& map, const std::string& anchor,
                             const std::string& text) {
  if (const auto point = ReadPoint(text)) return *point;
  const size_t colon = text.find(':');
  const std::string kind = text.substr(0, colon);
  const auto id = colon == std::string::npos ? std::nullopt : ToInteger(text.substr(colon + 1));
  if (id && kind == "keyframe") return PositionOfKeyframe(map, *id);
  if (id && kind == "node") return PositionOfNode(map, *id);
  RefuseFlag("--anchor " + QuoteShortened(anchor) + " has no position in the map; " + kAnchorForm);
}

PlanAnchor ReadAnchor(const MapData& map, const std::string& text) {
  const size_t equals = text.find('=');
  const auto px = ReadPoint(text.substr(0, equals));
  if (equals == std::string::npos || !px) {
    RefuseFlag("--anchor " + QuoteShortened(text) + " is not an anchor; " + kAnchorForm);
  }
  return {*px, ReadPosition(map, text, text.substr(equals + 1))};
}

std::optional<PlanHeights> ReadHeights(const MapData& map, const std::string& text) {
  if (text.empty()) return std::nullopt;
  const size_t colon = text.find(':');
  const auto low = ToNumber(text.substr(0, colon));
  const auto high = colon == std::string::npos ? std::nullopt : ToNumber(text.substr(colon + 1));
  const bool range = low && high && *low < *high && *low >= -kMaxPlanHeight &&
                     *high <= kMaxPlanHeight;  // not for NaN
  if (!range) {
    RefuseFlag("--heights " + QuoteShortened(text) +
               " is not a range; give the lowest and the highest position as -0.5:2.5");
  }
  if (!map.poses) {
    throw MapError(ErrorCode::kNoLayer,
                   "--heights: positions of this map have no heights; leave it out");
  }
  return PlanHeights{*low, *high};
}

std::vector<uint8_t> ReadImage(const std::string& path) {
  std::error_code ignored;
  const uintmax_t bytes = std::filesystem::file_size(path, ignored);
  if (!ignored && bytes > kMaxPlanImageBytes) {
    throw MapError(ErrorCode::kImageTooLarge,
                   path + " has " + std::to_string(bytes) + " bytes; at most " +
                       std::to_string(kMaxPlanImageBytes) + " are allowed; scale it down");
  }
  return ReadBytes(path, "a PNG, JPEG or WebP");
}

FloorPlanImage ReadPlan(const PlanFlags& flags, const MapData& map) {
  FloorPlanImage plan;
  plan.name = flags.name.empty() ? kDefaultName : flags.name;
  if (const auto problem = FindNameProblem(plan.name)) {
    RefuseFlag("the name " + QuoteShortened(plan.name) + " " + *problem);
  }
  plan.image = ReadImage(flags.image);
  const PlanImageSize size = InspectPlanImage(plan.image);
  if (!size.problem.empty()) {
    throw MapError(ErrorCode::kBadImage, flags.image + ": " + size.problem);
  }
  if (ReadExifOrientation(plan.image) != 1) {
    throw MapError(ErrorCode::kBadImage,
                   flags.image +
                       " is stored turned (EXIF orientation), so its pixels are not where viewers "
                       "show them; save it upright, without EXIF data");
  }
  try {
    DecodeGrey(plan.image);  // perhaps only the header is sound
  } catch (const MapError& error) {
    throw MapError(error.code(), flags.image + ": " + error.what());
  }
  plan.width = size.width;
  plan.height = size.height;
  for (const std::string& text : flags.anchors) plan.anchors.push_back(ReadAnchor(map, text));
  if (const auto problem = FindAnchorProblem(plan.anchors, plan.width, plan.height)) {
    RefuseFlag("--anchor: " + *problem);
  }
  plan.heights = ReadHeights(map, flags.heights);
  return plan;
}

void PutPlan(FloorPlanImage plan, std::vector<FloorPlanImage>& plans) {
  std::erase_if(plans, [&plan](const FloorPlanImage& old) { return old.name == plan.name; });
  if (plans.size() >= kMaxFloorPlans) {
    RefuseFlag("the map has " + std::to_string(plans.size()) +
               " floor plans, the most it can hold; remove one with --remove");
  }
  const auto behind = std::ranges::upper_bound(plans, plan.name, {}, &FloorPlanImage::name);
  plans.insert(behind, std::move(plan));
}

void RemovePlan(std::vector<FloorPlanImage>& plans, const std::string& name) {
  const auto found = std::ranges::find(plans, name, &FloorPlanImage::name);
  if (found == plans.end()) {
    throw MapError(ErrorCode::kNotFound, "the map has no floor plan named " + QuoteShortened(name) +
                                             "; `waystone plan MAP` lists them");
  }
  plans.erase(found);
}

std::string PlanLine(const FloorPlanImage& plan, const std::string& unit) {
  const PlanFit fit = FitPlan(plan.anchors);
  char text[200];
  (void)std::snprintf(text, sizeof text, " px, %zu anchors, %.4g px per %s, residual %.3g %s",
                      plan.anchors.size(), fit.px_per_unit, unit.c_str(),
                      Rounded(fit.residual_px / fit.px_per_unit, 6), unit.c_str());
  std::string line = Printable(plan.name) + ": " + SizeText(plan.width, plan.height) + text;
  if (!plan.heights) return line;
  (void)std::snprintf(text, sizeof text, ", heights %g to %g", plan.heights->low,
                      plan.heights->high);
  return line + text;
}

bool HasMetres(const MapData& map) {
  if (map.poses) return map.poses->unit == LengthUnit::kMetres;
  return map.appearance && map.appearance->metres_per_unit == 1.0;
}

void PrintPlans(const PlanFlags& flags, const MapData& map) {
  if (flags.json) {
    Json json = FloorPlansJson(MapNameOf(flags.map), map);
    json["map"] = MapNameOf(flags.map);
    std::cout << Dump(json) << '\n';
    return;
  }
  std::cout << flags.map << ": " << map.floor_plans.size()
            << (map.floor_plans.size() == 1 ? " floor plan\n" : " floor plans\n");
  for (const FloorPlanImage& plan : map.floor_plans) {
    std::cout << "  " << PlanLine(plan, HasMetres(map) ? "m" : "unit") << '\n';
  }
}

void CheckPlanFlags(const PlanFlags& flags) {
  if (!flags.image.empty() && !flags.remove.empty()) {
    RefuseFlag("specify an image or --remove, not both");
  }
  const bool places = !flags.anchors.empty() || !flags.name.empty() || !flags.heights.empty();
  if (places && flags.image.empty()) {
    RefuseFlag("specify the image of the plan, too: --anchor, --name and --heights belong to it");
  }
  if (!flags.image.empty() && flags.anchors.size() < 2) {
    RefuseFlag("specify two or more points of the plan with --anchor PX,PY=X,Y");
  }
}

int RunPlan(const PlanFlags& flags) {
  CheckPlanFlags(flags);
  const bool changes = !flags.image.empty() || !flags.remove.empty();
  std::optional<MapLock> lock;
  if (changes) lock.emplace(flags.map);
  MapData map = ReadMap(flags.map, {.images = changes});
  if (!flags.image.empty()) {
    if (!map.poses && !map.appearance) {
      throw MapError(ErrorCode::kNoLayer,
                     flags.map +
                         " has no positions for a plan; build it with --poses or from "
                         "panoramas");
    }
    PutPlan(ReadPlan(flags, map), map.floor_plans);
  }
  if (!flags.remove.empty()) RemovePlan(map.floor_plans, flags.remove);
  if (changes) RewriteOptionalTables(map, flags.map);
  PrintPlans(flags, map);
  return 0;
}

}  // namespace

void AddPlan(CLI::App& app, Run& run) {
  auto flags = std::make_shared<PlanFlags>();
  CLI::App* command =
      app.add_subcommand("plan", "Put a floor plan under a map, and list its floor plans");
  command->add_option("map", flags->map, "Map file")->required();
  command->add_option("image", flags->image,
                      "Image of the plan: PNG, JPEG or WebP; without one, the plans are listed");
  command
      ->add_option("--anchor", flags->anchors,
                   "PX,PY=X,Y: a pixel of the image and its position in the map as seen from "
                   "above, or PX,PY=keyframe:ID, or node:ID for a panorama; two or more")
      ->allow_extra_args(false);
  command->add_option("--name", flags->name,
                      std::string("Name of the plan (default \"") + kDefaultName +
                          "\"); one of the same name is replaced");
  command->add_option("--heights", flags->heights,
                      "LOW:HIGH, heights of the positions that the plan shows; all by default");
  command->add_option("--remove", flags->remove, "Remove the plan of this name");
  command->add_flag("--json", flags->json, "Print one JSON object");
  command->footer(
      "Pixels count from the upper left corner to the right and downwards. The map file is "
      "written\n"
      "anew beside the old one and renamed.\n"
      "Example: waystone plan office.db ground.png --anchor 120,340=0,0 --anchor 860,340=14.8,0");
  command->callback([flags, &run] { run = [flags] { return RunPlan(*flags); }; });
}

}  // namespace waystone
