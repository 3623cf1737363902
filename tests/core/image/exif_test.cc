// SPDX-License-Identifier: Apache-2.0
#include "core/image/exif.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgcodecs.hpp>
#include <vector>

#include "core/base/random.h"

namespace waystone {
namespace {

using Bytes = std::vector<uint8_t>;

void Put(Bytes& bytes, uint32_t value, int size, bool big) {
  for (int i = 0; i < size; ++i) {
    bytes.push_back(static_cast<uint8_t>(value >> 8 * (big ? size - 1 - i : i)));
  }
}

void PutEntry(Bytes& bytes, uint32_t tag, uint32_t type, uint32_t value, bool big) {
  Put(bytes, tag, 2, big);
  Put(bytes, type, 2, big);
  Put(bytes, 1, 4, big);
  const int size = type == 3 ? 2 : 4;
  Put(bytes, value, size, big);
  Put(bytes, 0, 4 - size, big);
}

// A photo of 80 x 60 pixels that says so much about itself. width 0 leaves the pixels' tags out.
Bytes Photo(uint32_t focal_mm, bool big = false, uint32_t width = 0, uint32_t height = 0,
            uint32_t orientation = 1) {
  Bytes tiff = {'E', 'x', 'i', 'f', 0, 0};
  tiff.insert(tiff.end(), 2, big ? 'M' : 'I');
  Put(tiff, 42, 2, big);
  Put(tiff, 8, 4, big);
  Put(tiff, 2, 2, big);
  PutEntry(tiff, 0x0112, 3, orientation, big);
  PutEntry(tiff, 0x8769, 4, 8 + 2 + 2 * 12 + 4, big);
  Put(tiff, 0, 4, big);
  Put(tiff, width > 0 ? 3 : 1, 2, big);
  if (width > 0) PutEntry(tiff, 0xA002, 4, width, big);
  if (width > 0) PutEntry(tiff, 0xA003, 3, height, big);
  PutEntry(tiff, 0xA405, 3, focal_mm, big);
  Put(tiff, 0, 4, big);
  Bytes bytes;
  cv::imencode(".jpg", cv::Mat(60, 80, CV_8UC1, cv::Scalar(90)), bytes);
  Bytes segment = {0xFF, 0xE1};
  Put(segment, static_cast<uint32_t>(tiff.size()) + 2, 2, true);
  segment.insert(segment.end(), tiff.begin(), tiff.end());
  bytes.insert(bytes.begin() + 2, segment.begin(), segment.end());
  return bytes;
}

TEST(Exif, FocalLengthComesFromTheDiagonal) {
  for (const bool big : {false, true}) {
    const std::optional<ExifCamera> camera = ReadExifCamera(Photo(28, big));
    ASSERT_TRUE(camera.has_value());
    EXPECT_EQ(camera->width, 80);
    EXPECT_EQ(camera->height, 60);
    // 100 px are the diagonal, which 28 mm sees under 75.4 degrees.
    const double diagonal_deg = 2 * std::atan(50 / camera->focal_px) * 180 / M_PI;
    EXPECT_NEAR(diagonal_deg, 75.4, 0.05);
  }
}

TEST(Exif, ScaledPhotosAreTakenAndCroppedOnesNot) {
  EXPECT_TRUE(ReadExifCamera(Photo(28, true, 4000, 3000)).has_value());
  EXPECT_FALSE(ReadExifCamera(Photo(28, true, 3000, 4000)).has_value());
  EXPECT_FALSE(ReadExifCamera(Photo(28, true, 4000, 2250)).has_value());
}

TEST(Exif, OrientationIsRead) {
  for (const bool big : {false, true}) {
    for (uint32_t value = 1; value <= 8; ++value) {
      EXPECT_EQ(ReadExifOrientation(Photo(28, big, 0, 0, value)), static_cast<int>(value));
    }
    for (const uint32_t value : {0U, 9U, 65535U}) {
      EXPECT_EQ(ReadExifOrientation(Photo(28, big, 0, 0, value)), 1) << value;
    }
  }
  Bytes plain;
  cv::imencode(".png", cv::Mat(60, 80, CV_8UC1, cv::Scalar(90)), plain);
  EXPECT_EQ(ReadExifOrientation(plain), 1);
  EXPECT_EQ(ReadExifOrientation({}), 1);
  const Bytes good = Photo(28, true, 0, 0, 6);
  for (size_t size = 0; size < good.size(); ++size) {
    const int read = ReadExifOrientation(Bytes(good.begin(), good.begin() + int(size)));
    EXPECT_TRUE(read == 1 || read == 6) << size;
  }
}

TEST(Exif, WhatSaysNothingGivesNothing) {
  for (const uint32_t focal : {0U, 2U, 3001U, 65535U}) {
    EXPECT_FALSE(ReadExifCamera(Photo(focal)).has_value()) << focal;
  }
  Bytes plain;
  cv::imencode(".jpg", cv::Mat(60, 80, CV_8UC1, cv::Scalar(90)), plain);
  EXPECT_FALSE(ReadExifCamera(plain).has_value());
  cv::imencode(".png", cv::Mat(60, 80, CV_8UC1, cv::Scalar(90)), plain);
  EXPECT_FALSE(ReadExifCamera(plain).has_value());
  EXPECT_FALSE(ReadExifCamera({}).has_value());
}

// Cut anywhere and with any bytes changed: the sanitizers tell what a read outside would be.
TEST(Exif, DamagedDataIsReadSafely) {
  const Bytes good = Photo(28, true, 4000, 3000);
  Random random(7);
  int read = 0;
  const std::vector<uint8_t> frame = {0xFF, 0xC0};
  const auto size = std::search(good.begin(), good.end(), frame.begin(), frame.end()) + 9;
  for (auto end = good.begin(); end < size; ++end) {
    read += ReadExifCamera(Bytes(good.begin(), end)).has_value();
  }
  EXPECT_EQ(read, 0) << "the image's size is behind the end";
  for (int i = 0; i < 3000; ++i) {
    Bytes bytes = good;
    for (int k = 0; k < 4; ++k) {
      bytes[random.Below(120)] = static_cast<uint8_t>(random.Below(256));
    }
    const std::optional<ExifCamera> camera = ReadExifCamera(bytes);
    if (!camera) continue;
    EXPECT_TRUE(std::isfinite(camera->focal_px) && camera->focal_px > 0);
  }
}

}  // namespace
}  // namespace waystone
