// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <filesystem>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "builder/build_map.h"
#include "builder/joining/align_frames.h"
#include "core/features/features.h"
#include "localizer/localizer.h"
#include "schema/file/map_store.h"
#include "tests/builder/map/stage.h"

namespace waystone {

// The map of these frames, written and read back: with a version, as maps that are joined have.
inline MapData MapOfImages(const std::vector<cv::Mat>& frames, int first, int last,
                           const std::string& name, FeatureType type = FeatureType::kSift,
                           const std::optional<GivenPoses>& poses = {}) {
  MemorySequence sequence{.name = name, .camera = {}};
  if (poses) sequence.camera = TheStage().renderer.camera();
  for (int i = first; i <= last; ++i) {
    sequence.frames.emplace_back(FrameInfo{i, "frame " + std::to_string(i), i / 15.0},
                                 [&frames, i] { return frames[i]; });
  }
  std::vector<std::unique_ptr<Source>> sources;
  sources.push_back(std::make_unique<MemorySource>(std::move(sequence)));
  BuildOptions options;
  options.map_name = name;
  options.features.type = type;
  const auto path = std::filesystem::path(testing::TempDir()) / (name + ".db");
  WriteMap(BuildMap(sources, options, {}, poses).map, path, {.overwrite = true});
  MapData map = ReadMap(path);
  std::filesystem::remove(path);
  return map;
}

// The same of some frames of the made stage (tests/builder/map/stage.h).
inline MapData MapOfFrames(int first, int last, const std::string& name,
                           FeatureType type = FeatureType::kSift) {
  return MapOfImages(TheStage().frames, first, last, name, type);
}

// Two walks that share a stretch.
inline const MapData& FirstHalf() {
  static const MapData map = MapOfFrames(0, 25, "first");
  return map;
}
inline const MapData& SecondHalf() {
  static const MapData map = MapOfFrames(18, 44, "second");
  return map;
}

// A frame in which the stage's world is turned, scaled and moved.
struct MadeFrame {
  FrameChange from_world;
  LengthUnit unit = LengthUnit::kUnknown;

  Eigen::Isometry3d Of(Eigen::Isometry3d world_from_camera) const {
    const Eigen::Vector3d moved = from_world.rotation * world_from_camera.translation();
    world_from_camera.translation() = from_world.scale * moved + from_world.translation;
    world_from_camera.linear() = from_world.rotation * world_from_camera.linear();
    return world_from_camera;
  }
};

// The same with poses in such a frame.
inline MapData PosedMapOfFrames(int first, int last, const std::string& name,
                                const MadeFrame& frame) {
  GivenPoses poses{.frame = name + "'s", .unit = frame.unit, .of_image = {}};
  poses.of_image = [frame](const Sequence&, const FrameInfo& image) {
    return frame.Of(TheStage().walk.frames[image.number].world_from_camera);
  };
  return MapOfImages(TheStage().frames, first, last, name, FeatureType::kSift, poses);
}

// The map of a walk through a building of the same plan with other pictures on its walls.
inline MapData MapOfAnotherBuilding() {
  const World world(DemoPlan(), {.seed = 77, .texture_richness = 0.5});
  std::vector<cv::Mat> frames;
  for (int i = 0; i < 15; ++i) {
    frames.push_back(
        TheStage().renderer.Render(world, TheStage().walk.frames[i].world_from_camera).grey);
  }
  return MapOfImages(frames, 0, 14, "elsewhere");
}

// Features of every frame of the stage, in their order.
inline const std::vector<Features>& FeaturesOfFrames() {
  static const std::vector<Features> all = [] {
    std::vector<Features> features;
    for (const cv::Mat& frame : TheStage().frames) {
      features.push_back(ExtractFeatures(frame, FeatureOptions{}));
    }
    return features;
  }();
  return all;
}

// The map as it is after being written and read: what a file has.
inline MapData WrittenAndRead(const MapData& map) {
  const auto path = std::filesystem::path(testing::TempDir()) / "joined.db";
  WriteMap(map, path, {.overwrite = true});
  EXPECT_TRUE(CheckMap(path).empty());
  MapData read = ReadMap(path);
  std::filesystem::remove(path);
  return read;
}

}  // namespace waystone
