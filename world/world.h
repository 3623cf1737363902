// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <vector>

#include "core/base/options.h"
#include "world/faces.h"
#include "world/floor_plan.h"

namespace waystone {

struct WorldOptions {
  uint64_t seed = 1;
  double texel_m = 0.004;
  double texture_richness = 1.0;
  double bare_walls = 0.0;
  bool trim = false;
  double poster_probability = 0.4;
  double repeat_poster = 0.0;
  double poster_width_m = 0.8;
  double poster_height_m = 1.1;
  int storey = 0;
  double alike_share = 0.5;

  static constexpr auto Fields(const auto& use) {
    return use(
        OptionField{"seed", &WorldOptions::seed, AnyValue(), "",
                    "Random seed of the whole building."},
        OptionField{
            "texel_m", &WorldOptions::texel_m, Closed(0.001, 0.1), "m",
            "Side of a texel. Finer texels are sharper up close, but memory grows quadratically; "
            "an image 640 px and 60 degrees wide shows 4 mm per pixel at 2.2 m."},
        OptionField{"texture_richness", &WorldOptions::texture_richness, Closed(0, 2), "",
                    "Density of the shapes on walls, floor, ceiling and posters. Higher values "
                    "give more corners; lower values give an emptier, more difficult building."},
        OptionField{"bare_walls", &WorldOptions::bare_walls, Closed(0, 1), "",
                    "Share of the walls that are bare (plain paint with hardly any corners)."},
        OptionField{
            "trim", &WorldOptions::trim, AnyValue(), "",
            "Whether surfaces have trim: skirting board, rail, cornice and door frames on walls, "
            "panels on the ceiling, tiles on the floor. Without it, hardly any lines run along the "
            "building's axes except the edges between surfaces, unlike in most buildings."},
        OptionField{"poster_probability", &WorldOptions::poster_probability, Closed(0, 1), "",
                    "Probability that a full-height stretch of wall gets a poster in addition to "
                    "those of the plan."},
        OptionField{"repeat_poster", &WorldOptions::repeat_poster, Closed(0, 1), "",
                    "Share of these posters that show the same picture. Higher values make more "
                    "places look alike."},
        OptionField{"poster_width_m", &WorldOptions::poster_width_m, Closed(0.1, 5), "m",
                    "Width of a poster."},
        OptionField{"poster_height_m", &WorldOptions::poster_height_m, Closed(0.1, 5), "m",
                    "Height of a poster."},
        OptionField{"storey", &WorldOptions::storey, Closed(0, 1000), "",
                    "Storey of the building: all storeys have the same plan, bare walls and poster "
                    "positions, and share alike_share of the posters' pictures."},
        OptionField{"alike_share", &WorldOptions::alike_share, Closed(0, 1), "",
                    "Share of the posters that are the same on every storey. Higher values make "
                    "storeys harder to tell apart."});
  }
  // Throws MapError(kBadOptions) for a value out of its range.
  void Check() const;
};

// The seed of what is unique to the options' storey: `seed` on storey 0. Pure; thread-safe.
uint64_t SeedOfStorey(const WorldOptions& options);

// A poster lies in the plane of its wall, so it has no plane id of its own.
struct WorldPoster {
  int face = 0;
  uint64_t picture = 0;  // posters of the same picture are the same, texel for texel
  // Its rectangle in the face's (u, v), metres, on whole texels, clipped where the wall ends.
  Eigen::Vector2d top_left_m = Eigen::Vector2d::Zero();
  Eigen::Vector2d size_m = Eigen::Vector2d::Zero();
};

// Where a ray meets the world: x = origin + t * direction.
struct RayHit {
  int face = 0;
  double t = 0.0;
};

// A building made from a plan: planes, faces, their textures. Immutable; all methods are
// thread-safe. Copies share the textures.
class World {
 public:
  // Draws all textures (on TBB's threads; the same bytes on any number of them). Throws
  // MapError(kBadOptions) for options out of range and for plans whose textures would take more
  // than a gigabyte.
  explicit World(const FloorPlan& plan, const WorldOptions& options = {});

  const FloorPlan& plan() const { return plan_; }
  const WorldOptions& options() const { return options_; }
  // planes()[i].id == i + 1, and so for faces().
  const std::vector<WorldPlane>& planes() const { return geometry_.planes; }
  const std::vector<WorldFace>& faces() const { return geometry_.faces; }
  const std::vector<WorldPoster>& posters() const { return posters_; }
  const WorldPlane& PlaneById(int id) const;
  const WorldFace& FaceById(int id) const;

  // Whether a camera can be there: between floor and ceiling (or lintel) of an open cell.
  bool IsInside(const Eigen::Vector3d& point) const;

  // The first surface along a ray that starts inside. `direction` isn't zero, of any length.
  RayHit Cast(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction) const;

  // The grey value, 0 to 255, that a cone along a ray sees where it hits. `cone_rad` is its full
  // angle, `direction` the unit ray, `hit` what Cast gave for it.
  float Shade(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction, const RayHit& hit,
              double cone_rad) const;

 private:
  struct Textures;

  FloorPlan plan_;
  WorldOptions options_;
  Geometry geometry_;
  std::vector<WorldPoster> posters_;
  std::shared_ptr<const Textures> textures_;
};

}  // namespace waystone
