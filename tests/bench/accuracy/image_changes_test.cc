// SPDX-License-Identifier: Apache-2.0
#include "bench/accuracy/image_changes.h"

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

namespace waystone::bench {
namespace {

// Grey squares of random brightness.
cv::Mat Picture() {
  Random random(3);
  cv::Mat squares(12, 16, CV_8UC1);
  for (auto it = squares.begin<uint8_t>(); it != squares.end<uint8_t>(); ++it) {
    *it = static_cast<uint8_t>(40 + random.Below(120));
  }
  cv::Mat picture;
  cv::resize(squares, picture, {320, 240}, 0, 0, cv::INTER_NEAREST);
  return picture;
}

cv::Mat Changed(const std::string& name) {
  for (const ImageChange& change : ImageChanges()) {
    Random random(1);
    if (change.name == name) return change.apply(Picture(), random);
  }
  ADD_FAILURE() << "no change is called " << name;
  return {};
}

double Mean(const cv::Mat& grey) { return cv::mean(grey)[0]; }

TEST(ImageChanges, TheFirstLeavesThePictureAsItIs) {
  Random random(1);
  EXPECT_EQ(cv::norm(ImageChanges().front().apply(Picture(), random), Picture(), cv::NORM_INF), 0);
}

TEST(ImageChanges, AreGreyPicturesAndTheSameForTheSameSeed) {
  for (const ImageChange& change : ImageChanges()) {
    Random random(1);
    Random again(1);
    const cv::Mat changed = change.apply(Picture(), random);
    ASSERT_EQ(changed.type(), CV_8UC1) << change.name;
    EXPECT_EQ(cv::norm(changed, change.apply(Picture(), again), cv::NORM_INF), 0) << change.name;
  }
}

TEST(ImageChanges, HaveTheSizesThatTheirNamesSay) {
  EXPECT_EQ(Changed("1.6 times the focal length").size(), cv::Size(320, 240));
  EXPECT_EQ(Changed("half the resolution").size(), cv::Size(160, 120));
  EXPECT_EQ(Changed("twice the resolution").size(), cv::Size(640, 480));
  EXPECT_EQ(Changed("portrait crop").size(), cv::Size(180, 240));
  EXPECT_EQ(Changed("turned by 90 degrees").size(), cv::Size(240, 320));
}

TEST(ImageChanges, ALongerLensShowsTheMiddleLarger) {
  cv::Mat larger;
  cv::resize(Picture()({60, 45, 200, 150}), larger, {320, 240}, 0, 0, cv::INTER_CUBIC);
  EXPECT_LT(cv::norm(Changed("1.6 times the focal length"), larger, cv::NORM_L1) / (320 * 240), 1);
}

// The tangent grows faster than the angle: the middle gets larger and the corners move inwards,
// while the ends of the horizontal axis stay.
TEST(ImageChanges, AFisheyeKeepsTheEndsOfTheAxisAndLeavesTheCornersBlack) {
  const cv::Mat bent = Changed("fisheye");
  EXPECT_EQ(bent.at<uint8_t>(0, 0), 0);
  EXPECT_NEAR(bent.at<uint8_t>(119, 318), Picture().at<uint8_t>(119, 318), 2);
  EXPECT_NEAR(bent.at<uint8_t>(119, 159), Picture().at<uint8_t>(119, 159), 2);
}

TEST(ImageChanges, LightAndBlurAreAsStated) {
  EXPECT_NEAR(Mean(Changed("dark, a fifth of the light")), 0.2 * Mean(Picture()), 1);
  EXPECT_GT(Mean(Changed("overexposed, twice the light")), 1.8 * Mean(Picture()));
  cv::Mat sharp;
  cv::Mat blurred;
  cv::Laplacian(Picture(), sharp, CV_32F);
  cv::Laplacian(Changed("motion blur, 1 % of the width"), blurred, CV_32F);
  EXPECT_LT(cv::norm(blurred), 0.8 * cv::norm(sharp));
  EXPECT_NEAR(Mean(Changed("motion blur, 1 % of the width")), Mean(Picture()), 1);
}

}  // namespace
}  // namespace waystone::bench
