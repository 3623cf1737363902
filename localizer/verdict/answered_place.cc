// SPDX-License-Identifier: Apache-2.0
#include "localizer/verdict/answered_place.h"

#include "core/base/check.h"

namespace waystone {
namespace {

// A keyframe or a node.
template <typename Ref>
AnsweredPlace PlaceAt(PlaceLayer layer, const Ref& ref, const Answer& answer) {
  return {layer,        ref.id.value,   ref.source,        ref.sequence, ref.time_s,
          std::nullopt, answer.heading, answer.place_name, answer.plan};
}

}  // namespace

const char* NameOf(PlaceLayer layer) {
  switch (layer) {
    case PlaceLayer::kPlanes:
      return "planes";
    case PlaceLayer::kAppearance:
      return "appearance";
  }
  WS_CHECK(false, "unknown layer of a place");
}

std::optional<AnsweredPlace> PlaceOf(const Answer& answer) {
  if (answer.verdict != Verdict::kLocalized) return std::nullopt;
  if (answer.planes.keyframe) {
    return PlaceAt(PlaceLayer::kPlanes, *answer.planes.keyframe, answer);
  }
  if (!answer.panorama) return std::nullopt;
  const PanoramaAnswer& panorama = *answer.panorama;
  AnsweredPlace place = PlaceAt(PlaceLayer::kAppearance, panorama.node, answer);
  place.position =
      PlacePosition{panorama.pose.x, panorama.pose.y, panorama.sigma, panorama.metres_per_unit};
  return place;
}

}  // namespace waystone
