// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <fstream>
#include <iterator>
#include <limits>
#include <opencv2/videoio.hpp>
#include <optional>

#include "tests/builder/sources/temporary_folder.h"

namespace waystone {
namespace {

std::string ReadAll(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

// Twelve frames of 64x48 at 10 a second; frame i is plain grey of 20 * i.
class VideoTest : public TemporaryFolder {
 protected:
  void SetUp() override {
    TemporaryFolder::SetUp();
    path_ = (folder_ / "walk.avi").string();
    cv::VideoWriter writer(path_, cv::CAP_OPENCV_MJPEG, cv::VideoWriter::fourcc('M', 'J', 'P', 'G'),
                           10, {64, 48});
    if (!writer.isOpened()) GTEST_SKIP() << "this OpenCV can't write MJPG";
    for (int i = 0; i < 12; ++i) writer.write(cv::Mat(48, 64, CV_8UC3, cv::Scalar::all(20 * i)));
    writer.release();
  }

  std::string path_;
};

TEST_F(VideoTest, FramesWithTimesAndNumbers) {
  const auto source = OpenSource(path_, {});
  EXPECT_EQ(source->kind(), "video");
  EXPECT_EQ(source->name(), "walk.avi");
  EXPECT_EQ(source->size(), 12);
  EXPECT_EQ(source->Announcement(), "Video, 12 frames 64x48");
  const std::vector<Frame> frames = AllFrames(*source);
  ASSERT_EQ(frames.size(), 12);
  for (int i = 0; i < 12; ++i) {
    EXPECT_EQ(frames[i].info.number, i);
    EXPECT_EQ(frames[i].info.source, "frame " + std::to_string(i));
    EXPECT_NEAR(frames[i].info.time_s.value(), 0.1 * i, 1e-6);
    EXPECT_EQ(frames[i].error, "");
    ASSERT_EQ(frames[i].grey.type(), CV_8UC1);
    EXPECT_NEAR(frames[i].grey.at<uint8_t>(20, 20), 20 * i, 6);
  }
}

TEST_F(VideoTest, FramesKeepTheirPixelsWhenTheNextOneComes) {
  const auto source = OpenSource(path_, {});
  std::vector<EncodedFrame> encoded;
  while (auto frame = source->NextEncoded()) encoded.push_back(std::move(*frame));
  ASSERT_EQ(encoded.size(), 12);
  for (int i = 0; i < 12; ++i) {
    EXPECT_NEAR(encoded[i].Decode().grey.at<uint8_t>(20, 20), 20 * i, 6);
  }
}

TEST_F(VideoTest, EveryFromAndTo) {
  const auto source = OpenSource(path_, {.every = 4, .from = 2, .to = 10});
  EXPECT_EQ(source->size(), 3);
  EXPECT_EQ(source->Announcement(), "Video, 12 frames 64x48, 3 used");
  const std::vector<Frame> frames = AllFrames(*source);
  ASSERT_EQ(frames.size(), 3);
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(frames[i].info.number, 2 + 4 * i);
    EXPECT_NEAR(frames[i].grey.at<uint8_t>(20, 20), 20 * (2 + 4 * i), 6);
    EXPECT_NEAR(frames[i].info.time_s.value(), 0.1 * (2 + 4 * i), 1e-6);
  }
  ExpectError([&] { OpenSource(path_, {.from = 12}); }, ErrorCode::kBadSource, {"12"});
}

TEST_F(VideoTest, TheLargestStepTakesTheFirstFrame) {
  constexpr int kMost = std::numeric_limits<int>::max();
  for (const std::optional<int> to : {std::optional<int>(), std::optional(kMost)}) {
    const auto source = OpenSource(path_, {.every = kMost, .from = 1, .to = to});
    EXPECT_EQ(source->size(), 1);
    const std::vector<Frame> frames = AllFrames(*source);
    ASSERT_EQ(frames.size(), 1u);
    EXPECT_EQ(frames[0].info.number, 1);
  }
}

TEST_F(VideoTest, CameraOption) {
  SourceOptions options;
  options.camera_file = Write("c.yaml",
                              "camera_model: SIMPLE_PINHOLE\nimage_width: 64\nimage_height: 48\n"
                              "f: 50\ncx: 31.5\ncy: 23.5\n");
  EXPECT_EQ(OpenSource(path_, options)->camera()->width, 64);
  options.camera_file = Write("d.yaml",
                              "camera_model: SIMPLE_PINHOLE\nimage_width: 48\nimage_height: 64\n"
                              "f: 50\ncx: 31.5\ncy: 23.5\n");
  ExpectError([&] { OpenSource(path_, options); }, ErrorCode::kBadCamera, {"48x64", "64x48"});
}

TEST_F(VideoTest, OversizedVideosAreRefused) {
  SourceOptions options;
  options.limits.max_pixels = 1000;
  ExpectError([&] { OpenSource(path_, options); }, ErrorCode::kImageTooLarge, {"64x48"});
}

TEST_F(VideoTest, WhatACutVideoLacksIsUnreadable) {
  std::filesystem::resize_file(path_, std::filesystem::file_size(path_) / 2);
  const std::vector<Frame> frames = AllFrames(*OpenSource(path_, {}));
  ASSERT_EQ(frames.size(), 12);
  const auto left = static_cast<int>(std::ranges::count(frames, "", &Frame::error));
  EXPECT_GE(left, 3);
  EXPECT_LE(left, 8);
  for (int i = 0; i < 12; ++i) {
    EXPECT_EQ(frames[i].info.number, i);
    if (i < left) {
      EXPECT_NEAR(frames[i].grey.at<uint8_t>(20, 20), 20 * i, 6);
    } else {
      EXPECT_NE(frames[i].error.find("ends after " + std::to_string(left) + " of the 12 frames"),
                std::string::npos)
          << frames[i].error;
    }
  }
  // Likewise where only some are taken, and for those that lie within what is left.
  EXPECT_EQ(AllFrames(*OpenSource(path_, {.every = 5})).size(), 3);
  for (const Frame& frame : AllFrames(*OpenSource(path_, {.to = 2}))) EXPECT_EQ(frame.error, "");
}

TEST_F(VideoTest, DamagedFramesAreUnreadableAndTheOthersKeepTheirNumbers) {
  std::string bytes = ReadAll(path_);
  size_t at = 0;
  for (int frame = 0; frame < 12; ++frame) {
    at = bytes.find("00dc", at + 1);
    ASSERT_NE(at, std::string::npos);
    if (frame == 3 || frame == 4 || frame == 7) bytes.replace(at + 8, 600, 600, '\0');
  }
  testing::internal::CaptureStderr();  // FFmpeg comments on it
  const std::vector<Frame> frames =
      AllFrames(*OpenSource(Write("damaged.avi", bytes).string(), {}));
  testing::internal::GetCapturedStderr();
  ASSERT_EQ(frames.size(), 12);
  for (int i = 0; i < 12; ++i) {
    EXPECT_EQ(frames[i].info.number, i);
    if (i == 3 || i == 4 || i == 7) {
      EXPECT_NE(frames[i].error.find("damaged"), std::string::npos) << i << frames[i].error;
    } else {
      ASSERT_EQ(frames[i].error, "") << i;
      EXPECT_NEAR(frames[i].grey.at<uint8_t>(20, 20), 20 * i, 6);
      EXPECT_NEAR(frames[i].info.time_s.value(), 0.1 * i, 1e-6);
    }
  }
}

// Its header counts the frames that were trimmed as well.
TEST_F(VideoTest, ATrimmedVideoLacksNothing) {
  path_ = (folder_ / "walk.mp4").string();
  cv::VideoWriter writer(path_, cv::CAP_FFMPEG, cv::VideoWriter::fourcc('m', 'p', '4', 'v'), 10,
                         {64, 48});
  if (!writer.isOpened()) GTEST_SKIP() << "this OpenCV can't write MP4";
  for (int i = 0; i < 12; ++i) writer.write(cv::Mat(48, 64, CV_8UC3, cv::Scalar::all(20 * i)));
  writer.release();
  EXPECT_EQ(AllFrames(*OpenSource(path_, {})).size(), 12);
  std::string bytes = ReadAll(path_);
  const size_t list = bytes.find("elst");
  if (list == std::string::npos) GTEST_SKIP() << "this OpenCV writes no edit list";
  bytes.replace(list + 12, 4, std::string("\0\0\x02\x58", 4));  // 600 ms
  const auto source = OpenSource(Write("trimmed.mp4", bytes).string(), {});
  EXPECT_EQ(source->size(), 6);
  const std::vector<Frame> frames = AllFrames(*source);
  EXPECT_LE(frames.size(), 7);
  EXPECT_GE(frames.size(), 6);
  for (const Frame& frame : frames) EXPECT_EQ(frame.error, "");
}

TEST_F(VideoTest, WhatIsNoVideoIsRefused) {
  testing::internal::CaptureStderr();  // FFmpeg comments on it
  const std::string path = Write("walk.mp4", std::string("a letter\0\1", 10)).string();
  ExpectError([&] { OpenSource(path, {}); }, ErrorCode::kBadSource,
              {"walk.mp4", "FFmpeg", "expected"});
  testing::internal::GetCapturedStderr();
}

// FFmpeg would show a text, and open the files that a playlist names.
TEST_F(VideoTest, TextsAreNoVideos) {
  const std::vector<std::pair<std::string, std::string>> texts{
      {"notes.txt", "Turn left behind the lift.\n"},
      {"walk.ffconcat", "ffconcat version 1.0\nfile walk.avi\n"},
      {"walk.m3u8", "#EXTM3U\n#EXTINF:1,\nwalk.avi\n#EXT-X-ENDLIST\n"}};
  for (const auto& [name, text] : texts) {
    const std::string path = Write(name, text).string();
    ExpectError([&] { OpenSource(path, {}); }, ErrorCode::kBadSource, {name, "it is a text file"});
  }
}

}  // namespace
}  // namespace waystone
