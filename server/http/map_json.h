// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

#include "localizer/map_index.h"
#include "server/http/json.h"

// The parts of a map as the HTTP API shows them. Matrices are three rows of three, points are
// [x, y] in pixels, links are by id.
namespace waystone {

// name, version, program, feature_type, sequences, keyframes, planes, edges, features (counts).
Json MapJson(const std::string& name, const MapIndex& index);

// A plane in a list: id, reference, features, views (counts), neighbours, outline.
Json PlaneSummaryJson(const MapIndex& index, const Plane& plane);
// The whole plane: the features and views themselves instead of their counts, too.
Json PlaneJson(const MapIndex& index, const Plane& plane);

// Nodes and edges of the graph of planes.
Json GraphJson(const MapIndex& index);

// A keyframe: id, sequence, source, time, size, the planes it saw with their inliers and
// reference_from_keyframe, and the address of its image (null when images were left out).
Json KeyframeJson(const std::string& map_name, const MapIndex& index, const Keyframe& keyframe);

}  // namespace waystone
