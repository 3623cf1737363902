// SPDX-License-Identifier: Apache-2.0
#include "world/flat.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "core/base/error.h"
#include "core/base/random.h"
#include "world/flat_furniture.h"
#include "world/texture.h"

namespace waystone {
namespace {

constexpr double kHeight_m = 2.5;
constexpr double kStairwell_m = 4.6;
constexpr double kWalls_m = 4.8;  // as high as the stairwell's
constexpr double kThin_m = 0.12;  // walls
constexpr double kDoorWidth_m = 0.82;
constexpr double kDoorHeight_m = 2.02;
constexpr double kDoorFree_m = 0.75;  // kept free around doors
constexpr int kStairSteps = 9;
constexpr double kStepRun_m = 0.24;
constexpr double kStairsWidth_m = 0.85;

// A hole in a wall.
struct Opening {
  double from_m = 0;  // along the wall
  double to_m = 0;
  double sill_m = 0;
  double top_m = 0;
};

class FlatMaker {
 public:
  explicit FlatMaker(const FlatOptions& options) : options_(options), random_(options.seed) {}

  Flat Make() {
    x_ = DrawLines(options_.columns);
    y_ = DrawLines(options_.rows);
    stairs_room_ = random_.Below(options_.columns * options_.rows);
    for (int j = 0; j < options_.rows; ++j) {
      for (int i = 0; i < options_.columns; ++i) AddRoom(i, j);
    }
    // Along x first: each room has a door to the next, rows are joined in one or two places.
    const int joint = random_.Below(options_.columns);
    for (int i = 0; i <= options_.columns; ++i) {
      for (int j = 0; j < options_.rows; ++j) AddWall(true, i, j, true);
    }
    for (int j = 0; j <= options_.rows; ++j) {
      for (int i = 0; i < options_.columns; ++i) {
        AddWall(false, j, i, i == joint || random_.Uniform() < 0.35);
      }
    }
    AddStairs();
    for (size_t room = 0; room < scene().rooms.size(); ++room) Furnish(static_cast<int>(room));
    return std::move(flat_);
  }

 private:
  RoomScene& scene() { return flat_.scene; }

  std::vector<double> DrawLines(int count) {
    std::vector<double> lines = {0};
    for (int i = 0; i < count; ++i) {
      lines.push_back(lines.back() + random_.Uniform(options_.min_side_m, options_.max_side_m));
    }
    return lines;
  }

  SceneMaterial Paint() {
    return {.albedo = random_.Uniform(0.74, 0.86),
            .contrast = options_.wall_contrast,
            .period_m = 0.5,
            .pattern = ScenePattern::kNoise,
            .seed = random_.Next()};
  }

  void AddBox(const Eigen::Vector3d& low, const Eigen::Vector3d& high,
              const SceneMaterial& material, bool is_wall) {
    if (((high - low).array() <= 1e-9).any()) return;
    SceneBox box;
    box.centre = 0.5 * (low + high);
    box.half_m = 0.5 * (high - low);
    box.material = material;
    box.is_wall = is_wall;
    scene().boxes.push_back(box);
  }

  void AddRoom(int i, int j) {
    SceneRoom room;
    room.low = {x_[i], y_[j]};
    room.high = {x_[i + 1], y_[j + 1]};
    const bool stairs = static_cast<int>(scene().rooms.size()) == stairs_room_;
    room.height_m = stairs ? kStairwell_m : kHeight_m;
    scene().rooms.push_back(room);
    SceneMaterial floor = {
        .albedo = random_.Uniform(0.2, 0.55),
        .contrast = random_.Uniform(0.1, 0.3),
        .period_m = random_.Uniform(0.1, 0.35),
        .gloss = 0.08,
        .pattern = random_.Uniform() < 0.6 ? ScenePattern::kStripes : ScenePattern::kTiles,
        .seed = random_.Next()};
    AddBox({room.low.x(), room.low.y(), -0.1}, {room.high.x(), room.high.y(), 0}, floor, true);
    AddBox({room.low.x(), room.low.y(), room.height_m},
           {room.high.x(), room.high.y(), kWalls_m + 0.1}, Paint(), true);
  }

  int RoomAt(int i, int j) const {
    const bool inside = i >= 0 && j >= 0 && i < options_.columns && j < options_.rows;
    return inside ? j * options_.columns + i : -1;
  }

  // The wall on line `line` of x (vertical) or y, beside cell `cell` of the other axis.
  void AddWall(bool vertical, int line, int cell, bool may_have_door) {
    const int before = vertical ? RoomAt(line - 1, cell) : RoomAt(cell, line - 1);
    const int behind = vertical ? RoomAt(line, cell) : RoomAt(cell, line);
    const double at = vertical ? x_[line] : y_[line];
    const double from = vertical ? y_[cell] : x_[cell];
    const double to = vertical ? y_[cell + 1] : x_[cell + 1];
    Opening hole;
    const bool outer = before < 0 || behind < 0;
    if (outer && random_.Uniform() < 0.75) {
      hole = DrawHole(from, to, random_.Uniform(0.7, 1.7), random_.Uniform(0.4, 1.0), 2.15);
    } else if (!outer && may_have_door) {
      hole = DrawHole(from, to, kDoorWidth_m, 0, kDoorHeight_m);
      const double middle = 0.5 * (hole.from_m + hole.to_m);
      flat_.doors.push_back(
          {vertical ? Eigen::Vector2d(at, middle) : Eigen::Vector2d(middle, at), {before, behind}});
    }
    BuildWall(vertical, at, from, to, hole);
    if (outer && hole.to_m > hole.from_m) {
      AddWindow(vertical, at, hole, before < 0 ? behind : before, before < 0 ? 1 : -1);
    }
  }

