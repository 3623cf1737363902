// SPDX-License-Identifier: Apache-2.0
#include "world/world.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <optional>

#include "core/base/check.h"
#include "core/base/error.h"
#include "core/base/random.h"
#include "world/posters.h"
#include "world/texture.h"

namespace waystone {
namespace {

constexpr uint64_t kTextureSeed = 0x7465787475ULL;
constexpr uint64_t kBareSeed = 0x62617265ULL;
constexpr uint64_t kStoreySeed = 0x73746F726579ULL;
constexpr double kMaxTexels = 1e9 * 3.0 / 4.0;  // with their mip maps: a gigabyte
// A surface seen at a flat angle is sampled this often along the long side of a pixel's footprint,
// at most; beyond that it blurs.
constexpr float kMaxTaps = 6.0F;
// A footprint up to this much longer than wide is taken as round.
constexpr float kTapStretch = 1.5F;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

cv::Size SizeInTexels(const Eigen::Vector2d& size_m, double texel_m) {
  const auto texels = [&](double metres) {
    return std::max(1, static_cast<int>(std::lround(metres / texel_m)));
  };
  return {texels(size_m.x()), texels(size_m.y())};
}

TextureStyle StyleOf(const WorldPlane& plane, const WorldFace& face, const WorldOptions& options) {
  if (plane.kind == SurfaceKind::kFloor) return TextureStyle::kFloor;
  if (plane.kind != SurfaceKind::kWall) return TextureStyle::kCeiling;
  Random random(MixSeeds(MixSeeds(options.seed, kBareSeed), static_cast<uint64_t>(face.id)));
  return random.Uniform() < options.bare_walls ? TextureStyle::kBareWall : TextureStyle::kWall;
}

void PastePoster(const WorldPoster& poster, const WorldOptions& options, cv::Mat& wall) {
  const cv::Size size = SizeInTexels(poster.size_m, options.texel_m);
  const cv::Mat picture = DrawTexture({.style = TextureStyle::kPoster,
                                       .size_px = size,
                                       .texel_m = options.texel_m,
                                       .richness = options.texture_richness,
                                       .seed = poster.picture});
  const cv::Point at(static_cast<int>(std::lround(poster.top_left_m.x() / options.texel_m)),
                     static_cast<int>(std::lround(poster.top_left_m.y() / options.texel_m)));
  const cv::Rect visible = cv::Rect(at, size) & cv::Rect({0, 0}, wall.size());
  if (!visible.empty()) picture(visible - at).copyTo(wall(visible));
}

cv::Mat DrawFace(const WorldFace& face, TextureStyle style, const WorldOptions& options,
                 const std::vector<WorldPoster>& posters) {
  const uint64_t seed =
      MixSeeds(MixSeeds(SeedOfStorey(options), kTextureSeed), static_cast<uint64_t>(face.id));
  cv::Mat texture = DrawTexture({.style = style,
                                 .size_px = SizeInTexels(face.size_m, options.texel_m),
                                 .texel_m = options.texel_m,
                                 .richness = options.texture_richness,
                                 .trim = options.trim,
                                 .seed = seed});
  for (const WorldPoster& poster : posters) {
    if (poster.face == face.id) PastePoster(poster, options, texture);
  }
  return texture;
}

void CheckMemory(const Geometry& geometry, const WorldOptions& options) {
  double texels = 0.0;
  for (const WorldFace& face : geometry.faces) {
    texels += face.size_m.prod() / (options.texel_m * options.texel_m);
  }
  if (texels <= kMaxTexels) return;
  throw MapError(ErrorCode::kBadOptions,
                 "the world's textures would take " + std::to_string(texels / 1e6) +
                     " million texels of at most " + std::to_string(kMaxTexels / 1e6) +
                     "; raise texel_m or draw a smaller plan");
}

// log2 to within 0.09, which is invisible when mixing mip levels.
float RoughLog2(float value) {
  const auto bits = std::bit_cast<uint32_t>(value);
  const auto exponent = static_cast<float>(static_cast<int>(bits >> 23) - 127);
  const float mantissa = std::bit_cast<float>((bits & 0x007FFFFFU) | 0x3F800000U);
  return exponent + mantissa - 1.0F;
}

// The distances at which a ray crosses the grid lines of one axis.
struct AxisWalk {
  int cell = 0;
  int step = 1;
  double next_t = kInfinity;
  double delta_t = kInfinity;

