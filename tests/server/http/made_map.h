// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "schema/map_data.h"

namespace waystone {

// A small map made by hand: `planes` planes in a chain, seen by two keyframes, of which the first
// has a picture and a time stamp.
inline MapData MadeMap(int planes) {
  MapData map;
  map.info = {"made", "waystone test", FeatureType::kSift, "{}", "sha256:abc123"};
  map.sequences.push_back({SequenceId{1}, "kit\"chen", "folder", 10, 1, std::nullopt});
  map.keyframes.push_back(
      {KeyframeId{1}, SequenceId{1}, 0, 0, "rgb/0.jpg", 0.5, 640, 480, {0xFF, 0xD8, 0xFF, 0xD9}});
  map.keyframes.push_back({KeyframeId{2}, SequenceId{1}, 0, 7, "rgb/7.jpg", {}, 640, 480, {}});
  for (int i = 1; i <= planes; ++i) {
    Plane plane;
    plane.id = PlaneId{i};
    plane.reference = KeyframeId{1};
    plane.descriptors = Descriptors(DescriptorBytes(FeatureType::kSift));
    for (int f = 0; f < 5; ++f) {
      plane.features.push_back({{10.0F * static_cast<float>(f), 20.0F, 3.0F, 0.1F}, 2, 2});
      const std::vector<uint8_t> row(128, static_cast<uint8_t>(i + f));
      plane.descriptors.Append(row.data());
    }
    plane.outline = {{0, 0}, {100.123, 0}, {100, 50.5}};
    Eigen::Matrix3d shift = Eigen::Matrix3d::Identity();
    shift(0, 2) = 4.25;
    plane.views = {{KeyframeId{1}, Eigen::Matrix3d::Identity(), 5}, {KeyframeId{2}, shift, 5}};
    map.planes.push_back(std::move(plane));
  }
  for (int i = 1; i < planes; ++i) {
    map.edges.push_back({PlaneId{i}, PlaneId{i + 1}, KeyframeId{1}, KeyframeId{2},
                         Eigen::Matrix3d::Identity(), 1.5});
  }
  return map;
}

}  // namespace waystone
