// SPDX-License-Identifier: Apache-2.0
#include <cstdlib>
#include <fstream>
#include <limits>
#include <thread>

#include "core/base/natural_order.h"
#include "tests/builder/sources/temporary_folder.h"
#include "tests/core/image/made_heic.h"

namespace waystone {
namespace {

using Strings = std::vector<std::string>;

constexpr const char* kCamera =
    "camera_model: PINHOLE\nimage_width: 16\nimage_height: 12\n"
    "fx: 20\nfy: 21\ncx: 7.5\ncy: 5.5\n";

TEST(NaturalLessTest, ComparesNumbersAsNumbers) {
  EXPECT_TRUE(NaturalLess("img2.jpg", "img10.jpg"));
  EXPECT_TRUE(NaturalLess("a1b20", "a1b100"));
  EXPECT_TRUE(NaturalLess("img01", "img1"));  // equal as numbers: by bytes
  EXPECT_TRUE(NaturalLess("img", "img0"));
  EXPECT_TRUE(NaturalLess("a/z", "a-b/a"));
  EXPECT_TRUE(NaturalLess("99999999999999999999998", "99999999999999999999999"));
  EXPECT_FALSE(NaturalLess("img10", "img2"));
}

TEST(NaturalLessTest, IsAStrictWeakOrder) {
  const Strings names = {"", "0", "00", "1", "01", "001", "10", "2", "a", "a0", "a/1", "a-1", "A"};
  for (const std::string& a : names) {
    EXPECT_FALSE(NaturalLess(a, a)) << a;
    for (const std::string& b : names) {
      EXPECT_EQ(NaturalLess(a, b) || NaturalLess(b, a), a != b) << a << " " << b;
      for (const std::string& c : names) {
        const bool chained = NaturalLess(a, b) && NaturalLess(b, c);
        EXPECT_TRUE(!chained || NaturalLess(a, c)) << a << " " << b << " " << c;
      }
    }
  }
}

class FolderTest : public TemporaryFolder {};

TEST_F(FolderTest, GivesItsImagesInNaturalOrder) {
  for (const int i : {10, 2, 1}) WriteImage("img" + std::to_string(i) + ".png", i);
  Write("notes.txt", "not an image");
  Write("._img1.png", "what a Mac leaves behind");
  WriteImage("thumbs/img3.png");
  const auto source = Open();
  EXPECT_EQ(source->kind(), "folder");
  EXPECT_EQ(source->name(), folder_.filename());
  EXPECT_EQ(source->size(), 3);
  EXPECT_EQ(source->Announcement(), "Image folder, 3 frames 16x12");
  EXPECT_FALSE(source->camera());
  const std::vector<Frame> frames = AllFrames(*source);
  EXPECT_EQ(NamesOf(frames), (Strings{"img1.png", "img2.png", "img10.png"}));
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(frames[i].info.number, i);
    EXPECT_FALSE(frames[i].info.time_s);
    EXPECT_EQ(frames[i].error, "");
    ASSERT_EQ(frames[i].grey.type(), CV_8UC1);
  }
  EXPECT_EQ(frames[2].grey.at<uint8_t>(5, 5), 10);
  EXPECT_FALSE(source->Next());
}

TEST_F(FolderTest, TakesAllExtensionsInAnyCase) {
  for (const char* name : {"a.jpg", "b.JPEG", "c.png", "d.BMP", "e.pgm", "f.pnm"}) {
    WriteImage(name, 0, {16, 16});
  }
  WriteImage("g.webp", 0, {16, 16});
  const std::vector<uint8_t> heic = MakeHeic(cv::Mat(16, 16, CV_8UC1, cv::Scalar(70)));
  std::ofstream(folder_ / "h.HEIC", std::ios::binary)
      .write(reinterpret_cast<const char*>(heic.data()), std::ssize(heic));
  const auto source = Open();
  EXPECT_EQ(source->size(), 8);
  const std::vector<Frame> frames = AllFrames(*source);
  EXPECT_EQ(frames[7].info.source, "h.HEIC");
  ASSERT_EQ(frames[7].grey.size(), cv::Size(16, 16)) << frames[7].error;
  EXPECT_EQ(frames[7].grey.at<uint8_t>(3, 3), 70);
}

TEST_F(FolderTest, NameOfAPathWithASlashOrDots) {
  WriteImage("walk/a.png");
  EXPECT_EQ(OpenSource((folder_ / "walk/").string(), {})->name(), "walk");
  EXPECT_EQ(OpenSource((folder_ / "walk/../walk/.").string(), {})->name(), "walk");
}

TEST_F(FolderTest, EveryFromAndToCountFrames) {
  for (int i = 0; i < 10; ++i) WriteImage(std::to_string(i) + ".png");
  const auto source = Open({.every = 3, .from = 1, .to = 7});
  EXPECT_EQ(source->size(), 3);
  EXPECT_EQ(source->Announcement(), "Image folder, 10 frames 16x12, 3 used");
  const std::vector<Frame> frames = AllFrames(*source);
  EXPECT_EQ(NamesOf(frames), (Strings{"1.png", "4.png", "7.png"}));
  EXPECT_EQ(frames[1].info.number, 4);
  EXPECT_EQ(Open({.every = 100})->size(), 1);
  EXPECT_EQ(Open({.from = 9, .to = 1000})->size(), 1);
  ExpectError([&] { Open({.from = 10}); }, ErrorCode::kBadSource, {"10 frames", "--from"});
}

TEST_F(FolderTest, TheLargestStepTakesTheFirstFrame) {
  for (int i = 0; i < 3; ++i) WriteImage(std::to_string(i) + ".png");
  const auto source = Open({.every = std::numeric_limits<int>::max(), .from = 1});
  EXPECT_EQ(source->size(), 1);
  EXPECT_EQ(NamesOf(AllFrames(*source)), (Strings{"1.png"}));
}

TEST_F(FolderTest, BadOptionsAreRefused) {
  ExpectError([&] { Open({.every = 0}); }, ErrorCode::kBadOptions, {"source.every is 0"});
  ExpectError([&] { Open({.from = -1}); }, ErrorCode::kBadOptions, {"source.from is -1"});
  ExpectError([&] { Open({.from = 5, .to = 4}); }, ErrorCode::kBadOptions, {"--to is 4"});
}

TEST_F(FolderTest, BrokenFramesComeWithTheirError) {
  Write("0.jpg", "a letter, not an image");
  WriteImage("1.png");
  WriteImage("2.png", 0, {8, 6});
  Write("3.png", "");
  std::filesystem::create_symlink(folder_ / "gone.png", folder_ / "4.png");
  WriteImage("5.png");
  const auto source = Open();
  EXPECT_EQ(source->Announcement(), "Image folder, 6 frames 16x12");  // of the first sound one
  const std::vector<Frame> frames = AllFrames(*source);
  ASSERT_EQ(frames.size(), 6);
  const Strings parts = {"are text",       "", "it is 8x6, but the first frame is 16x12", "empty",
                         "does not exist", ""};
  for (int i = 0; i < 6; ++i) {
    EXPECT_EQ(frames[i].grey.empty(), !parts[i].empty()) << i;
    EXPECT_EQ(frames[i].error.empty(), parts[i].empty()) << i;
    EXPECT_NE(frames[i].error.find(parts[i]), std::string::npos) << frames[i].error;
  }
}

TEST_F(FolderTest, ImagesOverTheLimitsAreNotDecoded) {
  WriteImage("0.png", 0, {100, 100});
  WriteImage("1.png");
  SourceOptions options;
  options.limits.max_pixels = 1000;
  const auto source = Open(options);
  EXPECT_EQ(source->Announcement(), "Image folder, 2 frames 16x12");
  EXPECT_NE(source->Next()->error.find("10000 pixels"), std::string::npos);
}

TEST_F(FolderTest, NothingUsableSaysWhatIsThere) {
  ExpectError([&] { Open(); }, ErrorCode::kBadSource, {"it is empty", "expected a folder"});
  Write("a.txt", "");
  Write("b.tif", "");
  Write("c.doc", "");
  ExpectError([&] { Open(); }, ErrorCode::kBadSource, {"3 files", ".jpg .jpeg .png", "expected a"});
  Write("d.jpg", "text");
  Write("e.jpg", "text");
  ExpectError([&] { Open(); }, ErrorCode::kBadSource, {"none of the 2 frames", "d.jpg"});
}

TEST_F(FolderTest, FoldersAloneAreNamed) {
  for (const char* name : {"rig/a.png", "panorama/a.png", "x/a.png", "y/a.png"}) WriteImage(name);
  ExpectError([&] { Open(); }, ErrorCode::kBadSource,
              {"4 folders (panorama, rig, x, ...)", "use one of them"});
}

TEST_F(FolderTest, WhatIsNotThereOrIsOneImage) {
  ExpectError([&] { OpenSource((folder_ / "no").string(), {}); }, ErrorCode::kBadSource,
              {"does not exist"});
  ExpectError([&] { OpenSource("", {}); }, ErrorCode::kBadSource, {"empty"});
  WriteImage("a.png");
  ExpectError([&] { OpenSource((folder_ / "a.png").string(), {}); }, ErrorCode::kBadSource,
              {"single image", "use its folder"});
}

TEST_F(FolderTest, CameraBesideTheImages) {
  WriteImage("a.png");
  Write("camera.yaml", kCamera);
  EXPECT_EQ(Open()->camera(), (Camera{CameraModel::kPinhole, 16, 12, {20, 21, 7.5, 5.5}}));
}

TEST_F(FolderTest, AWalkWithItsTruthIsAnImageFolder) {
  WriteImage("images/000000.png", 7);
  WriteImage("plane_ids/000000.png", 99);
  WriteImage("plan.png", 99);
  Write("camera.yaml", kCamera);
  Write("poses.csv", "");
  const auto source = Open();
  EXPECT_EQ(source->name(), folder_.filename());
  EXPECT_TRUE(source->camera());
  const std::vector<Frame> frames = AllFrames(*source);
  EXPECT_EQ(NamesOf(frames), Strings{"images/000000.png"});
  EXPECT_EQ(frames[0].grey.at<uint8_t>(0, 0), 7);
  // Its images/ alone finds the camera too.
  EXPECT_TRUE(OpenSource((folder_ / "images").string(), {})->camera());
}

TEST_F(FolderTest, CameraOptionWinsAndSizesMustAgree) {
  WriteImage("a.png");
  Write("camera.yaml", "broken: [");
  SourceOptions options;
  options.camera_file = Write("other/mine.yaml", kCamera);
  EXPECT_TRUE(Open(options)->camera());
  ExpectError([&] { Open(); }, ErrorCode::kBadCamera, {"camera.yaml"});
  options.camera_file = Write("other/large.yaml",
                              "camera_model: PINHOLE\nimage_width: 640\nimage_height: 480\n"
                              "fx: 1\nfy: 1\ncx: 1\ncy: 1\n");
  ExpectError([&] { Open(options); }, ErrorCode::kBadCamera,
              {"640x480", "16x12", "use the calibration"});
}

TEST_F(FolderTest, PatternsMatchInNaturalOrder) {
  WriteImage("walk/img10.png");
  WriteImage("walk/img9.png");
  WriteImage("walk/other.png");
  Write("walk/img1.txt", "");
  const auto source = OpenSource((folder_ / "walk/img*").string(), {});
  EXPECT_EQ(source->kind(), "folder");
  EXPECT_EQ(source->name(), "walk");
  EXPECT_EQ(NamesOf(AllFrames(*source)), (Strings{"img9.png", "img10.png"}));
  WriteImage("run/img3.png");
  const auto deep = OpenSource((folder_ / "*/img*.png").string(), {});
  EXPECT_EQ(NamesOf(AllFrames(*deep)),
            (Strings{"run/img3.png", "walk/img9.png", "walk/img10.png"}));
  ExpectError([&] { OpenSource((folder_ / "walk/*.txt").string(), {}); }, ErrorCode::kBadSource,
              {"no image matches", "matches 1"});
}

// As a program gets them from a shell when they are quoted.
TEST_F(FolderTest, PatternsMayBeInTheHomeDirectory) {
  WriteImage("walk/img1.png", 7);
  const std::string home = std::getenv("HOME") ? std::getenv("HOME") : "";
  setenv("HOME", folder_.c_str(), 1);
  const auto source = OpenSource("~/walk/*.png", {});
  const auto deep = OpenSource("~/*/img1.png", {});
  setenv("HOME", home.c_str(), 1);
  EXPECT_EQ(source->name(), "walk");
  const std::vector<Frame> frames = AllFrames(*source);
  EXPECT_EQ(NamesOf(frames), (Strings{"img1.png"}));
  EXPECT_EQ(frames[0].grey.at<uint8_t>(5, 5), 7);
  EXPECT_EQ(NamesOf(AllFrames(*deep)), (Strings{"walk/img1.png"}));
}

TEST_F(FolderTest, AFolderWhoseNameLooksLikeAPattern) {
  WriteImage("walk[1]/a.png");
  EXPECT_EQ(OpenSource((folder_ / "walk[1]").string(), {})->size(), 1);
}

TEST_F(FolderTest, FramesDecodeOnAnyThreadAndOutliveTheirSource) {
  for (int i = 0; i < 20; ++i) WriteImage(std::to_string(i) + ".png", i);
  std::vector<EncodedFrame> encoded;
  {
    const auto source = Open();
    while (auto frame = source->NextEncoded()) encoded.push_back(std::move(*frame));
  }
  std::vector<Frame> frames(encoded.size());
  std::vector<std::thread> threads;
  for (int t = 0; t < 4; ++t) {
    threads.emplace_back([&, t] {
      for (size_t i = t; i < encoded.size(); i += 4) frames[i] = encoded[i].Decode();
    });
  }
  for (std::thread& thread : threads) thread.join();
  for (int i = 0; i < 20; ++i) EXPECT_EQ(frames[i].grey.at<uint8_t>(0, 0), i);
}

}  // namespace
}  // namespace waystone
