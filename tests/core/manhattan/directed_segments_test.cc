// SPDX-License-Identifier: Apache-2.0
#include "core/manhattan/directed_segments.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace waystone {
namespace {

const Camera kCamera{CameraModel::kPinhole, 640, 480, {500, 500, 319.5, 239.5}};

Eigen::Matrix3d RigFromBuilding(double turn_rad) {
  Eigen::Matrix3d upright;  // looks along x
  upright << 0, -1, 0, 0, 0, -1, 1, 0, 0;
  return upright * Eigen::AngleAxisd(turn_rad, Eigen::Vector3d::UnitZ()).toRotationMatrix();
}

// Bars along each axis of a building 4 m ahead, and one along none.
cv::Mat Bars(const Eigen::Matrix3d& rig_from_building) {
  cv::Mat picture(480, 640, CV_8UC1, cv::Scalar(40));
  const Eigen::Vector3d middle = rig_from_building.transpose() * Eigen::Vector3d(0, 0, 4);
  const auto bar = [&](const Eigen::Vector3d& from, const Eigen::Vector3d& along) {
    cv::Point ends[2];
    for (int end = 0; end < 2; ++end) {
      const Eigen::Vector3d x = rig_from_building * (middle + from + end * along);
      const Eigen::Vector2d px = Project(kCamera, x).value();
      ends[end] = {static_cast<int>(std::lround(px.x())), static_cast<int>(std::lround(px.y()))};
    }
    cv::line(picture, ends[0], ends[1], cv::Scalar(220), 5, cv::LINE_AA);
  };
  for (const double at : {-1.2, -0.7, 0.7, 1.2}) {
    bar({-1, at, -0.6}, {1.6, 0, 0});
    bar({0.3, -0.6, 0.9 * at}, {0, 1.2, 0});
    bar({0.2, at, -0.5}, {0, 0, 1});
  }
  bar({0, -0.4, -0.3}, {0, 0.7, 0.5});
  return picture;
}

// Angle between the plane of a line and its axis, rad: 0 for a line that runs along it.
double OffAxis(const DirectedSegment& line, const Eigen::Matrix3d& rig_from_building) {
  const Eigen::Vector3d normal =
      Unproject(kCamera, line.segment.a).cross(Unproject(kCamera, line.segment.b)).normalized();
  return std::abs(std::asin(normal.dot(rig_from_building.col(line.axis))));
}

void ExpectTrueAxes(const DirectedSegments& found, const Eigen::Matrix3d& rig_from_building) {
  EXPECT_TRUE(found.reliable);
  std::array<int, 3> count{};
  int of_none = 0;
  for (const DirectedSegment& line : found.segments) {
    if (line.axis < 0) {
      ++of_none;
      continue;
    }
    ++count[line.axis];
    EXPECT_LT(OffAxis(line, rig_from_building), 0.04) << line.axis;
  }
  EXPECT_GE(of_none, 1);
  for (int axis = 0; axis < 3; ++axis) EXPECT_GE(count[axis], 4) << "axis " << axis;
}

TEST(DirectedSegments, HaveTheAxesOfTheGivenRotation) {
  const Eigen::Matrix3d rig_from_building = RigFromBuilding(0.4);
  const cv::Mat picture = Bars(rig_from_building);
  ExpectTrueAxes(FindDirectedSegments(picture, kCamera, rig_from_building), rig_from_building);
}

TEST(DirectedSegments, GiveTheAxesThemselvesWhereNoneAreGiven) {
  const Eigen::Matrix3d rig_from_building = RigFromBuilding(-0.3);
  ExpectTrueAxes(FindDirectedSegments(Bars(rig_from_building), kCamera, std::nullopt),
                 rig_from_building);
}

TEST(DirectedSegments, AnEmptyPictureHasNone) {
  const cv::Mat grey(480, 640, CV_8UC1, cv::Scalar(90));
  const DirectedSegments found = FindDirectedSegments(grey, kCamera, std::nullopt);
  EXPECT_TRUE(found.segments.empty());
  EXPECT_FALSE(found.reliable);
}

}  // namespace
}  // namespace waystone
