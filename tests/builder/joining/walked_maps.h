// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <filesystem>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "builder/build_map.h"
#include "core/features/features.h"
#include "localizer/localizer.h"
#include "schema/file/map_store.h"
#include "tests/builder/map/stage.h"

namespace waystone {

// The map of some frames of the made stage (tests/builder/map/stage.h), written and read back: with
// a version, as maps that are joined have.
inline MapData MapOfFrames(int first, int last, const std::string& name,
                           FeatureType type = FeatureType::kSift) {
  MemorySequence sequence{.name = name, .camera = {}};
  for (int i = first; i <= last; ++i) {
    sequence.frames.emplace_back(FrameInfo{i, "frame " + std::to_string(i), i / 15.0},
                                 [i] { return TheStage().frames[i]; });
  }
  std::vector<std::unique_ptr<Source>> sources;
  sources.push_back(std::make_unique<MemorySource>(std::move(sequence)));
  BuildOptions options;
  options.map_name = name;
  options.features.type = type;
  const auto path = std::filesystem::path(testing::TempDir()) / (name + ".db");
  WriteMap(BuildMap(sources, options, {}).map, path, {.overwrite = true});
  MapData map = ReadMap(path);
  std::filesystem::remove(path);
  return map;
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
