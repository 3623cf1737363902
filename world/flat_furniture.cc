// SPDX-License-Identifier: Apache-2.0
#include "world/flat_furniture.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace waystone {
namespace {

constexpr int kAttempts = 12;  // of each piece, to find a place
constexpr double kPi2 = std::numbers::pi / 2;

// A kind of furniture; sizes are drawn between low and high.
struct FurnitureKind {
  double width_low, width_high;  // along the wall
  double depth_low, depth_high;
  double height_low, height_high;
  bool at_wall;
  bool carries;  // small things on its top
  ScenePattern pattern;
  double period_m;
  double contrast;
  double gloss;
};

constexpr FurnitureKind kFurniture[] = {
    {0.8, 1.8, 0.55, 0.62, 1.9, 2.2, true, false, ScenePattern::kPlain, 0.5, 0, 0.05},   // wardrobe
    {0.6, 1.4, 0.25, 0.35, 1.2, 2.0, true, false, ScenePattern::kBooks, 0.05, 0.8, 0},   // shelf
    {1.2, 2.2, 0.58, 0.62, 0.88, 0.92, true, true, ScenePattern::kPlain, 0.5, 0, 0.1},   // counter
    {1.4, 2.0, 0.8, 0.95, 0.75, 0.9, true, false, ScenePattern::kNoise, 0.3, 0.2, 0},    // sofa
    {0.9, 1.6, 1.9, 2.0, 0.45, 0.55, true, false, ScenePattern::kNoise, 0.4, 0.3, 0},    // bed
    {0.8, 1.5, 0.4, 0.5, 0.7, 0.95, true, true, ScenePattern::kStripes, 0.4, 0.1, 0},    // chest
    {0.8, 1.4, 0.7, 0.9, 0.72, 0.76, false, true, ScenePattern::kPlain, 0.5, 0, 0.1},    // table
    {0.4, 0.5, 0.4, 0.5, 0.8, 1.1, false, false, ScenePattern::kStripes, 0.09, 0.5, 0},  // chair
    {0.3, 0.6, 0.3, 0.5, 0.9, 1.7, false, false, ScenePattern::kNoise, 0.12, 0.9, 0},    // plant
    {0.5, 0.7, 0.55, 0.65, 1.5, 1.9, true, false, ScenePattern::kPlain, 0.5, 0, 0.15},   // fridge
};

class Furnisher {
 public:
  Furnisher(RoomScene& scene, int room, const std::vector<FreeCircle>& kept_free, Random& random)
      : scene_(scene), room_(scene.rooms[room]), at_(room), free_(kept_free), random_(random) {}

  void Furnish(int pieces) {
    for (int i = 0; i < pieces; ++i) {
      const FurnitureKind& piece =
          kFurniture[random_.Below(static_cast<int>(std::size(kFurniture)))];
      for (int attempt = 0; attempt < kAttempts; ++attempt) {
        if (TryPiece(piece)) break;
      }
    }
    const int pictures = random_.Below(4);
    for (int i = 0; i < pictures; ++i) HangPicture(random_.Uniform() < 0.25);
    HangLamp();
  }

 private:
  double Draw(double low, double high) { return random_.Uniform(low, high); }

  // Against a wall: its middle `along` the wall, `off` from it, turned by quarters.
  void PutAtWall(int wall, double along, double off, SceneBox& box) const {
    const bool vertical = wall % 2 == 1;  // east or west
    const Eigen::Vector2d& low = room_.low;
    const Eigen::Vector2d& high = room_.high;
    const double side = wall == 0   ? low.y() + off
                        : wall == 2 ? high.y() - off
                        : wall == 1 ? high.x() - off
                                    : low.x() + off;
    const double on =
        vertical ? std::lerp(low.y(), high.y(), along) : std::lerp(low.x(), high.x(), along);
    box.centre.head<2>() = vertical ? Eigen::Vector2d(side, on) : Eigen::Vector2d(on, side);
    box.cosine = vertical ? 0 : 1;
    box.sine = vertical ? 1 : 0;
  }

  bool TryPiece(const FurnitureKind& piece) {
    SceneBox box;
    box.half_m = 0.5 * Eigen::Vector3d(Draw(piece.width_low, piece.width_high),
                                       Draw(piece.depth_low, piece.depth_high),
                                       Draw(piece.height_low, piece.height_high));
    if (piece.at_wall) {
      PutAtWall(random_.Below(4), Draw(0, 1), box.half_m.y() + 0.01, box);
    } else {
      box.centre.head<2>() =
          Eigen::Vector2d(Draw(room_.low.x(), room_.high.x()), Draw(room_.low.y(), room_.high.y()));
      const double yaw = Draw(0, kPi2);
      box.cosine = std::cos(yaw);
      box.sine = std::sin(yaw);
    }
    box.centre.z() = box.half_m.z();
    if (!Fits(box)) return false;
    const bool white = random_.Uniform() < 0.4;
    box.material = {.albedo = white ? Draw(0.65, 0.85) : Draw(0.08, 0.6),
                    .contrast = piece.contrast,
                    .period_m = piece.period_m,
                    .gloss = piece.gloss,
                    .pattern = piece.pattern,
                    .seed = random_.Next()};
    scene_.boxes.push_back(box);
    if (piece.carries) Carry(box);
    return true;
  }