  AxisWalk(double origin, double direction, double cell_m) {
    cell = static_cast<int>(origin / cell_m);
    step = direction < 0.0 ? -1 : 1;
    if (direction == 0.0) return;
    const double line = (cell + (direction > 0.0 ? 1 : 0)) * cell_m;
    next_t = (line - origin) / direction;
    delta_t = cell_m / std::abs(direction);
  }
};

}  // namespace

struct World::Textures {
  std::vector<std::optional<MipMap>> of_face;
};

uint64_t SeedOfStorey(const WorldOptions& options) {
  if (options.storey == 0) return options.seed;
  return MixSeeds(MixSeeds(options.seed, kStoreySeed), static_cast<uint64_t>(options.storey));
}

void WorldOptions::Check() const { CheckFields("world", *this); }

World::World(const FloorPlan& plan, const WorldOptions& options) : plan_(plan), options_(options) {
  options_.Check();
  geometry_ = BuildGeometry(plan_);
  CheckMemory(geometry_, options_);
  posters_ = HangPosters(geometry_, plan_.size, options_);
  auto textures = std::make_shared<Textures>();
  textures->of_face.resize(geometry_.faces.size());
  tbb::parallel_for(size_t{0}, geometry_.faces.size(), [&](size_t i) {
    const WorldFace& face = geometry_.faces[i];
    const TextureStyle style = StyleOf(PlaneById(face.plane), face, options_);
    textures->of_face[i].emplace(DrawFace(face, style, options_, posters_));
  });
  textures_ = textures;
}

const WorldPlane& World::PlaneById(int id) const {
  WS_CHECK(id >= 1 && id <= static_cast<int>(planes().size()), "no plane " + std::to_string(id));
  return planes()[static_cast<size_t>(id - 1)];
}

const WorldFace& World::FaceById(int id) const {
  WS_CHECK(id >= 1 && id <= static_cast<int>(faces().size()), "no face " + std::to_string(id));
  return faces()[static_cast<size_t>(id - 1)];
}

bool World::IsInside(const Eigen::Vector3d& point) const {
  const int column = static_cast<int>(std::floor(point.x() / plan_.size.cell_m));
  const int row = plan_.rows - 1 - static_cast<int>(std::floor(point.y() / plan_.size.cell_m));
  if (!plan_.IsOpen(column, row)) return false;
  const double ceiling =
      plan_.IsDoor(column, row) ? plan_.size.door_height_m : plan_.size.wall_height_m;
  return point.z() > 0.0 && point.z() < ceiling;
}

RayHit World::Cast(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction) const {
  AxisWalk x(origin.x(), direction.x(), geometry_.cell_m);
  AxisWalk y(origin.y(), direction.y(), geometry_.cell_m);
  const CellFaces* cell =
      &geometry_.cells[static_cast<size_t>(y.cell) * geometry_.columns + x.cell];
  const std::ptrdiff_t row_step = y.step * geometry_.columns;
  const size_t x_side = x.step > 0 ? 0 : 2;
  const size_t y_side = y.step > 0 ? 1 : 3;
  while (true) {
    const bool x_first = x.next_t < y.next_t;
    AxisWalk& axis = x_first ? x : y;
    const double height = origin.z() + axis.next_t * direction.z();
    if (height < 0.0) return {1, -origin.z() / direction.z()};
    if (height > cell->ceiling_m) {
      return {cell->top_face, (cell->ceiling_m - origin.z()) / direction.z()};
    }
    const CellFaces* next = cell + (x_first ? x.step : row_step);
    if (height > next->ceiling_m) {
      return {cell->side_faces[x_first ? x_side : y_side], axis.next_t};
    }
    cell = next;
    axis.next_t += axis.delta_t;
  }
}

float World::Shade(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction,
                   const RayHit& hit, double cone_rad) const {
  const WorldFace& face = geometry_.faces[static_cast<size_t>(hit.face - 1)];
  const WorldPlane& plane = geometry_.planes[static_cast<size_t>(face.plane - 1)];
  const MipMap& texture = *textures_->of_face[static_cast<size_t>(hit.face - 1)];
  const auto texels = static_cast<float>(1.0 / options_.texel_m);
  const Eigen::Vector3d offset = origin + hit.t * direction - face.origin;
  const float u = static_cast<float>(offset.dot(plane.u_axis)) * texels;
  const float v = static_cast<float>(offset.dot(plane.v_axis)) * texels;

  // The cone's footprint is an ellipse, longer by 1 / cos along the ray's shadow on the plane.
  const auto along_u = static_cast<float>(direction.dot(plane.u_axis));
  const auto along_v = static_cast<float>(direction.dot(plane.v_axis));
  const float cosine = std::abs(static_cast<float>(direction.dot(plane.normal)));
  const float minor = static_cast<float>(hit.t * cone_rad) * texels;
  const float stretch = 1.0F / std::max(cosine, 1e-3F);
  const int taps = 1 + static_cast<int>(std::min(stretch / kTapStretch, kMaxTaps - 1.0F));
  const float level = RoughLog2(minor * stretch / static_cast<float>(taps));
  if (taps == 1) return texture.Sample(u, v, level);
  const float length = std::sqrt(along_u * along_u + along_v * along_v);
  const float step = minor * stretch / (static_cast<float>(taps) * length);
  float sum = 0.0F;
  for (int i = 0; i < taps; ++i) {
    const float at = (static_cast<float>(i) - 0.5F * static_cast<float>(taps - 1)) * step;
    sum += texture.Sample(u + at * along_u, v + at * along_v, level);
  }
  return sum / static_cast<float>(taps);
}

}  // namespace waystone
