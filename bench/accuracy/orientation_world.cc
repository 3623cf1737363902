// SPDX-License-Identifier: Apache-2.0
#include "bench/accuracy/orientation_world.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <opencv2/imgcodecs.hpp>
#include <optional>

#include "core/base/check.h"
#include "core/base/random.h"
#include "world/texture.h"

namespace waystone::bench {
namespace {

// Corridors are three cells wide and run around a block of rooms.
struct Shape {
  const char* name;
  int columns;
  int rows;
  int room_first;  // columns of the room's two doors
  int room_last;
  bool mirrored;  // bends go left instead of right
  double bare_walls;
  uint64_t seed;
};

constexpr std::array<Shape, 3> kShapes{{
    {"long", 46, 24, 12, 20, false, 0.1, 11},
    {"square", 34, 32, 10, 17, true, 0.2, 12},
    {"deep", 38, 28, 15, 25, false, 0.0, 13},
}};

// Rows of floor in the room, and the trajectory's corners in it.
constexpr int kRoomTop = 5;
constexpr int kRoomBottom = 11;
constexpr double kRoomRow = 8.5;
constexpr double kAside = 70 * std::numbers::pi / 180;
constexpr double kAlong = 10 * std::numbers::pi / 180;  // off the axis, where a corridor begins

std::string PlanText(const Shape& shape) {
  std::vector<std::string> lines(shape.rows, std::string(shape.columns, '#'));
  const auto carve = [&](int left, int top, int right, int bottom, char what) {
    for (int row = top; row <= bottom; ++row) {
      for (int column = left; column <= right; ++column) lines[row][column] = what;
    }
  };
  const int right = shape.columns - 2;
  const int bottom = shape.rows - 2;
  carve(1, 1, right, 3, '.');
  carve(1, bottom - 2, right, bottom, '.');
  carve(1, 1, 3, bottom, '.');
  carve(right - 2, 1, right, bottom, '.');
  carve(shape.room_first - 2, kRoomTop, shape.room_last + 2, kRoomBottom, '.');
  for (const int door : {shape.room_first, shape.room_last}) carve(door, 4, door + 1, 4, 'D');
  std::string text;
  for (std::string& line : lines) {
    if (shape.mirrored) std::ranges::reverse(line);
    text += line + "\n";
  }
  return text;
}

// Along the top corridor, through the room, around, and along the top corridor once more.
std::vector<Eigen::Vector2d> Corners(const Shape& shape) {
  const double right = shape.columns - 2.5;
  const double bottom = shape.rows - 2.5;
  const double in = shape.room_first + 1;
  const double out = shape.room_last + 1;
  std::vector<Eigen::Vector2d> trajectory{
      {4.5, 2.5},   {in, 2.5},       {in, kRoomRow}, {out, kRoomRow}, {out, 2.5},
      {right, 2.5}, {right, bottom}, {2.5, bottom},  {2.5, 2.5},      {in - 1.5, 2.5}};
  if (shape.mirrored) {
    for (Eigen::Vector2d& corner : trajectory) corner.x() = shape.columns - corner.x();
  }
  return trajectory;
}

Eigen::Vector2d OnGround(const FloorPlan& plan, const Eigen::Vector2d& corner) {
  return plan.size.cell_m * Eigen::Vector2d(corner.x(), plan.rows - corner.y());
}

Eigen::Vector2d PointOf(const Walk& walk, int frame) {
  return walk.frames[frame].world_from_camera.translation().head<2>();
}

// The frame after `from` at which the trajectory is nearest to a point, before it returns there.
int NearestFrame(const Walk& walk, const Eigen::Vector2d& point, int from) {
  int best = from;
  const double radius_m = 1.0;
  for (int i = from; i < static_cast<int>(walk.frames.size()); ++i) {
    const double distance = (PointOf(walk, i) - point).norm();
    const double least = (PointOf(walk, best) - point).norm();
    if (distance < least) best = i;
    if (least < radius_m && distance > 2 * radius_m) break;
  }
  return best;
}

// Turns the camera aside and back over a stretch, both within a quarter of it.
void LookAside(Walk& walk, const TrueStretch& stretch) {
  const double length = stretch.last - stretch.first;
  for (int i = stretch.first; i <= stretch.last; ++i) {
    const double at = (i - stretch.first) / length;
    const double share = std::clamp(4 * std::min(at, 1 - at), 0.0, 1.0);
    const double smooth = share * share * (3 - 2 * share);
    Eigen::Isometry3d& pose = walk.frames[i].world_from_camera;
    pose.linear() = Eigen::AngleAxisd(kAside * smooth, Eigen::Vector3d::UnitZ()) * pose.linear();
  }
}

// Frames of a leg that look along it, in stretches.
void AddCorridors(const Walk& walk, int first, int last, std::vector<TrueStretch>& corridors) {
  const Eigen::Vector2d leg = (PointOf(walk, last) - PointOf(walk, first)).normalized();
  const Eigen::Vector2d axis = leg.array().round();
  bool open = false;
  for (int i = first; i <= last; ++i) {
    const Eigen::Vector2d gaze = walk.frames[i].world_from_camera.linear().col(2).head<2>();
    const bool along = gaze.normalized().dot(axis) >= std::cos(kAlong);
    if (along && !open) corridors.push_back({i, i});
    if (along) corridors.back().last = i;
    open = along;
  }
}

double TrajectoryLength(const std::vector<Eigen::Vector2d>& corners, double cell_m) {
  double length = 0;
  for (size_t i = 1; i < corners.size(); ++i) length += (corners[i] - corners[i - 1]).norm();
  return cell_m * length;
}

// Stripes along no axis: where a point lies between them, 0 or 1.
double Stripe(const Eigen::Vector3d& point, int face) {
  Random random(MixSeeds(7, static_cast<uint64_t>(face)));
  Eigen::Vector3d across(random.Uniform(0.4, 1), random.Uniform(0.4, 1), random.Uniform(0.4, 1));
  if (random.Uniform() < 0.5) across.x() *= -1;
  if (random.Uniform() < 0.5) across.z() *= -1;
  constexpr double kWidthM = 0.35;
  const double at = across.normalized().dot(point) / kWidthM;
  return std::fmod(std::floor(at), 2.0) == 0 ? 0 : 1;
}

// Paints the stripes on what a picture shows of the skewed part.
void PaintStripes(const OrientationWorld& made, const Camera& camera,
                  const Eigen::Isometry3d& world_from_camera, RenderedFrame& frame) {
  for (int y = 0; y < frame.grey.rows; ++y) {
    for (int x = 0; x < frame.grey.cols; ++x) {
      const Eigen::Vector3d ray = Unproject(camera, {x, y});
      const Eigen::Vector3d point =
          world_from_camera * Eigen::Vector3d(ray * (frame.depth.at<float>(y, x) / ray.z()));
      const Eigen::Array2d ground = point.head<2>().array();
      if ((ground < made.skew_low.array()).any() || (ground > made.skew_high.array()).any())
        continue;
      auto& grey = frame.grey.at<unsigned char>(y, x);
      const double stripe = Stripe(point, frame.face_ids.at<uint16_t>(y, x));
      grey = cv::saturate_cast<unsigned char>(0.35 * grey + 130 * stripe + 15);
    }
  }
}

}  // namespace

OrientationWorld MakeOrientationWorld(int building, int frames, bool trim) {
  WS_CHECK(building >= 0 && building < static_cast<int>(kShapes.size()), "no such building");
  const Shape& shape = kShapes[building];
  const FloorPlan plan = ParseFloorPlan(PlanText(shape));
  OrientationWorld made;
  made.name = shape.name;
  WorldOptions look;
  look.seed = shape.seed;
  look.texel_m = 0.006;
  look.bare_walls = shape.bare_walls;
  look.trim = trim;
  made.world = std::make_shared<const World>(plan, look);
  const std::vector<Eigen::Vector2d> corners = Corners(shape);
  WalkOptions walk;
  walk.gaze_rad = 0;
  walk.sway = 0.5;
  walk.clearance_m = 0.3;
  walk.step_m = TrajectoryLength(corners, plan.size.cell_m) / frames;
  walk.turn_rad = std::min(1.0, 0.05 * 1000 / frames);
  made.walk = WalkThrough(plan, corners, walk);
  std::vector<int> at{0};
  for (size_t i = 1; i < corners.size(); ++i) {
    at.push_back(NearestFrame(made.walk, OnGround(plan, corners[i]), at.back()));
  }
  for (size_t i = 1; i + 1 < corners.size(); ++i) {
    const Eigen::Vector2d in = corners[i] - corners[i - 1];
    const Eigen::Vector2d out = corners[i + 1] - corners[i];
    // Rows count southwards, so the sense is reversed.
    made.turns.push_back({at[i], in.x() * out.y() - in.y() * out.x() < 0 ? 1 : -1});
  }
  constexpr int kRightLeg = 5;
  constexpr int kBottomLeg = 6;
  const auto part = [&](int leg, double from, double to) {
    const int length = at[leg + 1] - at[leg];
    return TrueStretch{at[leg] + static_cast<int>(from * length),
                       at[leg] + static_cast<int>(to * length)};
  };
  made.looked_aside = part(kBottomLeg, 0.4, 0.75);
  made.skewed = part(kRightLeg, 0.35, 0.65);
  const Eigen::Vector2d one = PointOf(made.walk, made.skewed.first);
  const Eigen::Vector2d other = PointOf(made.walk, made.skewed.last);
  const Eigen::Vector2d side(2, 2);  // m, past the corridor's walls and the stretch's ends
  made.skew_low = one.cwiseMin(other) - side;
  made.skew_high = one.cwiseMax(other) + side;
  LookAside(made.walk, made.looked_aside);
  // All legs but those through the room.
  for (const int leg : {0, 4, 5, 6, 7, 8})
    AddCorridors(made.walk, at[leg], at[leg + 1], made.corridors);
  return made;
}

std::vector<std::vector<unsigned char>> RenderRig(const OrientationWorld& made, const Rig& rig,
                                                  const std::vector<Renderer>& renderers,
                                                  int frame) {
  std::vector<std::vector<unsigned char>> files;
  for (size_t c = 0; c < rig.cameras.size(); ++c) {
    RenderOptions options;
    options.lens_blur_px = 0.6;
    options.noise_sigma = 4;
    options.noise_seed = static_cast<uint64_t>(frame) * rig.cameras.size() + c;
    options.depth = true;
    const Eigen::Isometry3d pose =
        made.walk.frames[frame].world_from_camera * rig.cameras[c].rig_from_camera;
    RenderedFrame rendered = renderers[c].Render(*made.world, pose, options);
    PaintStripes(made, rig.cameras[c].camera, pose, rendered);
    cv::imencode(".jpg", rendered.grey, files.emplace_back());
  }
  return files;
}

double CommonView(const OrientationWorld& made, const Rig& rig, int a, int b, double max_scale) {
  constexpr int kRays = 400;
  constexpr double kSameM = 0.02;
  Random random(5);
  const Eigen::Isometry3d& from = made.walk.frames[a].world_from_camera;
  const Eigen::Isometry3d& to = made.walk.frames[b].world_from_camera;
  int common = 0;
  for (int i = 0; i < kRays; ++i) {
    const RigCamera& camera = rig.cameras[i % rig.cameras.size()];
    const Eigen::Vector2d pixel(random.Uniform(0, camera.camera.width - 1),
                                random.Uniform(0, camera.camera.height - 1));
    const Eigen::Vector3d ray = from.linear() * camera.rig_from_camera.linear() *
                                Unproject(camera.camera, pixel).normalized();
    const double far_a = made.world->Cast(from.translation(), ray).t;
    const Eigen::Vector3d point = from.translation() + far_a * ray;
    const Eigen::Vector3d back = point - to.translation();
    const double far_b = back.norm();
    if (std::max(far_a / far_b, far_b / far_a) > max_scale) continue;
    if (made.world->Cast(to.translation(), back / far_b).t < far_b - kSameM) continue;
    common += std::ranges::any_of(rig.cameras, [&](const RigCamera& seen) {
      const Eigen::Vector3d x = (to * seen.rig_from_camera).linear().transpose() * back;
      const std::optional<Eigen::Vector2d> p = Project(seen.camera, x);
      return p && p->x() >= 0 && p->y() >= 0 && p->x() < seen.camera.width &&
             p->y() < seen.camera.height;
    });
  }
  return static_cast<double>(common) / kRays;
}

}  // namespace waystone::bench
