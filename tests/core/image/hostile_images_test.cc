// SPDX-License-Identifier: Apache-2.0
// Images that were made to cost time or memory out of all proportion to their bytes.
#include <gtest/gtest.h>
#include <zlib.h>

#include <chrono>
#include <ctime>
#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <string_view>

#include "core/base/error.h"
#include "core/image/decode.h"

namespace waystone {
namespace {

using Bytes = std::vector<uint8_t>;

void AppendNumber(Bytes& bytes, uint32_t value) {
  for (int shift = 24; shift >= 0; shift -= 8)
    bytes.push_back(static_cast<uint8_t>(value >> shift));
}

Bytes Chunk(std::string_view name, const Bytes& data) {
  Bytes chunk;
  AppendNumber(chunk, static_cast<uint32_t>(data.size()));
  chunk.insert(chunk.end(), name.begin(), name.end());
  chunk.insert(chunk.end(), data.begin(), data.end());
  AppendNumber(chunk,
               static_cast<uint32_t>(crc32(0, &chunk[4], static_cast<uInt>(chunk.size() - 4))));
  return chunk;
}

Bytes Deflated(const Bytes& bytes) {
  Bytes deflated(compressBound(bytes.size()));
  uLongf size = deflated.size();
  EXPECT_EQ(compress2(deflated.data(), &size, bytes.data(), bytes.size(), 9), Z_OK);
  deflated.resize(size);
  return deflated;
}

// A grey PNG with these chunks before its data.
Bytes GreyPng(int width, int height, const Bytes& data, const Bytes& before_data = {}) {
  Bytes png = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};
  Bytes header;
  AppendNumber(header, static_cast<uint32_t>(width));
  AppendNumber(header, static_cast<uint32_t>(height));
  header.insert(header.end(), {8, 0, 0, 0, 0});
  for (const Bytes& part :
       {Chunk("IHDR", header), before_data, Chunk("IDAT", data), Chunk("IEND", {})}) {
    png.insert(png.end(), part.begin(), part.end());
  }
  return png;
}

// Zlib's stream of black rows behind `blocks` empty stored blocks.
Bytes BlackRows(int width, int height, int blocks) {
  const Bytes whole = Deflated(Bytes(static_cast<size_t>(width + 1) * height));
  Bytes data(whole.begin(), whole.begin() + 2);
  for (int i = 0; i < blocks; ++i) data.insert(data.end(), {0, 0, 0, 0xFF, 0xFF});
  data.insert(data.end(), whole.begin() + 2, whole.end());
  return data;
}

std::string RefusalText(const Bytes& bytes, const DecodeLimits& limits = {}) {
  try {
    DecodeGrey(bytes, limits);
  } catch (const MapError& error) {
    return error.what();
  }
  return "";
}

double SecondsOf(const Bytes& bytes) {
  const auto start = std::chrono::steady_clock::now();
  EXPECT_FALSE(DecodeGrey(bytes).empty());
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

// 8 MB that inflate to 8 GB of comments: 11 s and more.
TEST(HostilePng, CommentsAreNotInflated) {
  Bytes text = {'k', 0, 0};
  const Bytes deflated = Deflated(Bytes(7'900'000));
  text.insert(text.end(), deflated.begin(), deflated.end());
  const Bytes chunk = Chunk("zTXt", text);
  Bytes chunks;
  for (int i = 0; i < 990; ++i) chunks.insert(chunks.end(), chunk.begin(), chunk.end());
  EXPECT_LT(SecondsOf(GreyPng(100, 100, BlackRows(100, 100, 0), chunks)), 3);
}

TEST(HostilePng, MoreDataThanThePixelsNeedAreRefused) {
  EXPECT_EQ(RefusalText(GreyPng(100, 100, BlackRows(100, 100, 1000))), "");
  EXPECT_EQ(RefusalText(GreyPng(100, 100, BlackRows(100, 100, 4'000'000))),
            "the PNG has 20.0 MB of image data, but 100x100 pixels need at most 0.1 MB; save it "
            "again");
}

TEST(HostilePng, ManySmallBlocksAreRefused) {
  const std::string refusal = RefusalText(GreyPng(8000, 6000, BlackRows(8000, 6000, 2'000'000)));
  EXPECT_NE(refusal.find("blocks of compressed data"), std::string::npos) << refusal;
}

TEST(HostilePng, HeadersThatMakeNoSenseAreRefused) {
  Bytes png = GreyPng(4, 4, BlackRows(4, 4, 0));
  EXPECT_EQ(RefusalText(png), "");
  for (const auto& [depth, colour] : {std::pair(3, 0), {4, 2}, {16, 3}, {8, 5}, {8, 7}, {0, 0}}) {
    png[24] = static_cast<uint8_t>(depth);
    png[25] = static_cast<uint8_t>(colour);
    EXPECT_NE(RefusalText(png).find("colour type"), std::string::npos) << depth << " " << colour;
  }
}

TEST(HostilePng, PixelsOfManyBytesAreFewer) {
  Bytes png = GreyPng(4, 4, BlackRows(4, 4, 0));
  const int64_t bytes = ReadImageHeader(png).inflated_bytes;
  EXPECT_EQ(RefusalText(png, {.max_inflated_bytes = bytes}), "");
  EXPECT_NE(RefusalText(png, {.max_inflated_bytes = bytes - 1}).find("MB of pixels"),
            std::string::npos);
  png = GreyPng(8000, 6000, {});
  png[25] = 2;  // red, green and blue
  EXPECT_NO_THROW(CheckLimits(ReadImageHeader(png), {}));
  png[25] = 6;  // and alpha
  EXPECT_NE(RefusalText(png).find("192 MB of pixels"), std::string::npos) << RefusalText(png);
}

// What is left out has no part in the pixels.
TEST(HostilePng, PixelsStayAsTheyAre) {
  cv::Mat image(40, 50, CV_8UC4);
  cv::randu(image, 0, 256);
  cv::Mat deep(40, 50, CV_16UC3);
  cv::randu(deep, 0, 65536);
  const cv::Mat bits = image.reshape(1) > 100;
  for (const cv::Mat& each : {image, deep, bits}) {
    Bytes png;
    cv::imencode(".png", each, png, {cv::IMWRITE_PNG_BILEVEL, each.channels() == 1});
    const Bytes gamma = Chunk("gAMA", {0, 0, 0x10, 0});
    png.insert(png.begin() + 33, gamma.begin(), gamma.end());
    EXPECT_EQ(cv::norm(DecodeGrey(png), cv::imdecode(png, cv::IMREAD_GRAYSCALE)), 0);
    EXPECT_EQ(cv::norm(DecodeColour(png), cv::imdecode(png, cv::IMREAD_COLOR)), 0);
  }
}

class HostileJpeg : public testing::Test {
 protected:
  HostileJpeg() {
    cv::Mat image(17, 31, CV_8UC3);
    cv::randu(image, 0, 256);
    cv::imencode(".jpg", image, baseline_);
    cv::imencode(".jpg", image, progressive_, {cv::IMWRITE_JPEG_PROGRESSIVE, 1});
  }
  static size_t FrameAt(const Bytes& jpeg, uint8_t marker) {
    for (size_t i = 0; i + 1 < jpeg.size(); ++i) {
      if (jpeg[i] == 0xFF && jpeg[i + 1] == marker) return i + 1;
    }
    ADD_FAILURE() << "no frame header";
    return 0;
  }

  Bytes baseline_;
  Bytes progressive_;
};

TEST_F(HostileJpeg, ArithmeticCodingIsRefused) {
  for (auto [jpeg, marker] : {std::pair(baseline_, 0xC0), std::pair(progressive_, 0xC2)}) {
    const int other = marker == 0xC0 ? 0xC9 : 0xCA;
    jpeg[FrameAt(jpeg, static_cast<uint8_t>(marker))] = static_cast<uint8_t>(other);
    EXPECT_NE(RefusalText(jpeg).find("arithmetic-coded"), std::string::npos) << RefusalText(jpeg);
  }
}

TEST_F(HostileJpeg, ScansOfLargeImagesAreFewer) {
  const int scans = ReadImageHeader(progressive_).scans;
  EXPECT_EQ(RefusalText(progressive_, {.max_scan_pixels = scans * 17 * 31}), "");
  EXPECT_NE(RefusalText(progressive_, {.max_scan_pixels = scans * 17 * 31 - 1}).find("together"),
            std::string::npos);
  EXPECT_EQ(RefusalText(baseline_, {.max_scan_pixels = 1}), "");
}

// 48 megapixels without chroma subsampling take 336 MB.
TEST_F(HostileJpeg, MemoryIsKnownBeforehand) {
  EXPECT_EQ(ReadImageHeader(baseline_).decode_bytes, 0);
  // 32 x 24 of brightness and twice 16 x 16 of halved chroma, and the image.
  const int64_t bytes = 2 * (32 * 24 + 2 * 16 * 16) + 31 * 17;
  EXPECT_EQ(ReadImageHeader(progressive_).decode_bytes, bytes);
  EXPECT_EQ(RefusalText(progressive_, {.max_decode_bytes = bytes}), "");
  EXPECT_NE(RefusalText(progressive_, {.max_decode_bytes = bytes - 1}).find("MB to decode"),
            std::string::npos);
  Bytes large = progressive_;
  const size_t at = FrameAt(large, 0xC2);
  for (const auto& [offset, value] : {std::pair(4, 6000), std::pair(6, 8000)}) {
    large[at + offset] = static_cast<uint8_t>(value / 256);
    large[at + offset + 1] = static_cast<uint8_t>(value % 256);
  }
  EXPECT_EQ(ReadImageHeader(large).decode_bytes, 192'000'000);
  large[at + 10] = 0x11;  // the sampling of the first component: all alike now
  EXPECT_NE(RefusalText(large).find("takes 336 MB"), std::string::npos) << RefusalText(large);
}

#ifndef WAYSTONE_SANITIZED  // needs memory and time of its own

// A line of /proc/self/status, in bytes.
int64_t StatusBytes(const std::string& field) {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);) {
    if (line.starts_with(field + ":")) return std::stoll(line.substr(field.size() + 1)) * 1024;
  }
  return 0;
}

double ProcessSeconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

// As many pixels as are accepted: a PNG of the most data, and a JPEG that is kept whole until its
// last scan.
TEST(HostileImages, TheLargestTakeBoundedMemoryAndTime) {
  for (const std::string extension : {".png", ".jpg"}) {
    SCOPED_TRACE(extension);
    Bytes bytes;
    {
      cv::Mat image(6000, 8000, CV_8UC3);
      cv::randu(image, 0, extension == ".jpg" ? 60 : 1);
      cv::imencode(extension, image, bytes,
                   {cv::IMWRITE_JPEG_PROGRESSIVE, 1, cv::IMWRITE_PNG_COMPRESSION, 1});
    }
    std::ofstream("/proc/self/clear_refs") << 5;  // the peak starts anew
    const int64_t before = StatusBytes("VmRSS");
    const double start = ProcessSeconds();
    EXPECT_EQ(DecodeGrey(bytes).cols, 8000);
    EXPECT_LT(ProcessSeconds() - start, 2);
    EXPECT_LT(StatusBytes("VmHWM") - before, 305'000'000);
  }
}

#endif

}  // namespace
}  // namespace waystone
