// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "localizer/localizer.h"
#include "tests/localizer/made_map.h"

namespace waystone {
namespace {

std::vector<uint8_t> AsBytes(const std::string& text) { return {text.begin(), text.end()}; }

// A grey PGM of one brightness.
std::vector<uint8_t> FlatImage(int width, int height) {
  return AsBytes("P5\n" + std::to_string(width) + " " + std::to_string(height) + "\n255\n" +
                 std::string(static_cast<size_t>(width) * height, '\x80'));
}

TEST(Localize, BytesThatAreNoImageAreABadImage) {
  const auto index = MadeIndex();
  for (const std::string text : {"", "x", "this is not an image, whatever it is called",
                                 "\xff\xd8\xff\xe0 a JPEG that is cut off"}) {
    const Answer answer = Localize(*index, AsBytes(text), "q.jpg", {});
    EXPECT_EQ(answer.verdict, Verdict::kBadImage) << text;
    EXPECT_EQ(answer.decided_by, DecidedBy::kBadImage);
    EXPECT_EQ(answer.image, "q.jpg");
    EXPECT_EQ(answer.map, "made");
    EXPECT_FALSE(answer.message.empty());
    EXPECT_EQ(answer.message.find('\n'), std::string::npos);
    EXPECT_FALSE(answer.planes.keyframe);
  }
}

TEST(Localize, AnImageOverTheLimitIsABadImage) {
  LocalizeOptions options;
  options.limits.max_pixels = 64 * 48 - 1;
  const Answer answer = Localize(*MadeIndex(), FlatImage(64, 48), "large.pgm", options);
  EXPECT_EQ(answer.verdict, Verdict::kBadImage);
  EXPECT_EQ(answer.decided_by, DecidedBy::kImageTooLarge);
  EXPECT_EQ(answer.image, "large.pgm");
}

TEST(Localize, APlainImageIsNotInTheMap) {
  const Answer answer = Localize(*MadeIndex(), FlatImage(64, 48), "wall.pgm", {});
  EXPECT_EQ(answer.verdict, Verdict::kNotInMap);
  EXPECT_EQ(answer.decided_by, DecidedBy::kFeatures);
  EXPECT_EQ(answer.image, "wall.pgm");
  EXPECT_GE(answer.timing.total_ms, answer.timing.decode_ms);
}

TEST(LocalizeImage, APlainImageIsNotInTheMap) {
  const Answer answer = LocalizeImage(*MadeIndex(), cv::Mat(480, 640, CV_8UC1, cv::Scalar(90)), {});
  EXPECT_EQ(answer.verdict, Verdict::kNotInMap);
}

}  // namespace
}  // namespace waystone
