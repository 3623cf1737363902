// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "builder/build_map.h"
#include "core/camera/camera.h"
#include "localizer/index/map_index.h"

namespace waystone::bench {

// The errors of the poses of one set of queries.
struct PoseErrors {
  int asked = 0;
  int localized = 0;
  std::vector<double> metres;
  std::vector<double> degrees;
  std::vector<double> nees;  // normalised error squared over its expectation, 6
  std::vector<double> ms;
  std::vector<double> inliers;
};

// Queries a map with poses with an image of known pose (map_from_camera), prints the errors, and
// adds them. Panoramas need no camera.
void AskPose(const MapIndex& index, const cv::Mat& grey, const std::optional<Camera>& camera,
             const Eigen::Isometry3d& truth, const std::string& name, PoseErrors& errors);

nlohmann::ordered_json SummarisePoses(const std::string& name, const PoseErrors& errors);

// Poses in metres, by frame number.
GivenPoses PosesByFrame(std::function<std::optional<Eigen::Isometry3d>(int)> of_frame);

// The map of one source, with or without these poses; prints what became of them.
BuildResult BuildPosed(std::unique_ptr<Source> source, const std::optional<GivenPoses>& poses,
                       BuildOptions options = {});

}  // namespace waystone::bench
