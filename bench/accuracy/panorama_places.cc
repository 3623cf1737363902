// SPDX-License-Identifier: Apache-2.0
#include "bench/accuracy/panorama_places.h"

#include <tbb/parallel_for.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <fstream>
#include <sstream>

#include "bench/accuracy/common.h"
#include "builder/sources/memory_source.h"
#include "core/base/error.h"
#include "core/base/random.h"
#include "core/geometry/angle.h"
#include "core/image/decode.h"
#include "world/flat.h"
#include "world/render.h"
#include "world/rig.h"
#include "world/walk.h"
#include "world/world.h"

namespace waystone::bench {
namespace {

namespace fs = std::filesystem;

constexpr int kRenderedWidth = 512;   // px
constexpr double kHeight_m = 1.5;     // of the camera
constexpr double kFromWalls_m = 0.4;  // at least
constexpr double kTilt_rad = 0.017;
constexpr double kNoise = 4;  // grey levels

double YawOf(const Eigen::Matrix3d& world_from_rig) {
  return std::atan2(world_from_rig(1, 2), world_from_rig(0, 2));
}

PanoramaPlace ReadPlace(const fs::path& folder, const std::string& line) {
  std::string text = line;
  std::replace(text.begin(), text.end(), ',', ' ');
  std::istringstream fields(text);
  PanoramaPlace place;
  double z = 0;
  Eigen::Quaterniond turn;
  if (!(fields >> place.name >> place.position_m.x() >> place.position_m.y() >> z >> turn.x() >>
        turn.y() >> turn.z() >> turn.w())) {
    throw MapError(ErrorCode::kFileUnreadable, (folder / "poses.csv").string() + ": '" +
                                                   text.substr(0, 40) +
                                                   "' is no line of id,x,y,z,qx,qy,qz,qw");
  }
  place.world_from_camera.linear() = turn.normalized().toRotationMatrix();
  place.world_from_camera.translation() << place.position_m, z;
  place.yaw_rad = YawOf(place.world_from_camera.linear());
  place.grey = DecodeGrey(ReadBytes(folder / "panorama" / (place.name + ".jpg")));
  return place;
}

// Whether the place and the points around it are inside.
bool IsFree(const World& world, const Eigen::Vector2d& at_m) {
  for (int i = 0; i < 8; ++i) {
    const double angle = i * kPi / 4;
    const Eigen::Vector3d point(at_m.x() + kFromWalls_m * std::cos(angle),
                                at_m.y() + kFromWalls_m * std::sin(angle), kHeight_m);
    if (!world.IsInside(point)) return false;
  }
  return true;
}

// Whether a wall stands between two places.
bool IsHidden(const World& world, const PanoramaPlace& a, const PanoramaPlace& b) {
  const Eigen::Vector2d step = b.position_m - a.position_m;
  if (step.norm() == 0) return false;
  const Eigen::Vector3d from(a.position_m.x(), a.position_m.y(), kHeight_m);
  const Eigen::Vector3d ray(step.x() / step.norm(), step.y() / step.norm(), 0);
  return world.Cast(from, ray).t < step.norm();
}

}  // namespace

std::vector<PanoramaPlace> ReadPlaces(const fs::path& folder) {
  std::ifstream in(folder / "poses.csv");
  if (!in) {
    throw MapError(ErrorCode::kFileUnreadable, (folder / "poses.csv").string() + " can't be read");
  }
  std::vector<PanoramaPlace> places;
  std::string line;
  std::getline(in, line);
  while (std::getline(in, line)) places.push_back(ReadPlace(folder, line));
  return places;
}

std::vector<PanoramaPlace> RenderPlaces(int count, uint64_t seed) {
  const World world(DemoPlan());
  const Renderer renderer(PanoramaCamera(kRenderedWidth));
  Random random(seed);
  std::vector<PanoramaPlace> places;
  std::vector<Eigen::Isometry3d> poses;
  std::vector<RenderOptions> options;
  while (static_cast<int>(places.size()) < count) {
    const Eigen::Vector2d at(random.Uniform(0, 13.5), random.Uniform(0, 12.5));
    if (!IsFree(world, at)) continue;
    const double yaw = random.Uniform(-kPi, kPi);
    const double pitch = kTilt_rad * random.Normal();
    const double roll = kTilt_rad * random.Normal();
    poses.push_back(WorldFromCamera({at.x(), at.y(), kHeight_m}, yaw, pitch, roll));
    RenderOptions render;
    render.noise_sigma = kNoise;
    render.noise_seed = random.Next();
    render.exposure_gain = random.Uniform(0.7, 1.2);
    options.push_back(render);
    places.push_back(
        {std::to_string(places.size()), {}, at, YawOf(poses.back().linear()), {}, poses.back()});
  }
  tbb::parallel_for(size_t{0}, places.size(), [&](size_t i) {
    places[i].grey = renderer.Render(world, poses[i], options[i]).grey;
  });
  for (PanoramaPlace& a : places) {
    for (const PanoramaPlace& b : places) a.hidden.push_back(IsHidden(world, a, b));
  }
  return places;
}

std::vector<PanoramaPlace> RenderFlatPlaces(uint64_t seed) {
  FlatOptions options;
  options.seed = seed;
  const Flat flat = MakeFlat(options);
  FlatTourOptions tour;
  tour.seed = seed;
  const std::vector<FlatPanorama> panoramas = PhotographFlat(flat, tour);
  std::vector<PanoramaPlace> places;
  for (const FlatPanorama& panorama : panoramas) {
    PanoramaPlace place;
    place.name = std::to_string(seed) + "-" + std::to_string(places.size());
    place.grey = panorama.grey;
    place.position_m = panorama.place.at.head<2>();
    place.yaw_rad = YawOf(panorama.world_from_camera.linear());
    place.world_from_camera = panorama.world_from_camera;
    for (const FlatPanorama& other : panoramas) {
      place.hidden.push_back(!SeesThrough(flat.scene, panorama.place.at, other.place.at));
    }
    places.push_back(std::move(place));
  }
  return places;
}

std::vector<PanoramaPlace> InWalkOrder(std::vector<PanoramaPlace> places) {
  for (size_t i = 1; i < places.size(); ++i) {
    const auto apart = [&](const PanoramaPlace& place) {
      return (place.position_m - places[i - 1].position_m).norm();
    };
    const auto next = std::ranges::min_element(places.begin() + static_cast<std::ptrdiff_t>(i),
                                               places.end(), {}, apart);
    const auto other = static_cast<size_t>(next - places.begin());
    std::swap(places[i], places[other]);
    for (PanoramaPlace& place : places) {
      if (place.hidden.empty()) continue;
      const bool hidden = place.hidden[i];
      place.hidden[i] = place.hidden[other];
      place.hidden[other] = hidden;
    }
  }
  return places;
}

SplitPlaces Split(std::vector<PanoramaPlace> places) {
  constexpr size_t kAskedEvery = 4;  // in the order of their walk
  SplitPlaces split;
  for (size_t i = 0; i < places.size(); ++i) {
    const bool asked = i % kAskedEvery == kAskedEvery / 2;
    (asked ? split.asked : split.mapped).push_back(std::move(places[i]));
  }
  return split;
}

std::unique_ptr<Source> PanoramaSource(const std::vector<PanoramaPlace>& places, size_t first,
                                       size_t end, const std::string& name) {
  MemorySequence sequence{.name = name, .frame_size = places.at(first).grey.size()};
  for (size_t i = first; i < end; ++i) {
    sequence.frames.emplace_back(FrameInfo{static_cast<int>(i), places[i].name, {}},
                                 [&places, i] { return places[i].grey; });
  }
  return std::make_unique<MemorySource>(std::move(sequence));
}

double TrueHeading(const PanoramaPlace& a, const PanoramaPlace& b) {
  return std::remainder(b.yaw_rad - a.yaw_rad, 2 * kPi);
}

double TrueDirection(const PanoramaPlace& a, const PanoramaPlace& b) {
  const Eigen::Vector2d step = b.position_m - a.position_m;
  return std::remainder(std::atan2(step.y(), step.x()) - a.yaw_rad, 2 * kPi);
}

}  // namespace waystone::bench
