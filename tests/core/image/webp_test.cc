// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <string>
#include <string_view>

#include "core/base/error.h"
#include "core/image/decode.h"
#include "core/image/exif.h"

namespace waystone {
namespace {

using Bytes = std::vector<uint8_t>;

Bytes WebpPicture(int quality = 90) {
  cv::Mat image(61, 90, CV_8UC3, cv::Scalar(90, 140, 30));
  cv::circle(image, {40, 30}, 20, {10, 200, 250}, cv::FILLED);
  Bytes webp;
  EXPECT_TRUE(cv::imencode(".webp", image, webp, {cv::IMWRITE_WEBP_QUALITY, quality}));
  return webp;
}

void AppendWebp(Bytes& to, const Bytes& bytes) { to.insert(to.end(), bytes.begin(), bytes.end()); }

Bytes RiffChunk(std::string_view name, const Bytes& data) {
  Bytes chunk(name.begin(), name.end());
  for (int i = 0; i < 4; ++i) chunk.push_back(static_cast<uint8_t>(data.size() >> 8 * i));
  AppendWebp(chunk, data);
  if (data.size() % 2 != 0) chunk.push_back(0);
  return chunk;
}

// The extended form: a canvas, the image and these chunks.
Bytes Extended(const Bytes& webp, int width, int height, const Bytes& before, const Bytes& after) {
  Bytes chunks = {'W', 'E', 'B', 'P'};
  const auto w = static_cast<uint8_t>(width - 1);
  const auto h = static_cast<uint8_t>(height - 1);
  AppendWebp(chunks, RiffChunk("VP8X", {0x18, 0, 0, 0, w, 0, 0, h, 0, 0}));
  AppendWebp(chunks, before);
  chunks.insert(chunks.end(), webp.begin() + 12, webp.end());
  AppendWebp(chunks, after);
  return RiffChunk("RIFF", chunks);
}

Bytes Riff(const Bytes& lossless) {
  Bytes chunks = {'W', 'E', 'B', 'P'};
  AppendWebp(chunks, RiffChunk("VP8L", lossless));
  return RiffChunk("RIFF", chunks);
}

void ExpectWebpRefusalOf(ErrorCode code, const Bytes& bytes, const std::string& part) {
  try {
    DecodeGrey(bytes);
    ADD_FAILURE() << "was decoded; expected: " << part;
  } catch (const MapError& error) {
    EXPECT_EQ(error.code(), code);
    EXPECT_NE(std::string(error.what()).find(part), std::string::npos) << error.what();
  }
}

void ExpectWebpRefusal(const Bytes& bytes, const std::string& part) {
  ExpectWebpRefusalOf(ErrorCode::kBadImage, bytes, part);
}

TEST(Webp, DecodesAsTheLibraryDoes) {
  const Bytes webp = WebpPicture();
  EXPECT_EQ(cv::norm(DecodeGrey(webp), cv::imdecode(webp, cv::IMREAD_GRAYSCALE)), 0);
  EXPECT_EQ(cv::norm(DecodeColour(webp), cv::imdecode(webp, cv::IMREAD_COLOR)), 0);
}

// Alpha is coded losslessly; here it is rubbish that no decoder is to look at.
TEST(Webp, AlphaAndMetadataAreLeftOut) {
  const Bytes webp = WebpPicture();
  const Bytes extended =
      Extended(webp, 90, 61, RiffChunk("ALPH", Bytes(99, 0xFF)), RiffChunk("XMP ", Bytes(77, 'x')));
  EXPECT_EQ(ReadImageHeader(extended).width, 90);
  EXPECT_EQ(cv::norm(DecodeGrey(extended), DecodeGrey(webp)), 0);
}

TEST(Webp, TheFocalLengthIsThatOfTheJpeg) {
  Bytes tiff = {'M', 'M', 0, 42, 0, 0, 0,    8,    0, 1, 0x87, 0x69, 0, 4, 0, 0,  0, 1, 0, 0, 0, 26,
                0,   0,   0, 0,  0, 1, 0xA4, 0x05, 0, 3, 0,    0,    0, 1, 0, 28, 0, 0, 0, 0, 0, 0};
  for (const bool named : {false, true}) {
    Bytes exif = tiff;
    if (named) exif.insert(exif.begin(), {'E', 'x', 'i', 'f', 0, 0});
    const Bytes webp = Extended(WebpPicture(), 90, 61, {}, RiffChunk("EXIF", exif));
    const std::optional<ExifCamera> camera = ReadExifCamera(webp);
    ASSERT_TRUE(camera.has_value()) << named;
    EXPECT_NEAR(camera->focal_px, 28 / 43.2666 * std::hypot(90, 61), 0.01);
    EXPECT_EQ(DecodeGrey(webp).size(), cv::Size(90, 61));
  }
  EXPECT_FALSE(ReadExifCamera(WebpPicture()).has_value());
}

// As OpenCV's users write them who name no quality: with transforms, a palette, groups of codes.
TEST(Webp, LosslessOnesAreBounded) {
  cv::Mat noise(300, 400, CV_8UC3);
  cv::RNG random(3);
  random.fill(noise, cv::RNG::NORMAL, 128, 20);
  noise(cv::Rect(0, 0, 200, 300)) = cv::Scalar(3, 9, 27);
  cv::Mat smooth;
  cv::GaussianBlur(noise, smooth, {9, 9}, 3);
  noise(cv::Rect(100, 150, 300, 150)).copyTo(smooth(cv::Rect(100, 150, 300, 150)));
  cv::Mat few = (noise > 140) / 85;
  for (const cv::Mat& image : {noise, smooth, few, cv::Mat(5, 1, CV_8UC3, cv::Scalar(1, 2, 3))}) {
    Bytes webp;
    ASSERT_TRUE(cv::imencode(".webp", image, webp));
    const ImageHeader header = ReadImageHeader(webp);
    EXPECT_EQ(cv::Size(header.width, header.height), image.size());
    const int64_t of_pixels = 9 * static_cast<int64_t>(image.total());
    EXPECT_GE(header.decode_bytes, of_pixels + 13'000);
    EXPECT_LE(header.decode_bytes, of_pixels + 13'000 * 1000) << "the groups are misread";
    EXPECT_EQ(cv::norm(DecodeColour(webp), image, cv::NORM_INF), 0);
    EXPECT_NO_THROW(DecodeGrey(webp, {.max_decode_bytes = header.decode_bytes}));
    EXPECT_THROW(DecodeGrey(webp, {.max_decode_bytes = header.decode_bytes - 1}), MapError);
    for (size_t end = 0; end < webp.size(); end += 1 + webp.size() / 1000) {
      EXPECT_THROW(DecodeGrey(Bytes(webp.begin(), webp.begin() + end)), MapError) << end;
    }
  }
}

// 65536 groups of codes: no picture has them, and their tables would take 850 MB.
TEST(Webp, ManyGroupsAreRefused) {
  Bytes data = {0x2F};
  uint64_t pending = 0;
  int bits = 0;
  const auto put = [&](uint64_t value, int count) {
    pending |= value << bits;
    for (bits += count; bits >= 8; bits -= 8, pending >>= 8) {
      data.push_back(static_cast<uint8_t>(pending));
    }
  };
  put(1023, 14);
  put(1023, 14);
  put(0, 1 + 3 + 1 + 1);  // alpha, version, no transform, no cache
  put(1, 1);
  put(0, 3);       // a group for each block of 4 x 4 pixels
  put(0, 1);       // the map of the groups has no cache; every pixel is
  put(0x7FD, 11);  // green 255 (simple, one symbol, of 8 bits)
  put(0x7FD, 11);  // red 255
  for (int i = 0; i < 3; ++i) put(1, 4);
  put(0, 8);
  ExpectWebpRefusalOf(ErrorCode::kImageTooLarge, Riff(data), "the lossless WebP takes 861 MB");
}

TEST(Webp, WhatIsNotOneImageIsRefused) {
  const Bytes webp = WebpPicture();
  ExpectWebpRefusal(Extended(webp, 90, 61, RiffChunk("ANIM", Bytes(6)), {}), "animated");
  ExpectWebpRefusal(Extended(webp, 90, 60, {}, {}), "claims 90x60 pixels, but its image has 90x61");
  Bytes empty = webp;
  empty[12] = 'X';
  ExpectWebpRefusal(empty, "no image data");
}

TEST(Webp, ASmallerSizeInTheHeadIsDamage) {
  Bytes webp = WebpPicture();
  webp[4] = 60;
  webp[5] = webp[6] = webp[7] = 0;
  ExpectWebpRefusal(webp, "longer than the file says");
}

}  // namespace
}  // namespace waystone
