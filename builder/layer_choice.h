// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <tuple>

#include "builder/sources/source.h"
#include "core/base/options.h"

namespace waystone {

// The layers that a map gets.
struct LayerChoice {
  // A single calibrated camera gives the orientation layer only where it is named: every frame has
  // to be looked at, which takes several times as long as the planes. The rest is ignored with it.
  bool automatic = true;
  bool planes = false;
  bool appearance = false;
  bool orientation = false;

  static constexpr auto Fields() {
    return std::tuple{
        OptionField{"automatic", &LayerChoice::automatic, AnyValue(), "",
                    "Choose by the images: panoramas give the appearance layer, others the plane "
                    "layer, rigs and panoramas the orientation layer, too."},
        OptionField{"planes", &LayerChoice::planes, AnyValue(), "", "Build the plane layer."},
        OptionField{"appearance", &LayerChoice::appearance, AnyValue(), "",
                    "Build the appearance layer."},
        OptionField{"orientation", &LayerChoice::orientation, AnyValue(), "",
                    "Build the orientation layer."}};
  }

  bool operator==(const LayerChoice&) const = default;
};

// "auto", or names with commas between them: "planes", "appearance", "orientation". Throws
// MapError(kBadOptions) for others.
LayerChoice LayerChoiceByNames(const std::string& names);

// What a source is used for: the appearance layer when it looks panoramic, else the plane layer.
// With one of the two chosen, all sources go to it; nothing when the orientation layer alone is.
enum class LayerKind { kPlanes, kAppearance };
std::optional<LayerKind> LayerOf(const Source& source, const LayerChoice& layers);
// Whether it is used for the orientation layer, too: a calibrated source, where that layer is
// wanted (LayerChoice::automatic).
bool GivesOrientation(const Source& source, const LayerChoice& layers);

}  // namespace waystone
