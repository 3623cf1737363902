// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "builder/build_map.h"
#include "tests/builder/appearance/drive.h"

namespace waystone {

// Maps of the panoramas of a made drive (tests/builder/appearance/drive.h).
inline BuildOptions PanoramaOptionsOf(const std::string& name) {
  BuildOptions options;
  options.map_name = name;
  options.appearance = ShortDrive();
  options.appearance_calibration.max_nodes = 12;
  options.appearance_calibration.rendered_negatives = 4;
  return options;
}

inline MapData MapOfPanoramas(const std::vector<cv::Mat>& panoramas, const BuildOptions& options) {
  std::vector<std::unique_ptr<Source>> sources;
  sources.push_back(std::make_unique<MemorySource>(ImagesSource(panoramas, options.map_name)));
  MapData map = BuildMap(sources, options, {}).map;
  map.info.version = "sha256:" + options.map_name;  // a file's would be its hash
  return map;
}

// Every second panorama of the drive, from one on.
inline MapData PanoramasOfEverySecond(int first, const std::string& name) {
  std::vector<cv::Mat> panoramas;
  for (int i = first; i < Drive::kFrames; i += 2) panoramas.push_back(TheDrive().panoramas[i]);
  return MapOfPanoramas(panoramas, PanoramaOptionsOf(name));
}

inline const MapData& MorningPanoramas() {
  static const MapData map = PanoramasOfEverySecond(0, "morning");
  return map;
}
inline const MapData& EveningPanoramas() {
  static const MapData map = PanoramasOfEverySecond(1, "evening");
  return map;
}

}  // namespace waystone
