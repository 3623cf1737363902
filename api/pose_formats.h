// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "api/graph_formats.h"
#include "schema/map_data.h"

namespace waystone {

// "g2o", "geojson", "ply", "tum", "poses". Thread-safe.
std::vector<std::string> PoseFormatNames();

// The poses of a map's appearance layer in a format that other programs read. Lengths are in metres
// where the layer's scale is known and else in its own unit; each format says which.
//   g2o      VERTEX_SE2 a node, EDGE_SE2 a measured edge. The layer keeps the sigma of headings
//            alone: positions are given half the edge's length, a tenth of the mean edge at least.
//   geojson  nodes as points, edges as lines, x and y in the layer's frame. That is not on the
//            earth, as RFC 7946 has it without an agreement: the member `frame` says so. Of a map
//            with given poses, keyframes as seen from above (HorizontalOf), with the nodes where
//            these are in that frame.
//            Points of a map with named places say theirs in `place`, and polygons are added.
//   ply      nodes as vertices at height 0, or where their given poses are, and edges, ASCII.
//   tum      "time x y z qx qy qz qw" a node, as the tools of the TUM RGB-D benchmark read it; x is
//            ahead of the camera, z up. The frame's number stands for the time where a node of the
//            map has none. Where nodes have given poses, these, with the camera's axes, and no
//            others.
//   poses    "name qw qx qy qz tx ty tz" a node, as visuallocalization.net takes results:
//            camera_from_world of the panorama's front, x right, y down, z forward; the given poses
//            where nodes have some. Metres: needs a known scale.
// Nothing for another name. Throws MapError(kNotAvailable) for a map without an appearance layer
// and for what a layer can't give. Deterministic; thread-safe.
std::optional<GraphText> FormatPoses(const MapData& map, const std::string& format);

}  // namespace waystone