  Opening DrawHole(double from, double to, double width, double sill, double top) {
    const double slack = std::max(0.0, to - from - width - 0.5);
    const double start = from + 0.25 + slack * random_.Uniform();
    return {start, std::min(start + width, to - 0.1), sill, top};
  }

  // A point on a wall: `along` it, and `off` from its middle.
  static Eigen::Vector3d OnWall(bool vertical, double at, double along, double off, double z) {
    return vertical ? Eigen::Vector3d(at + off, along, z) : Eigen::Vector3d(along, at + off, z);
  }

  void BuildWall(bool vertical, double at, double from, double to, const Opening& hole) {
    const SceneMaterial paint = Paint();
    const auto part = [&](double a, double b, double low, double high) {
      AddBox(OnWall(vertical, at, a, -kThin_m / 2, low), OnWall(vertical, at, b, kThin_m / 2, high),
             paint, true);
    };
    if (hole.to_m <= hole.from_m) return part(from, to, 0, kWalls_m);
    part(from, hole.from_m, 0, kWalls_m);
    part(hole.to_m, to, 0, kWalls_m);
    part(hole.from_m, hole.to_m, 0, hole.sill_m);
    part(hole.from_m, hole.to_m, hole.top_m, kWalls_m);
    if (hole.sill_m == 0) AddDoorLeaf(vertical, at, hole);
  }

  // An open door, mostly: across the wall, white like it.
  void AddDoorLeaf(bool vertical, double at, const Opening& hole) {
    if (random_.Uniform() < 0.3) return;
    const double side = random_.Uniform() < 0.5 ? 1 : -1;
    const double hinge = random_.Uniform() < 0.5 ? hole.from_m - 0.02 : hole.to_m + 0.02;
    const double near = side * kThin_m / 2;
    const double far = near + side * kDoorWidth_m;
    SceneMaterial white = {.albedo = random_.Uniform(0.6, 0.85), .gloss = 0.03};
    AddBox(OnWall(vertical, at, hinge - 0.02, std::min(near, far), 0.01),
           OnWall(vertical, at, hinge + 0.02, std::max(near, far), kDoorHeight_m), white, false);
  }

  // A bright pane, its frame, and sometimes curtains.
  void AddWindow(bool vertical, double at, const Opening& hole, int room, double inward) {
    SceneLight light;
    light.is_window = true;
    light.room = room;
    const double area = (hole.to_m - hole.from_m) * (hole.top_m - hole.sill_m);
    light.power = random_.Uniform(1.2, 2.4) * area;
    light.at =
        OnWall(vertical, at, 0.5 * (hole.from_m + hole.to_m), 0, 0.5 * (hole.sill_m + hole.top_m));
    light.facing = OnWall(vertical, 0, 0, inward, 0);
    const SceneMaterial view = {.albedo = 0.04,
                                .contrast = 0.6,
                                .period_m = 0.4,
                                .gloss = 0.04,
                                .glow = random_.Uniform(8, 16),
                                .light = static_cast<int>(scene().lights.size()),
                                .pattern = ScenePattern::kNoise,
                                .seed = random_.Next()};
    scene().lights.push_back(light);
    AddBox(OnWall(vertical, at, hole.from_m, -0.05, hole.sill_m),
           OnWall(vertical, at, hole.to_m, -0.03, hole.top_m), view, true);
    const SceneMaterial frame = {.albedo = 0.8};
    const double middle = 0.5 * (hole.from_m + hole.to_m);
    AddBox(OnWall(vertical, at, middle - 0.03, -0.03, hole.sill_m),
           OnWall(vertical, at, middle + 0.03, 0.02, hole.top_m), frame, false);
    if (random_.Uniform() < 0.5) AddCurtains(vertical, at, hole, inward);
  }

  void AddCurtains(bool vertical, double at, const Opening& hole, double inward) {
    const SceneMaterial cloth = {.albedo = random_.Uniform(0.3, 0.8),
                                 .contrast = 0.25,
                                 .period_m = 0.06,
                                 .pattern = ScenePattern::kStripes,
                                 .seed = random_.Next()};
    const double near = inward * 0.08;
    const double far = inward * 0.14;
    const auto hang = [&](double a, double b) {
      AddBox(OnWall(vertical, at, a, std::min(near, far), 0.1),
             OnWall(vertical, at, b, std::max(near, far), 2.35), cloth, false);
    };
    hang(hole.from_m - 0.2, hole.from_m + 0.12);
    hang(hole.to_m - 0.12, hole.to_m + 0.2);
  }

