// SPDX-License-Identifier: Apache-2.0
#include "builder/layer_choice.h"

#include <algorithm>
#include <optional>
#include <sstream>
#include <utility>

#include "builder/orientation/source_rig.h"
#include "core/base/error.h"
#include "core/camera/panorama.h"
#include "schema/sequence_kinds.h"

namespace waystone {
namespace {

bool GivesOrientation(const Source& source, const LayerChoice& choice) {
  if (!choice.automatic && !choice.orientation) return false;
  const std::optional<SourceRig> rig = FindSourceRig(source);
  return rig && (choice.orientation || rig->rig.cameras.size() > 1);
}

// A requested layer without any source is an error.
void CheckAsked(const std::vector<AssignedSource>& assigned, size_t sources,
                const LayerChoice& choice) {
  const std::string none = "none of the " + std::to_string(sources) + " sources ";
  const auto missing = [&](bool asked, LayerKind kind) {
    return asked && std::ranges::none_of(assigned, [&](const AssignedSource& source) {
             return std::ranges::find(source.layers, kind) != source.layers.end();
           });
  };
  if (missing(choice.planes, LayerKind::kPlanes)) {
    throw MapError(
        ErrorCode::kBadSource,
        none +
            "are ordinary images, which the plane layer requires; omit planes, or select "
            "that layer alone to treat panoramas as photos");
  }
  if (missing(choice.appearance, LayerKind::kAppearance)) {
    throw MapError(ErrorCode::kBadSource,
                   none +
                       "are panoramas (twice as wide as high, or rigs), which the appearance layer "
                       "requires; select that layer alone to treat other images as panoramas");
  }
  if (missing(choice.orientation, LayerKind::kOrientation)) {
    throw MapError(ErrorCode::kBadCamera,
                   none +
                       "is calibrated, which the orientation layer requires; use --camera FILE, "
                       "panoramas or a rig");
  }
}

}  // namespace

LayerChoice LayerChoiceByNames(const std::string& names) {
  LayerChoice layers;
  if (names == "auto") return layers;
  layers.automatic = false;
  std::istringstream list(names);
  std::string name;
  while (std::getline(list, name, ',')) {
    if (name == "planes") {
      layers.planes = true;
    } else if (name == "appearance") {
      layers.appearance = true;
    } else if (name == "orientation") {
      layers.orientation = true;
    } else {
      throw MapError(ErrorCode::kBadOptions,
                     "unknown layer '" + name +
                         "'; use auto, or a comma-separated list of planes, appearance and "
                         "orientation");
    }
  }
  if (layers.planes || layers.appearance || layers.orientation) return layers;
  throw MapError(ErrorCode::kBadOptions,
                 "no layer given; use auto, planes, appearance or orientation");
}

bool LooksPanoramic(const Source& source) {
  return source.kind() == kRigKind || HasPanoramaShape(source.frame_size());
}

std::vector<LayerKind> ChooseLayers(const Source& source, const LayerChoice& choice) {
  std::vector<LayerKind> layers;
  if (choice.automatic || (choice.planes && choice.appearance)) {
    layers.push_back(LooksPanoramic(source) ? LayerKind::kAppearance : LayerKind::kPlanes);
  } else if (choice.planes || choice.appearance) {
    layers.push_back(choice.planes ? LayerKind::kPlanes : LayerKind::kAppearance);
  }
  if (GivesOrientation(source, choice)) layers.push_back(LayerKind::kOrientation);
  return layers;
}

std::vector<AssignedSource> AssignSources(const std::vector<std::unique_ptr<Source>>& sources,
                                          const LayerChoice& choice) {
  std::vector<AssignedSource> assigned;
  for (const std::unique_ptr<Source>& source : sources) {
    std::vector<LayerKind> layers = ChooseLayers(*source, choice);
    if (!layers.empty()) assigned.push_back({source.get(), std::move(layers)});
  }
  CheckAsked(assigned, sources.size(), choice);
  std::ranges::stable_sort(assigned, {},
                           [](const AssignedSource& source) { return source.layers.front(); });
  return assigned;
}

}  // namespace waystone
