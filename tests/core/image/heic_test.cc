// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <string>
#include <string_view>

#include "core/base/error.h"
#include "core/base/random.h"
#include "core/image/decode.h"
#include "core/image/exif.h"
#include "tests/core/image/made_heic.h"

namespace waystone {
namespace {

using Bytes = std::vector<uint8_t>;

// Noise, in which any sample in the wrong place shows.
cv::Mat Noise(int width, int height) {
  cv::Mat image(height, width, CV_8UC1);
  cv::RNG random(5);
  random.fill(image, cv::RNG::UNIFORM, 0, 256);
  return image;
}

void ExpectHeicRefusal(const Bytes& bytes, ErrorCode code, const std::string& part,
                       const DecodeLimits& limits = {}) {
  try {
    DecodeGrey(bytes, limits);
    ADD_FAILURE() << "was decoded; expected: " << part;
  } catch (const MapError& error) {
    EXPECT_EQ(error.code(), code) << error.what();
    EXPECT_NE(std::string(error.what()).find(part), std::string::npos) << error.what();
  }
}

size_t FindText(const Bytes& bytes, std::string_view text) {
  const auto found = std::search(bytes.begin(), bytes.end(), text.begin(), text.end());
  EXPECT_NE(found, bytes.end()) << text;
  return static_cast<size_t>(found - bytes.begin());
}

TEST(Heic, DecodesToThePixelsThatAPngHas) {
  const cv::Mat image = Noise(96, 48);
  Bytes png;
  cv::imencode(".png", image, png);
  for (const bool chroma : {false, true}) {
    for (const int bits : {8, 10}) {
      const Bytes heic = MakeHeic(image, {.bits = bits, .chroma = chroma});
      EXPECT_EQ(cv::norm(DecodeGrey(heic), DecodeGrey(png), cv::NORM_INF), 0) << chroma << bits;
      const cv::Mat colour = DecodeColour(heic);
      ASSERT_EQ(colour.type(), CV_8UC3);
      EXPECT_LE(cv::norm(colour, DecodeColour(png), cv::NORM_INF), 1) << chroma << bits;
    }
  }
}

TEST(Heic, AGridIsJoined) {
  const cv::Mat image = Noise(384, 128);
  const Bytes heic = MakeHeic(image, {.columns = 3, .rows = 2});
  const ImageHeader header = ReadImageHeader(heic);
  EXPECT_EQ(header.format, "heic");
  EXPECT_EQ(header.width, 384);
  EXPECT_EQ(header.height, 128);
  EXPECT_EQ(cv::norm(DecodeGrey(heic), image, cv::NORM_INF), 0);
}

// Phones write tiles of 512 px, which go beyond the image at its right and lower side.
TEST(Heic, AGridIsCutToTheImage) {
  const cv::Mat image = Noise(384, 128);
  Bytes heic = MakeHeic(image, {.columns = 3, .rows = 2});
  const Bytes grid = {0, 0, 1, 2, 384 / 256, 384 % 256, 0, 128};
  const auto at = std::search(heic.begin(), heic.end(), grid.begin(), grid.end());
  ASSERT_NE(at, heic.end());
  at[5] = 300 % 256;
  at[7] = 101;
  EXPECT_EQ(cv::norm(DecodeGrey(heic), image(cv::Rect(0, 0, 300, 101)), cv::NORM_INF), 0);
  at[7] = 64;  // the second row would lie beyond
  ExpectHeicRefusal(heic, ErrorCode::kBadImage, "300x64 pixels in 3x2 tiles");
}

TEST(Heic, LimitedRangeIsExpanded) {
  cv::Mat image(16, 16, CV_8UC1, cv::Scalar(16));
  image.colRange(8, 16) = 235;
  const cv::Mat grey = DecodeGrey(MakeHeic(image, {.full_range = false}));
  EXPECT_EQ(grey.at<uint8_t>(3, 3), 0);
  EXPECT_EQ(grey.at<uint8_t>(3, 12), 255);
}

// As with EXIF: answers and calibrations refer to the pixels where the camera put them.
TEST(Heic, RotationAndMirroringAreNotApplied) {
  const cv::Mat image = Noise(96, 48);
  EXPECT_EQ(cv::norm(DecodeGrey(MakeHeic(image, {.turned = true})), image, cv::NORM_INF), 0);
}

TEST(Heic, TheFocalLengthIsThatOfTheJpeg) {
  Bytes tiff = {'M', 'M', 0, 42, 0, 0, 0,    8,    0, 1, 0x87, 0x69, 0, 4, 0, 0,  0, 1, 0, 0, 0, 26,
                0,   0,   0, 0,  0, 1, 0xA4, 0x05, 0, 3, 0,    0,    0, 1, 0, 28, 0, 0, 0, 0, 0, 0};
  const Bytes heic = MakeHeic(Noise(96, 64), {.exif = tiff});
  const std::optional<ExifCamera> camera = ReadExifCamera(heic);
  ASSERT_TRUE(camera.has_value());
  EXPECT_EQ(camera->width, 96);
  EXPECT_EQ(camera->height, 64);
  EXPECT_NEAR(camera->focal_px, 28 / 43.2666 * std::hypot(96, 64), 0.01);
  EXPECT_FALSE(ReadExifCamera(MakeHeic(Noise(96, 64))).has_value());
  for (size_t end = 0; end < heic.size(); ++end) {
    EXPECT_FALSE(ReadExifCamera(Bytes(heic.begin(), heic.begin() + end)).has_value());
  }
}

TEST(Heic, EveryPrefixIsRefused) {
  const Bytes heic = MakeHeic(Noise(128, 64), {.columns = 2});
  for (size_t length = 0; length < heic.size(); ++length) {
    const Bytes prefix(heic.begin(), heic.begin() + length);
    try {
      DecodeGrey(prefix);
      FAIL() << length << " of " << heic.size() << " bytes were decoded";
    } catch (const MapError& error) {
      ASSERT_EQ(error.code(), ErrorCode::kBadImage) << error.what();
    }
  }
  ExpectHeicRefusal(Bytes(heic.begin(), heic.end() - 1), ErrorCode::kBadImage, "truncated after");
}

TEST(Heic, FlippedBytesNeverCrash) {
  const Bytes good = MakeHeic(Noise(128, 64), {.columns = 2});
  const int head = static_cast<int>(FindText(good, "mdat")) + 40;
  Random random(7);
  for (int i = 0; i < 3000; ++i) {
    Bytes damaged = good;
    for (int flips = 1 + random.Below(4); flips > 0; --flips) {
      damaged[random.Below(i % 4 == 0 ? static_cast<int>(good.size()) : head)] ^=
          1 << random.Below(8);
    }
    try {
      EXPECT_EQ(DecodeGrey(damaged, {.max_pixels = 1'000'000}).type(), CV_8UC1);
    } catch (const MapError& error) {
      EXPECT_TRUE(error.code() == ErrorCode::kBadImage ||
                  error.code() == ErrorCode::kImageTooLarge);
    }
  }
}

TEST(Heic, LimitsHoldBeforeDecoding) {
  const Bytes heic = MakeHeic(Noise(128, 64), {.columns = 2});
  EXPECT_NO_THROW(DecodeGrey(heic, {.max_pixels = 128 * 64}));
  ExpectHeicRefusal(heic, ErrorCode::kImageTooLarge, "128x64 = 8192", {.max_pixels = 128 * 64 - 1});
  const int64_t bytes = ReadImageHeader(heic).decode_bytes;
  EXPECT_EQ(bytes, 64 * 64 * (2 + 1) + 128 * 64);
  EXPECT_NO_THROW(DecodeGrey(heic, {.max_decode_bytes = bytes}));
  ExpectHeicRefusal(heic, ErrorCode::kImageTooLarge, "the HEIC takes",
                    {.max_decode_bytes = bytes - 1});
}

TEST(Heic, PicturesOfManyBytesAreRefused) {
  const Bytes heic = MakeHeic(Noise(128, 64), {.columns = 2});
  const int64_t bytes = ReadImageHeader(heic).hevc_bytes;
  EXPECT_GT(bytes, 128 * 64);  // samples are stored as they are
  EXPECT_LT(bytes, std::ssize(heic));
  EXPECT_NO_THROW(DecodeGrey(heic, {.max_hevc_bytes = bytes}));
  ExpectHeicRefusal(heic, ErrorCode::kImageTooLarge, "bytes of pictures",
                    {.max_hevc_bytes = bytes - 1});
}

// What the picture itself claims counts, not what the file says beside it.
TEST(Heic, AHugePictureBehindASmallClaimIsRefused) {
  const Bytes heic = MakeHeic(Noise(32, 32), {.claimed_width = 32768, .claimed_height = 32768});
  ExpectHeicRefusal(heic, ErrorCode::kImageTooLarge, "32768x32768");
  const Bytes tiles =
      MakeHeic(Noise(64, 32), {.columns = 2, .claimed_width = 32768, .claimed_height = 32768});
  ExpectHeicRefusal(tiles, ErrorCode::kBadImage, "64x32 pixels in 2x1 tiles of 32768x32768");
}

// Decoding costs what is coded, not what is shown.
TEST(Heic, PicturesOfWhichLittleIsShownAreRefused) {
  EXPECT_EQ(DecodeGrey(MakeHeic(Noise(128, 64), {.cut = 48})).size(), cv::Size(80, 64));
  ExpectHeicRefusal(MakeHeic(Noise(128, 64), {.cut = 64}), ErrorCode::kBadImage,
                    "shows 64x64 pixels of pictures of 128x64");
}

TEST(Heic, ManyPlacesOfNoBytesAreRefused) {
  Bytes heic = MakeHeic(Noise(128, 64), {.columns = 2});
  const size_t sizes = FindText(heic, "iloc") + 4 + 4;
  heic[sizes] = heic[sizes + 1] = 0;  // of numbers
  const size_t extents = sizes + 2 + 2 + 2 + 2;
  heic[extents] = heic[extents + 1] = 255;
  ExpectHeicRefusal(heic, ErrorCode::kBadImage, "in 65535 places without saying where");
}

TEST(Heic, TilesThatShareTheirBytesAreRefused) {
  const cv::Mat image = Noise(256, 64);
  Bytes heic = MakeHeic(image, {.columns = 4});
  // All tiles are the first.
  const size_t at = FindText(heic, "dimg") + 4;
  for (int i = 0; i < 4; ++i) heic[at + 4 + 2 * i + 1] = 1;
  EXPECT_NO_THROW(DecodeGrey(heic));  // four of a quarter: no more than the bytes
  const size_t data = FindText(heic, "mdat");
  Bytes shorter(heic.begin(), heic.begin() + data + 4 + (heic.size() - data) / 3);
  const size_t size = shorter.size() - data + 4;
  for (int i = 0; i < 4; ++i) shorter[data - 4 + i] = static_cast<uint8_t>(size >> 8 * (3 - i));
  ExpectHeicRefusal(shorter, ErrorCode::kBadImage, "truncated");  // the grid itself lies behind
}

TEST(Heic, ASecondDescriptionIsRefused) {
  const Bytes heic = MakeHeic(Noise(128, 64), {.columns = 2});
  for (const char* box : {"pitm", "iinf", "iloc", "iprp"}) {
    Bytes twice = heic;
    const size_t at = FindText(twice, box);
    const size_t size = twice[at - 2] * 256 + twice[at - 1];
    const Bytes copy(twice.begin() + at - 4, twice.begin() + at - 4 + size);
    twice.insert(twice.begin() + at - 4, copy.begin(), copy.end());
    const size_t meta = FindText(twice, "meta");
    const size_t longer = twice[meta - 2] * 256 + twice[meta - 1] + size;
    twice[meta - 2] = static_cast<uint8_t>(longer / 256);
    twice[meta - 1] = static_cast<uint8_t>(longer % 256);
    ExpectHeicRefusal(twice, ErrorCode::kBadImage, "has two boxes \"" + std::string(box) + "\"");
  }
  Bytes twice = heic;
  twice[FindText(twice, "infe") + 4 + 4 + 1] = 2;  // the first item is the second as well
  ExpectHeicRefusal(twice, ErrorCode::kBadImage, "describes item 2 twice");
}

TEST(Heic, OtherFilesOfBoxesAreNamed) {
  Bytes heic = MakeHeic(Noise(32, 32));
  Bytes other = heic;
  const std::string_view avif = "avif";
  std::copy(avif.begin(), avif.end(), other.begin() + 8);
  ExpectHeicRefusal(other, ErrorCode::kBadImage, "AVIF is not supported");
  other = heic;
  for (const size_t at : {8, 16, 20}) other[at] = 'x';
  ExpectHeicRefusal(other, ErrorCode::kBadImage, "a video or an image that isn't HEIC");
  other = heic;
  other[FindText(other, "hvc1")] = 'j';
  ExpectHeicRefusal(other, ErrorCode::kBadImage, "of type \"jvc1\"");
}

}  // namespace
}  // namespace waystone
