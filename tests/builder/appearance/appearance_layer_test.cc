// SPDX-License-Identifier: Apache-2.0
#include "builder/appearance/appearance_layer.h"

#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include "core/base/error.h"
#include "tests/builder/appearance/drive.h"

namespace waystone {
namespace {

// A new image: assigning zeros to one would blacken all that share its pixels.
cv::Mat Black(const cv::Size& size) { return {size, CV_8UC1, cv::Scalar(0)}; }

void ExpectRefused(const std::vector<cv::Mat>& images, const std::vector<std::string>& parts) {
  try {
    BuildFromImages(images);
    ADD_FAILURE() << "nothing was thrown";
  } catch (const MapError& error) {
    EXPECT_EQ(error.code(), ErrorCode::kBadSource) << error.what();
    for (const std::string& part : parts) {
      EXPECT_NE(std::string(error.what()).find(part), std::string::npos) << error.what();
    }
  }
}

TEST(BuildAppearanceTest, IsTheSameForAnyNumberOfThreads) {
  const BuiltAppearance many = BuildFromImages(FirstPanoramas(12));
  tbb::task_arena one(1);
  EXPECT_EQ(one.execute([] { return BuildFromImages(FirstPanoramas(12)); }).layer, many.layer);
}

TEST(BuildAppearanceTest, SkipsAndNamesABlackPanorama) {
  std::vector<cv::Mat> images = FirstPanoramas(6);
  images[2] = Black(images[2].size());
  const BuiltAppearance result = BuildFromImages(images);
  EXPECT_EQ(result.report.skipped, 1);
  EXPECT_EQ(result.sequences[0].skipped, 1);
  EXPECT_EQ(result.layer.nodes.size(), 5);
  ASSERT_EQ(result.report.skipped_names.size(), 1);
  EXPECT_NE(result.report.skipped_names[0].find("image 2: "), std::string::npos);
}

TEST(BuildAppearanceTest, RefusesASequenceOfOne) {
  ExpectRefused(FirstPanoramas(1), {"'drive' has 1 usable panorama of 1 frame", "at least two"});
}

TEST(BuildAppearanceTest, RefusesASequenceThatIsAllBlack) {
  ExpectRefused(std::vector<cv::Mat>(3, cv::Mat::zeros(128, 256, CV_8UC1)),
                {"0 usable panoramas of 3 frames", "first: image 0"});
}

TEST(BuildAppearanceTest, StopsWhenToldToInTheMiddleOfAStage) {
  for (const std::string at : {"panoramas", "odometry", "loops", "poses"}) {
    int calls = 0;  // of that stage; the first one is before it begins
    const auto stop = [&](const BuildProgress& now) {
      return now.stage != at || (++calls == 1 && at != "panoramas" && at != "poses");
    };
    try {
      MemorySource source = ImagesSource(at == "loops" ? TheDrive().panoramas : FirstPanoramas(6));
      BuildAppearance({&source}, ShortDrive(), stop);
      ADD_FAILURE() << "nothing was thrown in " << at;
    } catch (const MapError& error) {
      EXPECT_EQ(error.code(), ErrorCode::kInterrupted);
    }
  }
}

}  // namespace
}  // namespace waystone