  // Along the wall of the stairs' room with space for the most steps.
  void AddStairs() {
    const SceneRoom& room = scene().rooms[stairs_room_];
    const Eigen::Vector2d size = room.high - room.low;
    const bool along_x = size.x() >= size.y();
    const double length = along_x ? size.x() : size.y();
    flat_.steps = std::min(kStairSteps, static_cast<int>((length - 0.9) / kStepRun_m));
    const Eigen::Vector2d along = along_x ? Eigen::Vector2d::UnitX() : Eigen::Vector2d::UnitY();
    const Eigen::Vector2d across = along_x ? Eigen::Vector2d::UnitY() : Eigen::Vector2d::UnitX();
    const Eigen::Vector2d corner = (along_x ? room.low.y() : room.low.x()) * across +
                                   (along_x ? room.high.x() : room.high.y()) * along;
    const SceneMaterial wood = {.albedo = random_.Uniform(0.2, 0.6),
                                .contrast = 0.2,
                                .period_m = 0.15,
                                .pattern = ScenePattern::kStripes,
                                .seed = random_.Next()};
    for (int step = 0; step < flat_.steps; ++step) {
      const Eigen::Vector2d far = corner - (flat_.steps - 1 - step) * kStepRun_m * along;
      const Eigen::Vector2d near = far - kStepRun_m * along + kStairsWidth_m * across;
      const Eigen::Vector2d low = near.cwiseMin(far);
      const Eigen::Vector2d high = near.cwiseMax(far);
      AddBox({low.x(), low.y(), 0}, {high.x(), high.y(), (step + 1) * kFlatStepRise_m}, wood,
             false);
    }
    flat_.stairs_step = kStepRun_m * along;
    flat_.stairs_foot =
        corner - (flat_.steps + 0.5) * kStepRun_m * along + 0.5 * kStairsWidth_m * across;
  }

  void Furnish(int room) {
    std::vector<FreeCircle> kept_free;
    for (const FlatDoor& door : flat_.doors) {
      if (door.rooms[0] == room || door.rooms[1] == room) {
        kept_free.push_back({door.at, kDoorFree_m});
      }
    }
    if (room == stairs_room_) {
      for (int step = 0; step <= flat_.steps; ++step) {
        kept_free.push_back({flat_.stairs_foot + step * flat_.stairs_step, 0.5 * kStairsWidth_m});
      }
    }
    FurnishRoom(scene(), room, options_.furniture, kept_free, random_);
  }

  const FlatOptions& options_;
  Random random_;
  Flat flat_;
  std::vector<double> x_;  // lines between the rooms
  std::vector<double> y_;
  int stairs_room_ = 0;
};

}  // namespace

void FlatOptions::Check() const {
  CheckFields("flat", *this);
  if (max_side_m < min_side_m) {
    throw MapError(ErrorCode::kBadOptions, "flat.max_side_m is " + std::to_string(max_side_m) +
                                               "; it must be at least flat.min_side_m, " +
                                               std::to_string(min_side_m));
  }
}

Flat MakeFlat(const FlatOptions& options) {
  options.Check();
  return FlatMaker(options).Make();
}

std::vector<FlatPlace> DrawFlatPlaces(const Flat& flat, int per_room, double height_m,
                                      double clearance_m, uint64_t seed) {
  constexpr int kTries = 200;
  constexpr double kUneven_m = 0.03;
  Random random(seed);
  std::vector<FlatPlace> places;
  const auto add = [&](FlatPlaceKind kind, const Eigen::Vector2d& at, double floor_m) {
    places.push_back({kind, {at.x(), at.y(), floor_m + height_m + kUneven_m * random.Normal()}});
  };
  for (const SceneRoom& room : flat.scene.rooms) {
    int found = 0;
    for (int i = 0; i < kTries && found < per_room; ++i) {
      const Eigen::Vector2d at(random.Uniform(room.low.x(), room.high.x()),
                               random.Uniform(room.low.y(), room.high.y()));
      if (!IsClear(flat.scene, at, clearance_m, 0.1, height_m + 0.2)) continue;
      add(FlatPlaceKind::kRoom, at, 0);
      ++found;
    }
  }
  for (const FlatDoor& door : flat.doors) add(FlatPlaceKind::kDoorway, door.at, 0);
  for (int step = 1; step <= flat.steps; step += 2) {
    add(FlatPlaceKind::kStairs, flat.stairs_foot + step * flat.stairs_step, step * kFlatStepRise_m);
  }
  return places;
}

SceneLighting DrawFlatLighting(const Flat& flat, uint64_t seed) {
  Random random(seed);
  constexpr double kDays[] = {1, 0.35, 0.02};
  const double day = kDays[random.Below(3)];
  const bool dark = day < 0.1;
  SceneLighting lighting;
  for (const SceneLight& light : flat.scene.lights) {
    const bool on = random.Uniform() < (dark ? 0.8 : 0.4);
    lighting.push_back(light.is_window ? day : on ? 1.0 : 0.0);
  }
  return lighting;
}

}  // namespace waystone
