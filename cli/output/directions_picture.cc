// SPDX-License-Identifier: Apache-2.0
#include "cli/output/directions_picture.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace waystone {
namespace {

constexpr int kLeastWidth = 480;  // of an image in the picture, px
constexpr int kColumns = 3;       // of images; a rig of six takes two rows
constexpr int kShift = 4;         // sub-pixel bits of OpenCV's drawing
constexpr int kArrow = 36;        // px
constexpr int kRing = 9;          // radius, px

const std::array<cv::Scalar, 3> kColours{cv::Scalar(60, 60, 240), cv::Scalar(70, 200, 50),
                                         cv::Scalar(255, 140, 40)};
const cv::Scalar kNone(170, 170, 170);

// A point of an image in the enlarged one, as coordinates for drawing with kShift.
cv::Point At(const Eigen::Vector2d& px, double scale) {
  const Eigen::Vector2d at = (scale * (px.array() + 0.5) - 0.5) * (1 << kShift);
  return {static_cast<int>(std::lround(at.x())), static_cast<int>(std::lround(at.y()))};
}

void DrawLines(cv::Mat& picture, double scale, int camera, std::span<const GreatCircle> lines,
               const ManhattanFrame& frame) {
  for (size_t i = 0; i < lines.size(); ++i) {
    if (lines[i].camera != camera) continue;
    const int axis = frame.axis_of_line[i];
    cv::line(picture, At(lines[i].segment.a, scale), At(lines[i].segment.b, scale),
             axis < 0 ? kNone : kColours[axis], axis < 0 ? 1 : 2, cv::LINE_AA, kShift);
  }
}

// The axes as arrows in the lower left corner, and their vanishing points.
void DrawAxes(cv::Mat& picture, double scale, const RigCamera& seen, const ManhattanFrame& frame) {
  const Eigen::Matrix3d camera_from_axes =
      seen.rig_from_camera.linear().transpose() * frame.rig_from_axes;
  const cv::Point corner(kArrow + 14, picture.rows - kArrow - 14);
  cv::circle(picture, corner, kArrow + 8, cv::Scalar(30, 30, 30), cv::FILLED, cv::LINE_AA);
  for (int axis = 0; axis < 3; ++axis) {
    const Eigen::Vector3d v = camera_from_axes.col(axis);
    const cv::Point tip(static_cast<int>(std::lround(kArrow * v.x())),
                        static_cast<int>(std::lround(kArrow * v.y())));
    cv::arrowedLine(picture, corner, corner + tip, kColours[axis], 2, cv::LINE_AA, 0, 0.25);
    for (const double sign : {1.0, -1.0}) {
      const auto px = Project(seen.camera, sign * v);
      if (!px || px->minCoeff() < 0 || px->x() >= seen.camera.width ||
          px->y() >= seen.camera.height) {
        continue;
      }
      cv::circle(picture, At(*px, scale), kRing << kShift, kColours[axis], 2, cv::LINE_AA, kShift);
    }
  }
}

}  // namespace

cv::Mat DrawDirections(const Rig& rig, std::span<const cv::Mat> images,
                       std::span<const GreatCircle> lines, const ManhattanFrame& frame) {
  const bool axes = frame.lines != std::array<int, 3>{};
  std::vector<cv::Mat> pictures;
  cv::Size cell;
  for (size_t c = 0; c < images.size(); ++c) {
    const double scale = std::max(1.0, static_cast<double>(kLeastWidth) / images[c].cols);
    cv::Mat picture;
    cv::cvtColor(images[c], picture, cv::COLOR_GRAY2BGR);
    cv::resize(picture, picture, {}, scale, scale, cv::INTER_LINEAR);
    DrawLines(picture, scale, static_cast<int>(c), lines, frame);
    if (axes) DrawAxes(picture, scale, rig.cameras[c], frame);
    cell = {std::max(cell.width, picture.cols), std::max(cell.height, picture.rows)};
    pictures.push_back(picture);
  }
  const int columns = std::min(kColumns, static_cast<int>(pictures.size()));
  const int rows = (static_cast<int>(pictures.size()) + columns - 1) / columns;
  cv::Mat whole(rows * cell.height, columns * cell.width, CV_8UC3, cv::Scalar(30, 30, 30));
  for (size_t c = 0; c < pictures.size(); ++c) {
    const auto at = static_cast<int>(c);
    pictures[c].copyTo(
        whole({{at % columns * cell.width, at / columns * cell.height}, pictures[c].size()}));
  }
  return whole;
}

}  // namespace waystone
