// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "schema/map_data.h"

namespace waystone {

// The convex hull of points; fewer than three, or points in a line, give what they have of one.
std::vector<Eigen::Vector2d> ConvexHull(const std::vector<Eigen::Vector2d>& points);

// The features of a plane that another image has in front of its camera and inside the convex hull
// of some points or on its border: indices, ascending.
std::vector<int> FeaturesInsideHull(const Plane& plane, const Eigen::Matrix3d& to_from,
                                    const std::vector<Eigen::Vector2d>& points);

// The polygon that a set of points supports, as the characteristic shape of Duckham, Kulik, Worboys
// and Galton ("Efficient generation of simple polygons for characterizing the shape of a set of
// points in the plane", 2008): their Delaunay triangulation, from whose border triangles are taken
// away, longest border edge first, as long as that edge is longer than `longest_edge` and the rest
// stays one piece. A triangle that holds one of `others`, points that are known to be of something
// else, is taken away, too: at the border whatever its edges, inside as a hole. A hole is joined to
// the border by a cut of no width, so that one ring has it all: its area and which points are
// inside are right under the non-zero and the even-odd rule. All points in pixels; anticlockwise
// where y points up. Fewer than three points, or points in a line, give their convex hull.
std::vector<Eigen::Vector2d> SupportedPolygon(const std::vector<Eigen::Vector2d>& points,
                                              const std::vector<Eigen::Vector2d>& others,
                                              double longest_edge);

// Gives every plane of a map its outline in its reference image: the polygon that its features
// support, without where the reference image shows features of planes on other surfaces. The planes
// and edges are final.
void OutlinePlanes(MapData& map);

}  // namespace waystone
