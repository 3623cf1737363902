// SPDX-License-Identifier: Apache-2.0
#include <tbb/parallel_for.h>

#include <numbers>

#include "core/base/random.h"
#include "world/flat.h"
#include "world/walk.h"

namespace waystone {
namespace {

constexpr double kWholeTurn_rad = 2 * std::numbers::pi;

}  // namespace

void FlatTourOptions::Check() const { CheckFields("flat_tour", *this); }

std::vector<FlatPanorama> PhotographFlat(const Flat& flat, const FlatTourOptions& options) {
  options.Check();
  const SceneLighting lighting[] = {DrawFlatLighting(flat, 2 * options.seed),
                                    DrawFlatLighting(flat, 2 * options.seed + 1)};
  Random random(13 * options.seed + 5);
  std::vector<FlatPanorama> panoramas;
  std::vector<FlatCamera> cameras;
  for (const FlatPlace& place : DrawFlatPlaces(flat, options.per_room, options.height_m,
                                               options.clearance_m, 7 * options.seed + 1)) {
    FlatPanorama panorama;
    panorama.place = place;
    const double yaw = random.Uniform(-kWholeTurn_rad / 2, kWholeTurn_rad / 2);
    const double pitch = options.tilt_rad * random.Normal();
    const double roll = options.tilt_rad * random.Normal();
    panorama.world_from_camera = WorldFromCamera(place.at, yaw, pitch, roll);
    panorama.visit = random.Uniform() < options.later_share ? 1 : 0;
    cameras.push_back(options.camera);
    cameras.back().noise_seed = random.Next();
    panoramas.push_back(panorama);
  }
  tbb::parallel_for(size_t{0}, panoramas.size(), [&](size_t i) {
    FlatPanorama& panorama = panoramas[i];
    panorama.grey =
        RenderFlat(flat, lighting[panorama.visit], panorama.world_from_camera, cameras[i]);
  });
  return panoramas;
}

}  // namespace waystone
