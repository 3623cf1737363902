// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <filesystem>
#include <functional>
#include <opencv2/core.hpp>
#include <set>
#include <string>
#include <vector>

#include "core/camera/rig.h"

namespace waystone::bench {

// Photos by rigs whose rotation relative to their building is known.
struct OrientedSet {
  std::string name;
  Rig rig;
  std::vector<std::string> names;
  std::vector<Eigen::Matrix3d> rig_from_axes;
  std::vector<Eigen::Isometry3d> world_from_rig;    // empty where no poses are known
  std::vector<std::set<int>> visible;               // places seen from each; empty where not known
  std::function<std::vector<cv::Mat>(int)> images;  // of a photo, one per camera; thread-safe

  int size() const { return static_cast<int>(names.size()); }
};

// Recognises a folder: vp_gt.csv and images/ (one pinhole camera; its truth's y axis points up), or
// poses.csv and rig/ (six faces; world axes are the building's). Throws MapError(kUsage) for
// others.
OrientedSet OpenOrientedSet(const std::filesystem::path& folder);

// A rendered walk through the demo plan, as a rig of six faces or as one pinhole camera.
OrientedSet RenderedSet(bool rig, int frames);

}  // namespace waystone::bench
