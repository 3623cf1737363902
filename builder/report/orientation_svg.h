// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "schema/layers/orientation/orientation_layer.h"

// Pictures of the orientation layer (Puig et al. 2012), each as one <svg> of the report's style.
// They draw a sequence, which has at least one frame in the layer. All functions are pure;
// thread-safe.
namespace waystone {

// The sequences of a layer in the order of its frames.
std::vector<SequenceId> SequencesOf(const OrientationLayer& layer);

// The topological map (fig. 10): the trajectory by its turns only
// (schema/layers/orientation/orientation_trajectory.h) with red turns, green nodes where the view
// breaks, blue false turns where only the camera turned, loops and corridors; a stroke at a node is
// its heading.
std::string OrientationMapSvg(const OrientationLayer& layer, SequenceId sequence);

// Heading and lines along each axis over the frames (figs. 3, 4 and 11) with turns as vertical
// lines and corridors shaded.
std::string OrientationPlotSvg(const OrientationLayer& layer, SequenceId sequence);

// Lines perpendicular to the way in the four cells around it, seen along the way (fig. 13).
std::string DirectionCellsSvg(const OrientationNode& node);

}  // namespace waystone
