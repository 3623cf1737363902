// SPDX-License-Identifier: Apache-2.0
#include "schema/layers/planes/keyframe_camera.h"

#include <algorithm>

#include "core/camera/image_plane.h"

namespace waystone {

std::optional<Camera> CameraOfKeyframe(const Sequence& sequence, const Keyframe& keyframe) {
  if (!sequence.camera) return std::nullopt;
  return ScaledCamera(*sequence.camera, keyframe.width);
}

std::optional<Camera> CameraOfKeyframe(const MapData& map, KeyframeId id) {
  const auto keyframe = std::ranges::lower_bound(map.keyframes, id, {}, &Keyframe::id);
  if (keyframe == map.keyframes.end() || keyframe->id != id) return std::nullopt;
  const auto sequence =
      std::ranges::lower_bound(map.sequences, keyframe->sequence, {}, &Sequence::id);
  const bool found = sequence != map.sequences.end() && sequence->id == keyframe->sequence;
  return found ? CameraOfKeyframe(*sequence, *keyframe) : std::nullopt;
}

}  // namespace waystone
