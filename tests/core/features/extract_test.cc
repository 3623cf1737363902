// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <opencv2/imgproc.hpp>
#include <string>
#include <thread>
#include <vector>

#include "core/base/error.h"
#include "core/base/random.h"
#include "core/features/features.h"
#include "core/features/match.h"
#include "tests/core/features/made_descriptors.h"

namespace waystone {
namespace {

// Overlapping rectangles and discs of random greys, softened as a lens would.
cv::Mat MadeImage(int width, int height, uint64_t seed, int shapes = 250) {
  Random random(seed);
  cv::Mat image(height, width, CV_8UC1, cv::Scalar(128));
  for (int i = 0; i < shapes; ++i) {
    const cv::Point centre(random.Below(width), random.Below(height));
    const cv::Scalar grey(random.Below(256));
    const int size = 4 + random.Below(25);
    if (random.Below(2) == 0) {
      cv::circle(image, centre, size / 2, grey, cv::FILLED);
    } else {
      cv::rectangle(image, {centre.x, centre.y, size, 4 + random.Below(25)}, grey, cv::FILLED);
    }
  }
  cv::GaussianBlur(image, image, {}, 0.8);
  return image;
}

FeatureOptions OptionsOf(FeatureType type, int max_features = 600) {
  FeatureOptions options;
  options.type = type;
  options.max_features = max_features;
  return options;
}

void ExpectSame(const Features& a, const Features& b) {
  EXPECT_EQ(a.type, b.type);
  EXPECT_EQ(a.width, b.width);
  EXPECT_EQ(a.height, b.height);
  EXPECT_EQ(a.keypoints, b.keypoints);
  EXPECT_EQ(a.descriptors, b.descriptors);
}

class Extraction : public testing::TestWithParam<FeatureType> {};

TEST_P(Extraction, NamesGoThereAndBack) {
  EXPECT_EQ(FeatureTypeByName(NameOf(GetParam())), GetParam());
}

TEST_P(Extraction, FeaturesAreWellFormed) {
  const Features features = ExtractFeatures(MadeImage(320, 240, 1), OptionsOf(GetParam()));
  ASSERT_GT(features.size(), 60);
  EXPECT_LE(features.size(), 600);
  EXPECT_EQ(features.type, GetParam());
  EXPECT_EQ(features.width, 320);
  EXPECT_EQ(features.height, 240);
  EXPECT_EQ(features.descriptors.rows(), features.size());
  EXPECT_EQ(features.descriptors.bytes(), DescriptorBytes(GetParam()));
  for (const Keypoint& keypoint : features.keypoints) {
    EXPECT_GE(keypoint.x_px, 0);
    EXPECT_LE(keypoint.x_px, 319);
    EXPECT_GE(keypoint.y_px, 0);
    EXPECT_LE(keypoint.y_px, 239);
    EXPECT_GT(keypoint.scale_px, 0);
    EXPECT_GE(keypoint.angle_rad, 0);
    EXPECT_LT(keypoint.angle_rad, 2 * std::numbers::pi_v<float>);
  }
}

TEST_P(Extraction, TheSameImageGivesTheSameFeaturesOnAnyThread) {
  const cv::Mat image = MadeImage(320, 240, 2);
  const Features expected = ExtractFeatures(image, OptionsOf(GetParam()));
  std::vector<Features> results(4);
  std::vector<std::thread> threads;
  for (Features& result : results) {
    threads.emplace_back([&] { result = ExtractFeatures(image, OptionsOf(GetParam())); });
  }
  for (std::thread& thread : threads) thread.join();
  for (const Features& result : results) ExpectSame(result, expected);
}

TEST_P(Extraction, APartOfALargerImageGivesWhatACopyOfItGives) {
  const cv::Mat large = MadeImage(400, 300, 3);
  const cv::Mat part = large(cv::Rect(33, 21, 301, 233));
  ExpectSame(ExtractFeatures(part, OptionsOf(GetParam())),
             ExtractFeatures(part.clone(), OptionsOf(GetParam())));
}

TEST_P(Extraction, LargeImagesAreReducedAndTheirFeaturesAreInPixelsOfTheSmallerCopy) {
  const cv::Mat small = MadeImage(320, 240, 5);
  cv::Mat large;
  cv::resize(small, large, {1280, 960}, 0, 0, cv::INTER_CUBIC);
  FeatureOptions options = OptionsOf(GetParam());
  const Features expected = ExtractFeatures(small, options);
  EXPECT_EQ(ImageSize(expected), small.size());
  EXPECT_EQ(ImageFromWorking(expected), Eigen::Matrix3d::Identity());
  options.working_pixels = 320 * 240;
  const Features found = ExtractFeatures(large, options);
  EXPECT_EQ(found.width, 320);
  EXPECT_EQ(found.height, 240);
  EXPECT_EQ(ImageSize(found), large.size());
  // Most features of the small image are found there again.
  int same = 0;
  for (const Keypoint& keypoint : expected.keypoints) {
    same += std::any_of(found.keypoints.begin(), found.keypoints.end(), [&](const Keypoint& k) {
      return std::hypot(k.x_px - keypoint.x_px, k.y_px - keypoint.y_px) < 0.5 &&
             std::abs(k.scale_px / keypoint.scale_px - 1) < 0.1;
    });
  }
  EXPECT_GT(same, 0.6 * expected.size());
  // The middle of a pixel of the small image is that of four by four of the large one.
  const Eigen::Vector3d there = ImageFromWorking(found) * Eigen::Vector3d(10, 20, 1);
  EXPECT_EQ(there, Eigen::Vector3d(41.5, 81.5, 1));
  options.working_pixels = 50'000'000;
  ExpectSame(ExtractFeatures(small, options), expected);
}

TEST_P(Extraction, OneFactorReducesAnImageOfAnySize) {
  FeatureOptions options = OptionsOf(GetParam());
  options.working_pixels = 20'000;
  for (const cv::Size size : {cv::Size(331, 217), cv::Size(217, 331), cv::Size(1000, 40)}) {
    const Features found = ExtractFeatures(MadeImage(size.width, size.height, 6), options);
    EXPECT_EQ(ImageSize(found), size);
    EXPECT_NEAR(found.width * found.height, options.working_pixels, 400);
    const double scale = static_cast<double>(size.width) / found.width;
    EXPECT_NEAR(found.height * scale, size.height, 0.6 * scale);
    EXPECT_EQ(ImageFromWorking(found)(0, 0), scale);
    EXPECT_EQ(ImageFromWorking(found)(1, 1), scale);
  }
}

TEST_P(Extraction, AtMostMaxFeatures) {
  const cv::Mat image = MadeImage(320, 240, 4);
  for (int most : {50, 100, 200}) {
    EXPECT_LE(ExtractFeatures(image, OptionsOf(GetParam(), most)).size(), most);
  }
}

TEST_P(Extraction, ImagesWithoutRoomOrWithoutTextureGiveNone) {
  for (const cv::Size size : {cv::Size(0, 0), cv::Size(1, 1), cv::Size(15, 300), cv::Size(300, 15),
                              cv::Size(16, 16), cv::Size(17, 40)}) {
    const Features features =
        ExtractFeatures(cv::Mat(size, CV_8UC1, cv::Scalar(90)), OptionsOf(GetParam()));
    EXPECT_EQ(features.size(), 0) << size;
    EXPECT_EQ(features.descriptors.rows(), 0);
    EXPECT_EQ(features.width, size.width);
    EXPECT_EQ(features.height, size.height);
  }
  for (int grey : {0, 128, 255}) {
    const cv::Mat flat(240, 320, CV_8UC1, cv::Scalar(grey));
    EXPECT_EQ(ExtractFeatures(flat, OptionsOf(GetParam())).size(), 0);
  }
}

// Small images with texture must come through without a crash, whatever they give.
TEST_P(Extraction, TinyImagesWithTextureAreTaken) {
  for (const cv::Size size : {cv::Size(16, 16), cv::Size(17, 23), cv::Size(40, 16),
                              cv::Size(640, 16), cv::Size(16, 480), cv::Size(33, 33)}) {
    const cv::Mat image = MadeImage(size.width, size.height, 5, 20);
    const Features features = ExtractFeatures(image, OptionsOf(GetParam()));
    EXPECT_EQ(features.descriptors.rows(), features.size()) << size;
  }
}

// Of a long thin image the working image is thinner still.
TEST_P(Extraction, ImagesThatBecomeTooThinHaveNoFeatures) {
  const cv::Mat image = MadeImage(16, 200'000, 5, 20);
  EXPECT_EQ(ExtractFeatures(image, OptionsOf(GetParam())).size(), 0);
  const cv::Mat longer(2'300'000, 16, CV_8UC1, cv::Scalar(90));
  EXPECT_EQ(ExtractFeatures(longer, OptionsOf(GetParam())).size(), 0);
}

// Share of the mutual matches whose positions agree with the true motion: within 1.5 px and, since
// large features are found in a small copy of the image, within a share of their size.
double ShareOfCorrect(const Features& a, const Features& b, const cv::Matx23d& b_from_a) {
  const std::vector<Match> matches = MatchDescriptors(a.descriptors, b.descriptors, a.type, {});
  EXPECT_GT(matches.size(), 40u);
  int correct = 0;
  for (const Match& match : matches) {
    const Keypoint& from = a.keypoints[match.a];
    const Keypoint& to = b.keypoints[match.b];
    const cv::Vec2d moved = b_from_a * cv::Vec3d(from.x_px, from.y_px, 1);
    const double error = std::hypot(moved[0] - to.x_px, moved[1] - to.y_px);
    correct += error < 1.5 + 0.03 * to.scale_px;
  }
  return static_cast<double>(correct) / static_cast<double>(matches.size());
}

TEST_P(Extraction, AShiftedImageMatchesItselfWhereItShould) {
  const cv::Mat large = MadeImage(420, 330, 6);
  const Features a = ExtractFeatures(large(cv::Rect(40, 40, 320, 240)), OptionsOf(GetParam()));
  const Features b = ExtractFeatures(large(cv::Rect(51, 23, 320, 240)), OptionsOf(GetParam()));
  EXPECT_GT(ShareOfCorrect(a, b, {1, 0, -11, 0, 1, 17}), 0.95);
}

TEST_P(Extraction, ARotatedImageMatchesItselfWhereItShould) {
  const cv::Mat image = MadeImage(320, 320, 7);
  const cv::Mat turn = cv::getRotationMatrix2D({159.5f, 159.5f}, 35, 1.0);
  cv::Mat rotated;
  cv::warpAffine(image, rotated, turn, image.size(), cv::INTER_CUBIC, cv::BORDER_REFLECT);
  const Features a = ExtractFeatures(image, OptionsOf(GetParam()));
  const Features b = ExtractFeatures(rotated, OptionsOf(GetParam()));
  EXPECT_GT(ShareOfCorrect(a, b, cv::Matx23d(turn.ptr<double>())), 0.85);
}

// Orientation is clockwise as seen (x to y): an image turned by a quarter clockwise turns its
// keypoints by +pi/2.
TEST_P(Extraction, AnglesTurnWithTheImage) {
  const cv::Mat image = MadeImage(300, 300, 8);
  cv::Mat turned;
  cv::rotate(image, turned, cv::ROTATE_90_CLOCKWISE);
  const Features a = ExtractFeatures(image, OptionsOf(GetParam()));
  const Features b = ExtractFeatures(turned, OptionsOf(GetParam()));
  const std::vector<Match> matches = MatchDescriptors(a.descriptors, b.descriptors, a.type, {});
  ASSERT_GT(matches.size(), 40u);
  int right = 0;
  for (const Match& match : matches) {
    const double turn = b.keypoints[match.b].angle_rad - a.keypoints[match.a].angle_rad;
    right += std::abs(std::remainder(turn - std::numbers::pi / 2, 2 * std::numbers::pi)) < 0.2;
  }
  EXPECT_GT(right, 0.9 * static_cast<double>(matches.size()));
}

// Blurred discs at known positions between the pixels. Positions are those of pixels' centres.
TEST_P(Extraction, PositionsHaveNoBias) {
  Random random(21);
  cv::Mat_<float> image(480, 640, 60.0F);
  std::vector<Eigen::Vector2d> discs;
  for (int row = 40; row < 460; row += 50) {
    for (int column = 40; column < 620; column += 50) {
      discs.emplace_back(column + random.Uniform(0, 1), row + random.Uniform(0, 1));
      const double sigma = random.Uniform(2, 4);
      for (int y = row - 20; y <= row + 20; ++y) {
        for (int x = column - 20; x <= column + 20; ++x) {
          const double apart = (Eigen::Vector2d(x, y) - discs.back()).squaredNorm();
          image(y, x) += static_cast<float>(150 * std::exp(-apart / (2 * sigma * sigma)));
        }
      }
    }
  }
  cv::Mat grey;
  image.convertTo(grey, CV_8UC1);
  const Features features = ExtractFeatures(grey, OptionsOf(GetParam(), 2000));
  Eigen::Vector2d sum(0, 0);
  int count = 0;
  for (const Keypoint& keypoint : features.keypoints) {
    const auto nearest = std::ranges::min_element(discs, {}, [&](const Eigen::Vector2d& disc) {
      return (PositionOf(keypoint) - disc).norm();
    });
    const Eigen::Vector2d off = PositionOf(keypoint) - *nearest;
    if (off.norm() > 1) continue;  // of something else
    sum += off;
    ++count;
  }
  ASSERT_GE(count, 30);
  EXPECT_LT((sum / count).cwiseAbs().maxCoeff(), 0.1) << (sum / count).transpose();
}

// A sixth of the light, with grey values rounded again and the noise of a sensor.
TEST_P(Extraction, TheDarkHidesLittle) {
  const cv::Mat bright = MadeImage(320, 240, 12);
  cv::Mat dark;
  bright.convertTo(dark, CV_8UC1, 1 / 6.0, 10);
  Random random(13);
  for (uint8_t& value : cv::Mat_<uint8_t>(dark)) {
    value = cv::saturate_cast<uint8_t>(value + 0.5 * random.Normal());
  }
  const Features in_light = ExtractFeatures(bright, OptionsOf(GetParam(), 400));
  const Features in_dark = ExtractFeatures(dark, OptionsOf(GetParam(), 400));
  const std::vector<Match> matches =
      MatchDescriptors(in_light.descriptors, in_dark.descriptors, GetParam(), {0.85, true});
  const auto found = std::ranges::count_if(matches, [&](const Match& match) {
    return (PositionOf(in_light.keypoints[match.a]) - PositionOf(in_dark.keypoints[match.b]))
               .norm() < 2;
  });
  EXPECT_GE(found, 0.6 * in_light.size()) << "of " << in_light.size();
}

TEST(Clipped, WhereAnImageIsBlackOrWhite) {
  cv::Mat image = MadeImage(640, 480, 14);
  cv::Mat grey;
  image.convertTo(grey, CV_8UC1, 0.8, 20);
  EXPECT_TRUE(ExtractFeatures(grey, {}).clipped.empty());
  grey(cv::Rect(0, 0, 160, 480)) = 253;
  grey(cv::Rect(480, 240, 160, 240)) = 2;
  const Features features = ExtractFeatures(grey, {});
  for (const Eigen::Vector2d& x : {Eigen::Vector2d{0, 0}, {150, 479}, {639, 479}, {490, 250}}) {
    EXPECT_TRUE(IsClipped(features, x)) << x.transpose();
  }
  for (const Eigen::Vector2d& x : {Eigen::Vector2d{170, 240}, {630, 230}, {470, 479}}) {
    EXPECT_FALSE(IsClipped(features, x)) << x.transpose();
  }
}

INSTANTIATE_TEST_SUITE_P(Types, Extraction, testing::ValuesIn(kAllTypes),
                         [](const auto& type) { return std::string(NameOf(type.param)); });

TEST(RootSift, BytesAreAtMost127AndTheLengthIsAbout256) {
  const Features features = ExtractFeatures(MadeImage(320, 240, 9), OptionsOf(FeatureType::kSift));
  ASSERT_GT(features.size(), 60);
  int clipped = 0;
  for (int i = 0; i < features.size(); ++i) {
    double length2 = 0;
    bool at_limit = false;
    for (int k = 0; k < 128; ++k) {
      const int byte = features.descriptors.row(i)[k];
      ASSERT_LE(byte, 127);
      at_limit = at_limit || byte == 127;
      length2 += byte * byte;
    }
    // What is cut off at 127 shortens the few descriptors that have such an entry.
    EXPECT_LT(std::sqrt(length2), 262);
    EXPECT_GT(std::sqrt(length2), at_limit ? 180 : 250);
    clipped += at_limit;
  }
  EXPECT_LT(clipped, features.size() / 5);
}

// The stronger a feature, the earlier: fewer features are a prefix of more, but for keypoints of
// one place with several orientations, which the detector counts in its own way.
TEST(ExtractFeatures, StrongerFeaturesComeFirst) {
  const cv::Mat image = MadeImage(320, 240, 10);
  const Features few = ExtractFeatures(image, OptionsOf(FeatureType::kSift, 100));
  const Features many = ExtractFeatures(image, OptionsOf(FeatureType::kSift, 600));
  ASSERT_GE(few.size(), 90);
  ASSERT_GT(many.size(), few.size());
  for (int i = 0; i < 90; ++i) EXPECT_EQ(few.keypoints[i], many.keypoints[i]) << i;
}

TEST(ExtractFeatures, ALowerContrastThresholdFindsMore) {
  cv::Mat faint;
  MadeImage(320, 240, 11).convertTo(faint, CV_8UC1, 0.15, 100);
  FeatureOptions options = OptionsOf(FeatureType::kSift, 2000);
  options.contrast_threshold = 0.005;
  const int low = ExtractFeatures(faint, options).size();
  options.contrast_threshold = 0.04;
  EXPECT_GT(low, ExtractFeatures(faint, options).size());
}

TEST(ExtractFeatures, RefusesOtherImagesThanGreyOnes) {
  EXPECT_THROW(ExtractFeatures(cv::Mat(50, 50, CV_8UC3), {}), CheckFailure);
  EXPECT_THROW(ExtractFeatures(cv::Mat(50, 50, CV_32FC1), {}), CheckFailure);
}

void ExpectRefused(const FeatureOptions& options) {
  try {
    ExtractFeatures(cv::Mat(50, 50, CV_8UC1, cv::Scalar(0)), options);
    ADD_FAILURE() << "taken: " << options.max_features << " " << options.contrast_threshold;
  } catch (const MapError& error) {
    EXPECT_EQ(error.code(), ErrorCode::kBadOptions);
  }
}

TEST(FeatureOptions, OutOfTheirRangeAreRefused) {
  for (int most : {-1, 0, 49, 20001, std::numeric_limits<int>::max()}) {
    ExpectRefused({FeatureType::kSift, most, 0.02});
  }
  for (double contrast : {-0.1, 0.0, 1.0, std::numeric_limits<double>::quiet_NaN()}) {
    ExpectRefused({FeatureType::kSift, 500, contrast});
  }
  EXPECT_NO_THROW((FeatureOptions{FeatureType::kSift, 50, 0.5}.Check()));
  EXPECT_NO_THROW((FeatureOptions{FeatureType::kSift, 20000, 0.5}.Check()));
}

TEST(FeatureTypeByName, RefusesOtherNamesAndSaysWhichThereAre) {
  for (const char* name : {"", "SIFT", "surf", "sift "}) {
    try {
      FeatureTypeByName(name);
      ADD_FAILURE() << "'" << name << "' was taken";
    } catch (const MapError& error) {
      EXPECT_EQ(error.code(), ErrorCode::kBadOptions);
      EXPECT_NE(std::string(error.what()).find("sift, orb or akaze"), std::string::npos);
    }
  }
}

// These numbers are in map files.
TEST(FeatureType, StoredValuesNeverChange) {
  EXPECT_EQ(static_cast<int>(FeatureType::kSift), 0);
  EXPECT_EQ(static_cast<int>(FeatureType::kOrb), 1);
  EXPECT_EQ(static_cast<int>(FeatureType::kAkaze), 2);
  EXPECT_EQ(DescriptorBytes(FeatureType::kSift), 128);
  EXPECT_EQ(DescriptorBytes(FeatureType::kOrb), 32);
  EXPECT_EQ(DescriptorBytes(FeatureType::kAkaze), 61);
}

TEST(Descriptors, RefuseABlockThatIsNotWholeRows) {
  EXPECT_THROW(Descriptors(32, std::vector<uint8_t>(33)), CheckFailure);
  EXPECT_THROW(Descriptors(0, std::vector<uint8_t>(3)), CheckFailure);
  EXPECT_EQ(Descriptors(32, std::vector<uint8_t>(96)).rows(), 3);
  EXPECT_EQ(Descriptors().rows(), 0);
}

}  // namespace
}  // namespace waystone
