// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <iostream>

#include "bench/accuracy/common.h"
#include "bench/accuracy/posed_panoramas.h"
#include "bench/accuracy/posed_queries.h"
#include "bench/accuracy/rgbd_truth.h"
#include "bench/accuracy/settings.h"
#include "bench/accuracy/world_source.h"
#include "bench/baseline/scenes.h"
#include "builder/sources/memory_source.h"
#include "core/base/error.h"
#include "core/image/decode.h"
#include "world/rig.h"

namespace waystone::bench {
namespace {

using Eigen::Isometry3d;

// A made building, queried from another walk through it.
nlohmann::ordered_json MeasureBuilding(uint64_t seed, int frames, const BuildOptions& options) {
  const World world(DemoPlan(), WorldOptions{.seed = seed, .texture_richness = 0.5});
  const Renderer renderer(PinholeCamera(640, 480, 1.1));
  Walk walk = DemoWalk(world.plan(), {.step_m = 0.1, .seed = seed});
  walk.frames.resize(std::min<size_t>(walk.frames.size(), frames));
  Walk other =
      DemoWalk(world.plan(), {.height_m = 1.4, .step_m = 0.1, .gaze_offset_rad = 0.15, .seed = 77});
  other.frames.resize(std::min<size_t>(other.frames.size(), frames));
  const BuildResult built = BuildPosed(
      std::make_unique<WorldSource>(world, renderer, walk),
      PosesByFrame([&](int frame) { return walk.frames[frame].world_from_camera; }), options);
  const auto index = MapIndex::Build(built.map);
  const WorldSource queries(world, renderer, other);
  PoseErrors errors;
  for (int q = 5; q < std::ssize(other.frames); q += 7) {
    AskPose(*index, queries.Render(q).grey, renderer.camera(), other.frames[q].world_from_camera,
            "building " + std::to_string(seed) + " frame " + std::to_string(q), errors);
  }
  return SummarisePoses("building " + std::to_string(seed), errors);
}

nlohmann::ordered_json MeasureKitchen(const std::filesystem::path& folder,
                                      const BuildOptions& build) {
  const RgbdTruth truth(folder);
  const auto pose_of = [&](int frame) { return truth.world_from_colour(frame); };
  SourceOptions options;
  options.to = 499;
  std::unique_ptr<Source> source = OpenSource(folder.string(), options);
  const Camera camera = source->camera().value();
  const BuildResult built = BuildPosed(std::move(source), PosesByFrame(pose_of), build);
  const auto index = MapIndex::Build(built.map);
  PoseErrors errors;
  for (int q = 500; q < 1000; q += 10) {
    AskPose(*index, DecodeGrey(ReadBytes(folder / truth.image(q))), camera, pose_of(q),
            "kitchen " + std::to_string(q), errors);
  }
  return SummarisePoses("kitchen", errors);
}

struct PosedPhoto {
  std::filesystem::path path;
  Camera camera;
  Isometry3d pose = Isometry3d::Identity();
};

// The photos of a role in poses.csv.
std::vector<PosedPhoto> ReadPosedPhotos(const std::filesystem::path& folder,
                                        const std::string& role) {
  std::vector<PosedPhoto> photos;
  for (const PhotoPose& row : ReadPhotoPoses(folder)) {
    if (row.role != role) continue;
    PosedPhoto photo;
    photo.path = folder / role / row.image;
    const cv::Mat image = DecodeGrey(ReadBytes(photo.path));
    const Eigen::Matrix3d& k = row.camera.k;
    photo.camera = {
        CameraModel::kPinhole, image.cols, image.rows, {k(0, 0), k(1, 1), k(0, 2), k(1, 2)}};
    photo.pose.translation() = row.camera.centre;
    photo.pose.linear() = row.camera.world_from_camera;
    photos.push_back(photo);
  }
  return photos;
}

nlohmann::ordered_json MeasureChurch(const std::filesystem::path& folder,
                                     const BuildOptions& options) {
  const std::vector<PosedPhoto> map = ReadPosedPhotos(folder, "map");
  MemorySequence sequence{.name = "church", .camera = map.at(0).camera};
  for (int i = 0; i < std::ssize(map); ++i) {
    sequence.frames.emplace_back(FrameInfo{i, map[i].path.filename().string(), {}},
                                 [&map, i] { return DecodeGrey(ReadBytes(map[i].path)); });
  }
  const BuildResult built =
      BuildPosed(std::make_unique<MemorySource>(std::move(sequence)),
                 PosesByFrame([&](int frame) { return map[frame].pose; }), options);
  const auto index = MapIndex::Build(built.map);
  PoseErrors errors;
  for (const PosedPhoto& photo : ReadPosedPhotos(folder, "query_P8")) {
    AskPose(*index, DecodeGrey(ReadBytes(photo.path)), photo.camera, photo.pose,
            photo.path.filename().string(), errors);
  }
  return SummarisePoses("church", errors);
}

}  // namespace

int RunPoses(const Args& raw) {
  Args args = raw;
  const BuildOptions options = TakeBuildSettings(args);
  const int buildings = std::stoi(TakeOption(args, "buildings", "3"));
  const int frames = std::stoi(TakeOption(args, "frames", "150"));
  const std::string kitchen = TakeOption(args, "kitchen", "");
  const std::string church = TakeOption(args, "church", "");
  const int flats = std::stoi(TakeOption(args, "flats", "4"));
  const int first_flat = std::stoi(TakeOption(args, "first-flat", "101"));
  const std::string panoramas = TakeOption(args, "panoramas", "");
  if (!args.empty()) {
    throw MapError(ErrorCode::kUsage,
                   "poses takes --buildings N, --frames N, --kitchen DIR, --church DIR, --flats N, "
                   "--first-flat SEED, --panoramas DIR and --set NAME=VALUE");
  }
  nlohmann::ordered_json json = {{"bench", "poses"}, {"sets", nlohmann::ordered_json::array()}};
  for (int seed = 1; seed <= buildings; ++seed) {
    json["sets"].push_back(MeasureBuilding(seed, frames, options));
  }
  if (!kitchen.empty()) json["sets"].push_back(MeasureKitchen(kitchen, options));
  if (!church.empty()) json["sets"].push_back(MeasureChurch(church, options));
  if (flats > 0) json["sets"].push_back(MeasurePosedFlats(first_flat, flats, options));
  if (!panoramas.empty()) json["sets"].push_back(MeasurePosedPlaces(panoramas, options));
  std::cout << json.dump() << std::endl;
  return 0;
}

}  // namespace waystone::bench
