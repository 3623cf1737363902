// SPDX-License-Identifier: Apache-2.0
#include "builder/layer_choice.h"

#include <sstream>

#include "builder/appearance/describe_frames.h"
#include "builder/orientation/view.h"
#include "core/base/error.h"

namespace waystone {

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

std::optional<LayerKind> LayerOf(const Source& source, const LayerChoice& layers) {
  if (!layers.automatic && !layers.planes && !layers.appearance) return std::nullopt;
  if (!layers.automatic && layers.planes != layers.appearance) {
    return layers.planes ? LayerKind::kPlanes : LayerKind::kAppearance;
  }
  return LooksPanoramic(source) ? LayerKind::kAppearance : LayerKind::kPlanes;
}

bool GivesOrientation(const Source& source, const LayerChoice& layers) {
  if (!layers.automatic && !layers.orientation) return false;
  const std::optional<SourceRig> head = RigOfSource(source);
  return head && (layers.orientation || head->rig.cameras.size() > 1);
}

}  // namespace waystone
