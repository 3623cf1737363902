// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "core/camera/camera.h"
#include "schema/map_data.h"

namespace waystone {

// The camera of a keyframe's working image: its sequence's, which is that of the original images,
// scaled to the keyframe's size. Nothing where the sequence has none. Pure; thread-safe.
std::optional<Camera> CameraOfKeyframe(const Sequence& sequence, const Keyframe& keyframe);

// The same for a keyframe of the map, by its id; nothing for one that isn't there.
std::optional<Camera> CameraOfKeyframe(const MapData& map, KeyframeId id);

}  // namespace waystone
