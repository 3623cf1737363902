// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "schema/map_data.h"

namespace waystone {

// The convex hull of points; fewer than three, or collinear ones, give a degenerate hull of fewer
// corners. Pure; thread-safe, as are all functions here but OutlinePlanes.
std::vector<Eigen::Vector2d> ConvexHull(const std::vector<Eigen::Vector2d>& points);

// The features of a plane that, mapped by to_from, lie in front of the other image's camera and
// inside the convex hull of some of its points or on its border: indices, ascending.
std::vector<int> FeaturesInsideHull(const Plane& plane, const Eigen::Matrix3d& to_from,
                                    const std::vector<Eigen::Vector2d>& points);

// The polygon that a set of points supports, as the characteristic shape of Duckham, Kulik, Worboys
// and Galton ("Efficient generation of simple polygons for characterizing the shape of a set of
// points in the plane", 2008): their Delaunay triangulation, from whose border triangles are
// removed, longest border edge first, as long as that edge is longer than `longest_edge` and the
// rest stays one piece. A triangle that contains one of `others`, points known to belong to
// something else, is removed, too: at the border whatever its edges, inside as a hole. A hole is
// joined to the border by a cut of zero width, so that a single ring suffices: its area and its
// interior are right under the non-zero and the even-odd rule. All points in pixels; anticlockwise
// where y points up. Fewer than three points, or collinear ones, give their convex hull.
std::vector<Eigen::Vector2d> SupportedPolygon(const std::vector<Eigen::Vector2d>& points,
                                              const std::vector<Eigen::Vector2d>& others,
                                              double longest_edge);

// Gives every plane of a map its outline in its reference image: the polygon that its features
// support, except where the reference image shows features of planes on other surfaces. The planes
// and edges are final. Deterministic on any number of threads (it uses TBB's).
void OutlinePlanes(MapData& map);

}  // namespace waystone
