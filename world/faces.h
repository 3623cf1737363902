// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "world/floor_plan.h"

namespace waystone {

enum class SurfaceKind : uint8_t { kFloor, kCeiling, kLintel, kWall };

// "floor", "ceiling", "lintel" (the underside of the doors' lintels) or "wall". Thread-safe.
const char* NameOf(SurfaceKind kind);

// A geometric plane, seen from its one visible side. Everything that lies in the same plane and
// faces the same way has the same id, even where gaps or whole rooms lie between its faces: no
// homography can distinguish them. Coplanar walls that face opposite ways are two planes.
//
// The plane's own coordinates (u, v), in metres, start at `origin`, the top left corner of the
// bounding rectangle of its faces for a viewer (walls: v points down; floor: u east, v south;
// ceiling and lintels: u east, v north): x_world = origin + u * u_axis + v * v_axis. u_axis, v_axis
// and -normal are a right-handed frame.
struct WorldPlane {
  int id = 0;  // from 1
  SurfaceKind kind = SurfaceKind::kWall;
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();
  Eigen::Vector3d u_axis = Eigen::Vector3d::Zero();
  Eigen::Vector3d v_axis = Eigen::Vector3d::Zero();
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();  // unit, towards the free side
  Eigen::Vector2d size_m = Eigen::Vector2d::Zero();  // of that rectangle, along u and v
  std::vector<int> faces;                            // ids of its faces, ascending
  std::vector<int> neighbours;  // ids of planes it shares an edge of the building with, ascending
};

// A stretch of a wall face along u: one cell of the plan, between two heights (metres along v).
struct FaceSpan {
  int cell = 0;  // counted from the face's left end
  double top_m = 0.0;
  double bottom_m = 0.0;
  char poster = 0;  // the plan's letter, or 0
};

// A maximal connected piece of a plane; it has a texture of its own.
struct WorldFace {
  int id = 0;  // from 1
  int plane = 0;
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();  // as of a plane; the axes are its plane's
  Eigen::Vector2d size_m = Eigen::Vector2d::Zero();
  std::vector<FaceSpan> spans;  // of walls, left to right; floor and ceilings have none
};

// What ray casting needs to know about a cell. Sides are those by which a ray leaves: 0 east, 1
// north, 2 west, 3 south; a side's face id is 0 where nothing stands there.
struct CellFaces {
  double ceiling_m = -1.0;  // below the floor for wall: nothing passes
  std::array<uint16_t, 4> side_faces{};
  uint16_t top_face = 0;
};

struct Geometry {
  int columns = 0;
  int rows = 0;
  double cell_m = 0.0;
  std::vector<CellFaces> cells;  // row-major from the south-west corner: northward rows
  std::vector<WorldPlane> planes;
  std::vector<WorldFace> faces;
};

// The planes, faces and adjacency of a plan. Floor is plane 1 and ceiling plane 2 (their faces have
// the same ids); lintels, if any, come next, then walls. Throws MapError(kBadOptions) when there
// are more than 65,535 faces. Pure; thread-safe.
Geometry BuildGeometry(const FloorPlan& plan);

}  // namespace waystone
