// SPDX-License-Identifier: Apache-2.0
#include "core/image/encode.h"

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <string>
#include <vector>

#include "core/base/random.h"
#include "core/image/decode.h"

namespace waystone {
namespace {

// Blobs of all sizes, as photos have them.
cv::Mat Blobs(int type) {
  Random random(7);
  cv::Mat image(240, 320, type, cv::Scalar::all(120));
  for (int i = 0; i < 200; ++i) {
    const cv::Point centre(random.Below(320), random.Below(240));
    const cv::Scalar colour(random.Below(256), random.Below(256), random.Below(256));
    cv::circle(image, centre, 2 + random.Below(23), colour, cv::FILLED);
  }
  cv::GaussianBlur(image, image, {}, 1);
  return image;
}

double Psnr(const cv::Mat& a, const cv::Mat& b) {
  return 20 * std::log10(255 / (cv::norm(a, b, cv::NORM_L2) /
                                std::sqrt(static_cast<double>(a.total()) * a.channels())));
}

// The JPEG of most quality with at most so many bytes.
std::vector<uint8_t> JpegWithin(const cv::Mat& image, size_t bytes) {
  std::vector<uint8_t> best;
  for (int quality = 5; quality <= 95; quality += 5) {
    const std::vector<uint8_t> jpeg = EncodeJpeg(image, quality);
    if (jpeg.size() <= bytes) best = jpeg;
  }
  return best;
}

TEST(EncodePicture, IsNearerToTheImageThanAJpegOfAsManyBytes) {
  for (const int type : {CV_8UC1, CV_8UC3}) {
    const cv::Mat image = Blobs(type);
    const std::vector<uint8_t> picture = EncodePicture(image, 75);
    const std::vector<uint8_t> jpeg = JpegWithin(image, picture.size());
    ASSERT_FALSE(jpeg.empty());
    EXPECT_EQ(ReadImageHeader(picture).format, "webp");
    EXPECT_STREQ(MediaTypeOf(picture), "image/webp");
    const cv::Mat grey = DecodeGrey(EncodeJpeg(image, 100));
    EXPECT_GT(Psnr(DecodeGrey(picture), grey), 35);
    EXPECT_GT(Psnr(DecodeGrey(picture), grey), Psnr(DecodeGrey(jpeg), grey) + 2);
    EXPECT_EQ(picture, EncodePicture(image, 75));
  }
}

TEST(EncodePicture, HigherQualityIsTruerAndLarger) {
  const cv::Mat image = Blobs(CV_8UC1);
  const std::vector<uint8_t> low = EncodePicture(image, 40);
  const std::vector<uint8_t> high = EncodePicture(image, 95);
  EXPECT_LT(low.size(), high.size());
  EXPECT_LT(Psnr(DecodeGrey(low), image), Psnr(DecodeGrey(high), image));
}

TEST(EncodePicture, TakesTheLongestSides) {
  for (const cv::Size size : {cv::Size(kMaxPictureSide, 8), cv::Size(8, kMaxPictureSide)}) {
    const std::vector<uint8_t> picture = EncodePicture(cv::Mat(size, CV_8UC1, cv::Scalar(90)), 75);
    EXPECT_EQ(DecodeGrey(picture).size(), size);
  }
}

TEST(MediaTypeOf, IsThatOfTheBytes) {
  std::vector<uint8_t> png;
  cv::imencode(".png", Blobs(CV_8UC1), png);
  EXPECT_STREQ(MediaTypeOf(png), "image/png");
  EXPECT_STREQ(MediaTypeOf(EncodeJpeg(Blobs(CV_8UC1))), "image/jpeg");
  EXPECT_STREQ(MediaTypeOf(EncodePicture(Blobs(CV_8UC1), 75)), "image/webp");
  EXPECT_STREQ(MediaTypeOf({}), "application/octet-stream");
}

}  // namespace
}  // namespace waystone
