// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "localizer/verdict/answer.h"

namespace waystone {

// Which layer an id belongs to.
enum class PlaceLayer { kPlanes, kAppearance };
const char* NameOf(PlaceLayer layer);  // "planes", "appearance"

// Where a query was taken, in the frame and units of the appearance layer.
struct PlacePosition {
  double x = 0;
  double y = 0;
  double sigma = 0;                       // standard deviation along the worst direction
  std::optional<double> metres_per_unit;  // nothing when the layer's scale isn't known
};

// The place of a localized query, whatever the layer that answered.
struct AnsweredPlace {
  PlaceLayer layer = PlaceLayer::kPlanes;
  int64_t id = 0;        // of the nearest keyframe (planes) or node (appearance)
  std::string image;     // the source image of that keyframe or node
  std::string sequence;  // its name
  std::optional<double> time_s;
  std::optional<PlacePosition> position;  // of the query; nothing where the map has no positions
  std::optional<Heading> heading;         // of the query
  std::optional<std::string> name;        // given by people, if any
  std::optional<PlanPosition> plan;       // of the query, on a floor plan that shows it
};

// Nothing unless the answer is localized. Thread-safe.
std::optional<AnsweredPlace> PlaceOf(const Answer& answer);

}  // namespace waystone
