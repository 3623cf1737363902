// SPDX-License-Identifier: Apache-2.0
#include "world/faces.h"

#include <algorithm>
#include <limits>
#include <map>
#include <set>
#include <utility>

#include "core/base/check.h"
#include "core/base/error.h"

namespace waystone {
namespace {

constexpr int kFloorId = 1;
constexpr int kCeilingId = 2;
constexpr std::array<std::array<int, 2>, 4> kSteps = {{{1, 0}, {0, 1}, {-1, 0}, {0, -1}}};

// One side of a cell with something on it: a wall, or the lintel above a door.
struct Piece {
  int x = 0;  // the open cell in front of it; y counts northwards
  int y = 0;
  int side = 0;
  double low_m = 0.0;  // heights above the floor
  double high_m = 0.0;
  char poster = 0;
  int plane = 0;
};

// Walls in one plane that face the same way have the same side and the same line of the grid.
struct LineKey {
  int side = 0;
  int line = 0;
  auto operator<=>(const LineKey&) const = default;
};

class Builder {
 public:
  explicit Builder(const FloorPlan& plan) : plan_(plan) {
    geometry_.columns = plan.columns;
    geometry_.rows = plan.rows;
    geometry_.cell_m = plan.size.cell_m;
    geometry_.cells.resize(static_cast<size_t>(plan.columns) * static_cast<size_t>(plan.rows));
  }

  Geometry Build() {
    SetHeights();
    AddHorizontalPlanes();
    for (auto& [key, pieces] : CollectPieces()) AddWallPlane(key, pieces);
    ConnectHorizontal();
    ConnectCorners();
    for (const auto& [a, b] : edges_) PlaneOf(a).neighbours.push_back(b);
    return std::move(geometry_);
  }

 private:
  CellFaces& CellAt(int x, int y) {
    return geometry_.cells[static_cast<size_t>(y) * static_cast<size_t>(geometry_.columns) +
                           static_cast<size_t>(x)];
  }
  WorldPlane& PlaneOf(int id) { return geometry_.planes[static_cast<size_t>(id - 1)]; }
  char PosterAt(int x, int y) const { return plan_.PosterAt(x, plan_.rows - 1 - y); }

  void SetHeights() {
    for (int y = 0; y < plan_.rows; ++y) {
      for (int x = 0; x < plan_.columns; ++x) {
        const int row = plan_.rows - 1 - y;
        if (!plan_.IsOpen(x, row)) continue;
        const double height =
            plan_.IsDoor(x, row) ? plan_.size.door_height_m : plan_.size.wall_height_m;
        CellAt(x, y).ceiling_m = height;
        CellAt(x, y).top_face = kCeilingId;
      }
    }
  }

  int AddPlane(SurfaceKind kind, const Eigen::Vector3d& origin, const Eigen::Vector3d& u_axis,
               const Eigen::Vector3d& v_axis) {
    WorldPlane plane;
    plane.id = static_cast<int>(geometry_.planes.size()) + 1;
    plane.kind = kind;
    plane.origin = origin;
    plane.u_axis = u_axis;
    plane.v_axis = v_axis;
    plane.normal = -u_axis.cross(v_axis);
    geometry_.planes.push_back(plane);
    return plane.id;
  }

  WorldFace& AddFace(int plane, const Eigen::Vector3d& origin, const Eigen::Vector2d& size_m) {
    if (geometry_.faces.size() >= std::numeric_limits<uint16_t>::max()) {
      throw MapError(ErrorCode::kBadOptions,
                     "the floor plan has more than 65535 faces; draw a smaller one");
    }
    WorldFace face;
    face.id = static_cast<int>(geometry_.faces.size()) + 1;
    face.plane = plane;
    face.origin = origin;
    face.size_m = size_m;
    PlaneOf(plane).faces.push_back(face.id);
    geometry_.faces.push_back(face);
    return geometry_.faces.back();
  }

  // Floor, ceiling and the undersides of lintels; each is one face over the whole plan.
  void AddHorizontalPlanes() {
    const Eigen::Vector2d size(plan_.columns * geometry_.cell_m, plan_.rows * geometry_.cell_m);
    const auto add = [&](SurfaceKind kind, const Eigen::Vector3d& origin, double v_sign) {
      const int plane =
          AddPlane(kind, origin, Eigen::Vector3d::UnitX(), v_sign * Eigen::Vector3d::UnitY());
      PlaneOf(plane).size_m = size;
      return AddFace(plane, origin, size).id;
    };
    const PlanOptions& heights = plan_.size;
    WS_CHECK(add(SurfaceKind::kFloor, {0.0, size.y(), 0.0}, -1.0) == kFloorId, "floor is first");
    WS_CHECK(add(SurfaceKind::kCeiling, {0.0, 0.0, heights.wall_height_m}, 1.0) == kCeilingId,
             "ceiling is second");
    const auto is_low = [&](const CellFaces& cell) {
      return cell.top_face != 0 && cell.ceiling_m < heights.wall_height_m;
    };
    if (std::none_of(geometry_.cells.begin(), geometry_.cells.end(), is_low)) return;
    const int lintel = add(SurfaceKind::kLintel, {0.0, 0.0, heights.door_height_m}, 1.0);
    for (CellFaces& cell : geometry_.cells) {
      if (is_low(cell)) cell.top_face = static_cast<uint16_t>(lintel);
    }
  }

