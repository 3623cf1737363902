// SPDX-License-Identifier: Apache-2.0
#include "bench/accuracy/rgbd_truth.h"

#include <cmath>
#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <sstream>
#include <utility>

#include "core/base/error.h"
#include "core/robust/quantile.h"

namespace waystone::bench {
namespace {

constexpr double kColourFocal_px = 515;
constexpr double kDepthFocal_px = 585;
constexpr double kCentreX_px = 320;
constexpr double kCentreY_px = 240;
// The colour camera's centre in the depth camera's frame.
const Eigen::Vector3d kColourInDepth(0.025, 0, 0);

std::vector<std::vector<std::string>> ReadTable(const std::filesystem::path& path) {
  std::ifstream file(path);
  if (!file) {
    throw MapError(ErrorCode::kFileUnreadable,
                   "can't read " + path.string() + "; give a TUM RGB-D folder with its truth");
  }
  std::vector<std::vector<std::string>> rows;
  for (std::string line; std::getline(file, line);) {
    if (line.empty() || line[0] == '#') continue;
    std::istringstream words(line);
    std::vector<std::string> row;
    for (std::string word; words >> word;) row.push_back(word);
    rows.push_back(row);
  }
  return rows;
}

int FrameAt(const std::vector<double>& times, double time) {
  int best = 0;
  for (int i = 0; i < static_cast<int>(times.size()); ++i) {
    if (std::abs(times[i] - time) < std::abs(times[best] - time)) best = i;
  }
  return best;
}

Eigen::Isometry3d PoseOf(const std::vector<std::string>& row) {
  const auto number = [&](int i) { return std::stod(row.at(i)); };
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.translation() = Eigen::Vector3d(number(1), number(2), number(3));
  pose.linear() =
      Eigen::Quaterniond(number(7), number(4), number(5), number(6)).normalized().matrix();
  return pose;
}

}  // namespace

RgbdTruth::RgbdTruth(const std::filesystem::path& folder) : folder_(folder) {
  std::vector<double> times;
  for (const auto& row : ReadTable(folder / "rgb.txt")) {
    times.push_back(std::stod(row.at(0)));
    images_.push_back(row.at(1));
  }
  for (const auto& row : ReadTable(folder / "depth.txt")) {
    depths_[FrameAt(times, std::stod(row.at(0)))] = row.at(1);
  }
  world_from_camera_.resize(images_.size(), Eigen::Isometry3d::Identity());
  for (const auto& row : ReadTable(folder / "groundtruth.txt")) {
    world_from_camera_[FrameAt(times, std::stod(row.at(0)))] = PoseOf(row);
  }
}

Eigen::Isometry3d RgbdTruth::world_from_colour(int frame) const {
  return world_from_camera_[frame] * Eigen::Translation3d(kColourInDepth);
}

std::optional<Eigen::Vector2d> RgbdTruth::Transfer(int a, const Eigen::Vector2d& x, int b) const {
  if (!HasDepth(a)) return std::nullopt;
  if (loaded_ != a) {
    depth_ = cv::imread((folder_ / depths_.at(a)).string(), cv::IMREAD_UNCHANGED);
    loaded_ = a;
  }
  const Eigen::Vector3d ray((x.x() - kCentreX_px) / kColourFocal_px,
                            (x.y() - kCentreY_px) / kColourFocal_px, 1);
  // The depth pixel depends on the depth: three rounds settle it.
  double z = 2.0;
  for (int round = 0; round < 3; ++round) {
    const Eigen::Vector3d p = ray * z + kColourInDepth;
    const int u = static_cast<int>(std::lround(kDepthFocal_px * p.x() / p.z() + kCentreX_px));
    const int v = static_cast<int>(std::lround(kDepthFocal_px * p.y() / p.z() + kCentreY_px));
    if (u < 0 || v < 0 || u >= depth_.cols || v >= depth_.rows) return std::nullopt;
    const uint16_t mm = depth_.at<uint16_t>(v, u);
    if (mm == 0 || mm == 65535) return std::nullopt;
    z = mm / 1000.0;
  }
  const Eigen::Vector3d world = world_from_camera_[a] * (ray * z + kColourInDepth);
  const Eigen::Vector3d seen = world_from_camera_[b].inverse() * world - kColourInDepth;
  if (seen.z() <= 0.05) return std::nullopt;
  return Eigen::Vector2d(kColourFocal_px * seen.x() / seen.z() + kCentreX_px,
                         kColourFocal_px * seen.y() / seen.z() + kCentreY_px);
}

std::optional<double> RgbdTruth::MedianError(int query, const SceneAnswer& answer) const {
  constexpr size_t kFewest = 5;
  std::vector<double> errors;
  for (size_t i = 0; i < answer.query_points.size(); ++i) {
    const auto expected = Transfer(query, answer.query_points[i], answer.reference_frame);
    if (!expected) continue;
    const Eigen::Vector2d x =
        InImage(answer.reference_points[i], answer.reference_width, kWidth_px);
    errors.push_back((x - *expected).norm());
  }
  if (errors.size() < kFewest) return std::nullopt;
  return Quantile(std::move(errors), 0.5);
}

}  // namespace waystone::bench
