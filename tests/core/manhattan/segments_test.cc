// SPDX-License-Identifier: Apache-2.0
#include "core/manhattan/segments.h"

#include <gtest/gtest.h>

#include <numbers>
#include <opencv2/imgproc.hpp>

#include "core/base/error.h"
#include "core/base/random.h"
#include "core/manhattan/edge_chains.h"
#include "core/manhattan/refine_segment.h"

namespace waystone {
namespace {

// A dark plane on a bright one, their border through the middle at an angle; smooth and noisy.
cv::Mat Border(double angle_rad, double noise) {
  cv::Mat image(200, 240, CV_8UC1);
  Random random(7);
  for (int y = 0; y < image.rows; ++y) {
    for (int x = 0; x < image.cols; ++x) {
      const double side = -std::sin(angle_rad) * (x - 120) + std::cos(angle_rad) * (y - 100);
      const double grey = 120 + 50 * std::tanh(side / 0.8) + noise * random.Normal();
      image.at<uchar>(y, x) = cv::saturate_cast<uchar>(grey);
    }
  }
  return image;
}

double AngleOf(const ImageSegment& segment) {
  const Eigen::Vector2d along = segment.b - segment.a;
  return std::atan(along.y() / along.x());
}

class Detectors : public testing::TestWithParam<SegmentDetector> {};

TEST_P(Detectors, FindABorderToAFractionOfAPixel) {
  for (const double angle : {-0.9, -0.31, 0.0, 0.13, 0.6}) {
    const auto segments = DetectSegments(Border(angle, 3), {.detector = GetParam()});
    ASSERT_FALSE(segments.empty()) << angle;
    double length = 0;
    for (const ImageSegment& segment : segments) {
      const double tolerance = 0.4 / segment.length_px();
      EXPECT_NEAR(AngleOf(segment), angle, tolerance) << angle;
      const Eigen::Vector2d middle = 0.5 * (segment.a + segment.b) - Eigen::Vector2d(120, 100);
      EXPECT_NEAR(-std::sin(angle) * middle.x() + std::cos(angle) * middle.y(), 0, 0.15);
      length += segment.length_px();
    }
    EXPECT_GT(length, 140) << angle;
  }
}

TEST_P(Detectors, FindNothingInFogAndDarkness) {
  EXPECT_TRUE(
      DetectSegments(cv::Mat(120, 160, CV_8UC1, cv::Scalar(0)), {.detector = GetParam()}).empty());
  EXPECT_TRUE(DetectSegments(cv::Mat(120, 160, CV_8UC1, cv::Scalar(180)), {.detector = GetParam()})
                  .empty());
  EXPECT_TRUE(
      DetectSegments(cv::Mat(3, 5, CV_8UC1, cv::Scalar(9)), {.detector = GetParam()}).empty());
}

TEST_P(Detectors, GiveTheSameTwice) {
  const cv::Mat image = Border(0.3, 8);
  const auto once = DetectSegments(image, {.detector = GetParam()});
  const auto again = DetectSegments(image, {.detector = GetParam()});
  ASSERT_EQ(once.size(), again.size());
  for (size_t i = 0; i < once.size(); ++i) {
    EXPECT_EQ(once[i].a, again[i].a);
    EXPECT_EQ(once[i].b, again[i].b);
  }
}

INSTANTIATE_TEST_SUITE_P(All, Detectors,
                         testing::Values(SegmentDetector::kEdgeDrawing, SegmentDetector::kCanny,
                                         SegmentDetector::kLsd),
                         [](const auto& of) { return std::string(NameOf(of.param)); });

TEST(RefineSegment, CorrectsARoundedSegment) {
  const cv::Mat image = Border(0.2, 2);
  // 1 px off at one end, half a pixel at the other.
  const Eigen::Vector2d along(std::cos(0.2), std::sin(0.2));
  const Eigen::Vector2d across(-along.y(), along.x());
  const Eigen::Vector2d middle(120, 100);
  const ImageSegment rough{middle - 30 * along + across, middle + 30 * along - 0.5 * across};
  const auto fine = RefineSegment(image, rough, 2);
  ASSERT_TRUE(fine);
  EXPECT_NEAR(across.dot(fine->a - middle), 0, 0.1);
  EXPECT_NEAR(across.dot(fine->b - middle), 0, 0.1);
}

TEST(RefineSegment, RefusesWhatIsNoEdge) {
  const cv::Mat flat(100, 100, CV_8UC1, cv::Scalar(90));
  EXPECT_FALSE(RefineSegment(flat, {{20, 20}, {70, 60}}, 2));
}

TEST(EdgeChains, CutsACornerIntoItsSides) {
  cv::Mat edges(60, 60, CV_8UC1, cv::Scalar(0));
  for (int i = 10; i <= 40; ++i) edges.at<uchar>(10, i) = edges.at<uchar>(i, 40) = 255;
  const auto chains = LinkEdges(edges);
  ASSERT_EQ(chains.size(), 1u);
  EXPECT_EQ(chains[0].size(), 61u);
  const auto pieces = StraightPieces(chains, 1.0, 10);
  ASSERT_EQ(pieces.size(), 2u);
  for (const ImageSegment& piece : pieces) EXPECT_NEAR(piece.length_px(), 30, 2);
}

TEST(SegmentOptions, RefusesWhatIsOutOfRange) {
  EXPECT_THROW((SegmentOptions{.min_length = 0}.Check()), MapError);
  EXPECT_THROW((SegmentOptions{.blur_px = 9}.Check()), MapError);
  EXPECT_THROW(SegmentDetectorByName("hough"), MapError);
  EXPECT_EQ(SegmentDetectorByName("lsd"), SegmentDetector::kLsd);
}

}  // namespace
}  // namespace waystone
