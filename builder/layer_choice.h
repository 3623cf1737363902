// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "builder/sources/source.h"
#include "core/base/options.h"

namespace waystone {

// The layers that a map gets. All functions here are thread-safe, except for sources shared by
// threads.
struct LayerChoice {
  // A single calibrated camera gives the orientation layer only where it is named: every frame has
  // to be looked at, which takes several times as long as the planes. The rest is ignored with it.
  bool automatic = true;
  bool planes = false;
  bool appearance = false;
  bool orientation = false;

  static constexpr auto Fields(const auto& use) {
    return use(
        OptionField{"automatic", &LayerChoice::automatic, AnyValue(), "",
                    "Choose the layers by the images: panoramas give the appearance layer, other "
                    "images the plane layer, and rigs and panoramas also the orientation layer."},
        OptionField{"planes", &LayerChoice::planes, AnyValue(), "", "Build the plane layer."},
        OptionField{"appearance", &LayerChoice::appearance, AnyValue(), "",
                    "Build the appearance layer."},
        OptionField{"orientation", &LayerChoice::orientation, AnyValue(), "",
                    "Build the orientation layer."});
  }

  bool operator==(const LayerChoice&) const = default;
};

// "auto", or names with commas between them: "planes", "appearance", "orientation". Throws
// MapError(kBadOptions) for others.
LayerChoice LayerChoiceByNames(const std::string& names);

// In the order in which they are built.
enum class LayerKind { kPlanes, kAppearance, kOrientation };

// Whether a source's frames look like panoramas: a rig, or images twice as wide as high (to 2 %). A
// mirror's images look like any others, so users have to say that they are panoramas.
bool LooksPanoramic(const Source& source);

// The layers for which a source is used, ascending. It goes to the appearance layer when it looks
// panoramic, else to the plane layer; with one of the two chosen, all sources go to that one. The
// orientation layer takes it too where it is calibrated and that layer is wanted
// (LayerChoice::automatic). None for a source that no chosen layer can use.
std::vector<LayerKind> ChooseLayers(const Source& source, const LayerChoice& choice);

// A source with its layers, at least one.
struct AssignedSource {
  Source* source = nullptr;
  std::vector<LayerKind> layers;
};

// The sources that a layer can use, ordered by their first layer. Throws MapError for a layer that
// was requested by name and gets no source: kBadCamera for the orientation layer, else kBadSource.
std::vector<AssignedSource> AssignSources(const std::vector<std::unique_ptr<Source>>& sources,
                                          const LayerChoice& choice);

}  // namespace waystone