  // Small things on top.
  void Carry(const SceneBox& under) {
    const int count = 1 + random_.Below(4);
    for (int i = 0; i < count; ++i) {
      SceneBox box;
      box.half_m = 0.5 * Eigen::Vector3d(Draw(0.06, 0.35), Draw(0.06, 0.3), Draw(0.08, 0.45));
      const double x = Draw(-0.8, 0.8) * under.half_m.x();
      const double y = Draw(-0.6, 0.6) * under.half_m.y();
      box.centre = under.centre + Eigen::Vector3d(under.cosine * x - under.sine * y,
                                                  under.sine * x + under.cosine * y,
                                                  under.half_m.z() + box.half_m.z());
      box.cosine = under.cosine;
      box.sine = under.sine;
      box.material = {.albedo = Draw(0.05, 0.85),
                      .contrast = Draw(0, 0.6),
                      .period_m = 0.08,
                      .pattern = ScenePattern::kNoise,
                      .seed = random_.Next()};
      scene_.boxes.push_back(box);
    }
  }

  bool Fits(const SceneBox& box) const {
    const double radius = box.half_m.head<2>().norm();
    const double in_x = std::abs(box.cosine) * box.half_m.x() + std::abs(box.sine) * box.half_m.y();
    const double in_y = std::abs(box.sine) * box.half_m.x() + std::abs(box.cosine) * box.half_m.y();
    if (box.centre.x() - in_x < room_.low.x() || box.centre.x() + in_x > room_.high.x() ||
        box.centre.y() - in_y < room_.low.y() || box.centre.y() + in_y > room_.high.y()) {
      return false;
    }
    for (const FreeCircle& circle : free_) {
      if (Apart(box, circle.at) < circle.radius_m) return false;
    }
    return std::ranges::none_of(scene_.boxes, [&](const SceneBox& other) {
      if (other.is_wall || other.centre.z() - other.half_m.z() > 2 * box.half_m.z()) return false;
      const double apart = (other.centre - box.centre).head<2>().norm();
      return apart < 0.75 * (radius + other.half_m.head<2>().norm());
    });
  }

  static double Apart(const SceneBox& box, const Eigen::Vector2d& point) {
    const Eigen::Vector2d from = point - box.centre.head<2>();
    const Eigen::Vector2d inside(box.cosine * from.x() + box.sine * from.y(),
                                 box.cosine * from.y() - box.sine * from.x());
    return (inside.cwiseAbs() - box.half_m.head<2>()).cwiseMax(0).norm();
  }

  void HangPicture(bool mirror) {
    SceneBox box;
    box.half_m = {0.5 * Draw(0.3, 0.9), 0.012, 0.5 * Draw(0.3, 0.8)};
    PutAtWall(random_.Below(4), Draw(0.15, 0.85), box.half_m.y() + 0.002, box);
    box.centre.z() = Draw(1.4, 1.7);
    for (const FreeCircle& circle : free_) {
      if (Apart(box, circle.at) < circle.radius_m) return;
    }
    box.material = {.albedo = mirror ? 0.05 : Draw(0.2, 0.7),
                    .contrast = 0.8,
                    .period_m = 0.12,
                    .gloss = mirror ? 0.9 : 0.05,
                    .pattern = mirror ? ScenePattern::kPlain : ScenePattern::kNoise,
                    .seed = random_.Next()};
    scene_.boxes.push_back(box);
  }

  void HangLamp() {
    SceneLight light;
    const Eigen::Vector2d middle =
        room_.Middle() + Eigen::Vector2d(Draw(-0.4, 0.4), Draw(-0.4, 0.4));
    const double up = Draw(0.1, 0.6);
    light.at = {middle.x(), middle.y(), room_.height_m - up - 0.15};
    light.power = Draw(0.6, 1.4);
    light.room = at_;
    SceneBox box;
    box.half_m = {Draw(0.08, 0.2), Draw(0.08, 0.2), Draw(0.04, 0.12)};
    box.centre = {middle.x(), middle.y(), room_.height_m - up};
    box.material = {.albedo = 0.7, .glow = 12, .light = static_cast<int>(scene_.lights.size())};
    scene_.boxes.push_back(box);
    scene_.lights.push_back(light);
  }

  RoomScene& scene_;
  const SceneRoom room_;
  int at_;
  const std::vector<FreeCircle>& free_;
  Random& random_;
};

}  // namespace

void FurnishRoom(RoomScene& scene, int room, int pieces, const std::vector<FreeCircle>& kept_free,
                 Random& random) {
  Furnisher(scene, room, kept_free, random).Furnish(pieces);
}

bool IsClear(const RoomScene& scene, const Eigen::Vector2d& at, double radius_m, double low_m,
             double high_m) {
  return std::ranges::none_of(scene.boxes, [&](const SceneBox& box) {
    if (box.centre.z() - box.half_m.z() > high_m || box.centre.z() + box.half_m.z() < low_m) {
      return false;
    }
    const Eigen::Vector2d from = at - box.centre.head<2>();
    const Eigen::Vector2d inside(box.cosine * from.x() + box.sine * from.y(),
                                 box.cosine * from.y() - box.sine * from.x());
    return (inside.cwiseAbs() - box.half_m.head<2>()).cwiseMax(0).norm() < radius_m;
  });
}

}  // namespace waystone
