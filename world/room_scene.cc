// SPDX-License-Identifier: Apache-2.0
#include "world/room_scene.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/check.h"
#include "world/texture.h"

namespace waystone {
namespace {

constexpr double kInfinite = std::numeric_limits<double>::infinity();
constexpr double kTooNear_m = 1e-4;       // where a mirrored ray starts on
constexpr double kAmbientPerPower = 2.4;  // m^2: white rooms reflect light many times
constexpr double kDarkness = 0.015;       // light that comes from anywhere
constexpr double kLampArea = 0.15;        // m2: keeps the light near a lamp finite

// Rotates into the box's frame, removing its yaw.
Eigen::Vector3d IntoBox(const SceneBox& box, const Eigen::Vector3d& v) {
  return {box.cosine * v.x() + box.sine * v.y(), box.cosine * v.y() - box.sine * v.x(), v.z()};
}

Eigen::Vector3d OutOfBox(const SceneBox& box, const Eigen::Vector3d& v) {
  return {box.cosine * v.x() - box.sine * v.y(), box.cosine * v.y() + box.sine * v.x(), v.z()};
}

// Where a ray enters a box, before `limit`.
bool EntersBox(const SceneBox& box, const Eigen::Vector3d& origin, const Eigen::Vector3d& ray,
               double limit, SceneHit& hit) {
  const Eigen::Vector3d from = IntoBox(box, origin - box.centre);
  const Eigen::Vector3d along = IntoBox(box, ray);
  double enter = 0;
  double leave = limit;
  int axis = -1;
  for (int k = 0; k < 3; ++k) {
    if (along[k] == 0) {
      if (std::abs(from[k]) > box.half_m[k]) return false;
      continue;
    }
    const double near = (-std::copysign(box.half_m[k], along[k]) - from[k]) / along[k];
    const double far = (std::copysign(box.half_m[k], along[k]) - from[k]) / along[k];
    if (near > enter) {
      enter = near;
      axis = k;
    }
    leave = std::min(leave, far);
    if (enter >= leave) return false;
  }
  if (axis < 0) return false;  // starts inside
  hit.t = enter;
  hit.axis = axis;
  return true;
}

double NearestDistance(const SceneBox& box, const Eigen::Vector3d& point) {
  const Eigen::Vector3d from = IntoBox(box, point - box.centre).cwiseAbs() - box.half_m;
  return from.cwiseMax(0).norm();
}

double UnitHash(uint64_t seed, int64_t x, int64_t y) {
  const uint64_t bits =
      MixSeeds(MixSeeds(seed, static_cast<uint64_t>(x)), static_cast<uint64_t>(y));
  return static_cast<double>(bits >> 11) * 0x1.0p-52 - 1;  // -1 to 1
}

double SmoothStep(double x) { return x * x * (3 - 2 * x); }

// Random values on a grid of 1, smooth between.
double LatticeNoise(uint64_t seed, double u, double v) {
  const double x = std::floor(u);
  const double y = std::floor(v);
  const auto ix = static_cast<int64_t>(x);
  const auto iy = static_cast<int64_t>(y);
  const double fx = SmoothStep(u - x);
  const double fy = SmoothStep(v - y);
  const double top = std::lerp(UnitHash(seed, ix, iy), UnitHash(seed, ix + 1, iy), fx);
  const double bottom = std::lerp(UnitHash(seed, ix, iy + 1), UnitHash(seed, ix + 1, iy + 1), fx);
  return std::lerp(top, bottom, fy);
}

double BooksAt(uint64_t seed, double u, double v) {
  constexpr double kRowsOfPeriod = 7;  // a shelf's height over a book's width
  const double row = std::floor(v / kRowsOfPeriod);
  const double up = v / kRowsOfPeriod - row;
  if (up < 0.08) return -1;  // the board
  const double tall = 0.7 + 0.2 * UnitHash(seed + 1, static_cast<int64_t>(std::floor(u)),
                                           static_cast<int64_t>(row));
  if (up > tall) return -0.8;
  return UnitHash(seed, static_cast<int64_t>(std::floor(u)), static_cast<int64_t>(row));
}

double TilesAt(uint64_t seed, double u, double v) {
  constexpr double kJoint = 0.04;
  const double x = std::floor(u);
  const double y = std::floor(v);
  if (u - x < kJoint || v - y < kJoint) return -1;
  return 0.3 * UnitHash(seed, static_cast<int64_t>(x), static_cast<int64_t>(y));
}

// -1 to 1, at (u, v) periods.
double PatternAt(const SceneMaterial& material, double u, double v) {
  switch (material.pattern) {
    case ScenePattern::kPlain:
      return 0;
    case ScenePattern::kNoise:
      return 0.65 * LatticeNoise(material.seed, u, v) +
             0.35 * LatticeNoise(material.seed + 1, 2.7 * u, 2.7 * v);
    case ScenePattern::kStripes:
      return UnitHash(material.seed, static_cast<int64_t>(std::floor(u)), 0);
    case ScenePattern::kBooks:
      return BooksAt(material.seed, u, v);
    case ScenePattern::kTiles:
      return TilesAt(material.seed, u, v);
  }
  return 0;
}

}  // namespace

int FindRoom(const RoomScene& scene, const Eigen::Vector2d& point) {
  for (size_t i = 0; i < scene.rooms.size(); ++i) {
    const SceneRoom& room = scene.rooms[i];
    if ((point.array() >= room.low.array()).all() && (point.array() <= room.high.array()).all()) {
      return static_cast<int>(i);
    }
  }
  return -1;
}

bool SeesThrough(const RoomScene& scene, const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
  const double distance = (to - from).norm();
  if (distance == 0) return true;
  const Eigen::Vector3d ray = (to - from) / distance;
  SceneHit hit;
  return std::ranges::none_of(scene.boxes, [&](const SceneBox& box) {
    return box.is_wall && EntersBox(box, from, ray, distance, hit);
  });
}

SceneView::SceneView(const RoomScene& scene, const SceneLighting& lighting,
                     const Eigen::Vector3d& centre)
    : scene_(scene), lighting_(lighting), centre_(centre) {
  WS_CHECK(lighting.size() == scene.lights.size(), "a brightness for each light");
  for (size_t i = 0; i < scene.boxes.size(); ++i) {
    near_.push_back({NearestDistance(scene.boxes[i], centre), static_cast<int>(i)});
  }
  std::ranges::stable_sort(near_, {}, &NearBox::nearest_m);
  ambient_.assign(scene.rooms.size(), kDarkness);
  for (size_t i = 0; i < scene.lights.size(); ++i) {
    const SceneLight& light = scene.lights[i];
    const double area = scene.rooms[light.room].Area();
    ambient_[light.room] += kAmbientPerPower * lighting[i] * light.power / (4 * area);
  }
}

SceneHit SceneView::Cast(const Eigen::Vector3d& ray) const {
  SceneHit hit;
  hit.t = kInfinite;
  for (const NearBox& near : near_) {
    if (near.nearest_m >= hit.t) break;
    if (EntersBox(scene_.boxes[near.box], centre_, ray, hit.t, hit)) hit.box = near.box;
  }
  return hit;
}

double SceneView::Shade(const Eigen::Vector3d& ray, const SceneHit& hit, double cone_rad) const {
  if (hit.box < 0) return 0;
  const SceneBox& box = scene_.boxes[hit.box];
  const Eigen::Vector3d point = centre_ + hit.t * ray;
  const double diffuse = Diffuse(box, point, ray, hit, cone_rad);
  if (box.material.gloss <= 0) return diffuse;
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();
  normal[hit.axis] = -std::copysign(1.0, IntoBox(box, ray)[hit.axis]);
  const double mirrored = Reflected(point, ray, OutOfBox(box, normal), cone_rad);
  return diffuse + box.material.gloss * mirrored;
}

double SceneView::Reflected(const Eigen::Vector3d& point, const Eigen::Vector3d& ray,
                            const Eigen::Vector3d& normal, double cone_rad) const {
  const Eigen::Vector3d bounced = ray - 2 * ray.dot(normal) * normal;
  const Eigen::Vector3d from = point + kTooNear_m * normal;
  SceneHit hit;
  hit.t = kInfinite;
  for (size_t i = 0; i < scene_.boxes.size(); ++i) {
    if (EntersBox(scene_.boxes[i], from, bounced, hit.t, hit)) hit.box = static_cast<int>(i);
  }
  if (hit.box < 0) return 0;
  return Diffuse(scene_.boxes[hit.box], from + hit.t * bounced, bounced, hit, cone_rad);
}

double SceneView::Diffuse(const SceneBox& box, const Eigen::Vector3d& point,
                          const Eigen::Vector3d& ray, const SceneHit& hit, double cone_rad) const {
  const SceneMaterial& material = box.material;
  const Eigen::Vector3d along = IntoBox(box, ray);
  const Eigen::Vector3d inside = IntoBox(box, point - box.centre);
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();
  normal[hit.axis] = -std::copysign(1.0, along[hit.axis]);
  // Patterns run along the horizontal edge and up, on tops and floors along both edges.
  const double u = hit.axis == 0 ? inside.y() : inside.x();
  const double v = hit.axis == 2 ? inside.y() : inside.z();
  const double footprint = hit.t * cone_rad / std::max(0.15, std::abs(along[hit.axis]));
  // Patterns finer than the pixels fade out instead of aliasing.
  const double fade = std::clamp(0.5 * material.period_m / footprint - 0.4, 0.0, 1.0);
  const double pattern =
      PatternAt(material, (u + 17) / material.period_m, (v + 17) / material.period_m);
  const double albedo = material.albedo * (1 + material.contrast * fade * pattern);
  const double glow = material.light >= 0 ? material.glow * lighting_[material.light] *
                                                (1 + material.contrast * fade * pattern)
                                          : 0;
  return glow + (1 - material.gloss) * albedo * LightAt(point, OutOfBox(box, normal));
}

double SceneView::LightAt(const Eigen::Vector3d& point, const Eigen::Vector3d& normal) const {
  const int room = FindRoom(scene_, (point + 0.02 * normal).head<2>());
  if (room < 0) return kDarkness;
  double sum = ambient_[room];
  for (size_t i = 0; i < scene_.lights.size(); ++i) {
    const SceneLight& light = scene_.lights[i];
    if (light.room != room || lighting_[i] <= 0) continue;
    const Eigen::Vector3d towards = light.at - point;
    const double squared = towards.squaredNorm();
    const double distance = std::sqrt(squared);
    double cosine = std::max(0.0, normal.dot(towards) / distance);
    if (light.is_window) cosine *= std::max(0.0, -light.facing.dot(towards) / distance);
    sum += lighting_[i] * light.power * cosine / (squared + kLampArea);
  }
  return sum;
}

}  // namespace waystone