  std::map<LineKey, std::vector<Piece>> CollectPieces() {
    std::map<LineKey, std::vector<Piece>> lines;
    for (int y = 0; y < plan_.rows; ++y) {
      for (int x = 0; x < plan_.columns; ++x) {
        if (CellAt(x, y).top_face == 0) continue;
        for (int side = 0; side < 4; ++side) {
          const auto& step = kSteps[static_cast<size_t>(side)];
          const CellFaces& next = CellAt(x + step[0], y + step[1]);
          if (next.ceiling_m >= CellAt(x, y).ceiling_m) continue;
          const int line = step[0] != 0 ? x + (step[0] > 0) : y + (step[1] > 0);
          lines[{side, line}].push_back({x, y, side, std::max(next.ceiling_m, 0.0),
                                         CellAt(x, y).ceiling_m, PosterAt(x + step[0], y + step[1]),
                                         0});
        }
      }
    }
    return lines;
  }

  // Position of a piece along its face, left to right for a viewer.
  static int Along(const Piece& piece) {
    constexpr std::array<int, 4> kSigns = {-1, 1, 1, -1};
    const bool along_y = piece.side % 2 == 0;
    return kSigns[static_cast<size_t>(piece.side)] * (along_y ? piece.y : piece.x);
  }

  Eigen::Vector3d TopLeft(const Piece& piece) const {
    constexpr std::array<std::array<int, 2>, 4> kCorners = {{{1, 1}, {0, 1}, {0, 0}, {1, 0}}};
    const auto& corner = kCorners[static_cast<size_t>(piece.side)];
    return {(piece.x + corner[0]) * geometry_.cell_m, (piece.y + corner[1]) * geometry_.cell_m,
            plan_.size.wall_height_m};
  }

  void AddWallPlane(const LineKey& key, std::vector<Piece>& pieces) {
    std::sort(pieces.begin(), pieces.end(),
              [](const Piece& a, const Piece& b) { return Along(a) < Along(b); });
    const auto& step = kSteps[static_cast<size_t>(key.side)];
    const Eigen::Vector3d towards(step[0], step[1], 0.0);
    const int plane = AddPlane(SurfaceKind::kWall, TopLeft(pieces.front()),
                               towards.cross(Eigen::Vector3d::UnitZ()), -Eigen::Vector3d::UnitZ());
    PlaneOf(plane).size_m = {(Along(pieces.back()) - Along(pieces.front()) + 1) * geometry_.cell_m,
                             plan_.size.wall_height_m};
    for (size_t first = 0; first < pieces.size();) {
      size_t last = first + 1;
      while (last < pieces.size() && Continues(pieces[last - 1], pieces[last])) ++last;
      AddWallFace(plane, {pieces.data() + first, pieces.data() + last});
      first = last;
    }
  }

  static bool Overlap(const Piece& a, const Piece& b) {
    return std::max(a.low_m, b.low_m) < std::min(a.high_m, b.high_m);
  }
  static bool Continues(const Piece& left, const Piece& right) {
    return Along(right) == Along(left) + 1 && Overlap(left, right);
  }

  void AddWallFace(int plane, std::vector<Piece> pieces) {
    WorldFace& face =
        AddFace(plane, TopLeft(pieces.front()),
                {static_cast<double>(pieces.size()) * geometry_.cell_m, plan_.size.wall_height_m});
    for (Piece& piece : pieces) {
      piece.plane = plane;
      face.spans.push_back({Along(piece) - Along(pieces.front()),
                            plan_.size.wall_height_m - piece.high_m,
                            plan_.size.wall_height_m - piece.low_m, piece.poster});
      CellAt(piece.x, piece.y).side_faces[static_cast<size_t>(piece.side)] =
          static_cast<uint16_t>(face.id);
      pieces_.push_back(piece);
    }
  }

  void Connect(int a, int b) {
    if (a == b) return;
    edges_.emplace(a, b);
    edges_.emplace(b, a);
  }

  void ConnectHorizontal() {
    for (const Piece& piece : pieces_) {
      const auto& step = kSteps[static_cast<size_t>(piece.side)];
      const CellFaces& behind = CellAt(piece.x + step[0], piece.y + step[1]);
      Connect(piece.plane, CellAt(piece.x, piece.y).top_face);
      Connect(piece.plane, behind.top_face != 0 ? behind.top_face : kFloorId);
    }
  }

  // Perpendicular pieces that end at the same corner of the grid share a vertical edge.
  void ConnectCorners() {
    std::map<std::pair<int, int>, std::vector<const Piece*>> corners;
    for (const Piece& piece : pieces_) {
      const auto& step = kSteps[static_cast<size_t>(piece.side)];
      for (int end = 0; end < 2; ++end) {
        const int x = step[0] != 0 ? piece.x + (step[0] > 0) : piece.x + end;
        const int y = step[0] != 0 ? piece.y + end : piece.y + (step[1] > 0);
        corners[{x, y}].push_back(&piece);
      }
    }
    for (const auto& [corner, pieces] : corners) {
      for (const Piece* a : pieces) {
        for (const Piece* b : pieces) {
          if (a->side % 2 != b->side % 2 && Overlap(*a, *b)) Connect(a->plane, b->plane);
        }
      }
    }
  }

  const FloorPlan& plan_;
  Geometry geometry_;
  std::vector<Piece> pieces_;
  std::set<std::pair<int, int>> edges_;
};

}  // namespace

const char* NameOf(SurfaceKind kind) {
  switch (kind) {
    case SurfaceKind::kFloor:
      return "floor";
    case SurfaceKind::kCeiling:
      return "ceiling";
    case SurfaceKind::kLintel:
      return "lintel";
    case SurfaceKind::kWall:
      return "wall";
  }
  return "unknown";
}

Geometry BuildGeometry(const FloorPlan& plan) { return Builder(plan).Build(); }

}  // namespace waystone
