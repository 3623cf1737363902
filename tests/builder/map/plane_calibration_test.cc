// SPDX-License-Identifier: Apache-2.0
#include "builder/calibration/plane_calibration.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <opencv2/imgproc.hpp>
#include <set>

#include "builder/calibration/rendered_negatives.h"
#include "builder/calibration/stored_keyframes.h"
#include "core/base/error.h"
#include "core/features/features.h"
#include "core/image/encode.h"
#include "localizer/verdict/verdict_model.h"
#include "tests/builder/map/stage.h"

namespace waystone {
namespace {

TEST(KeyframeSample, IsSpreadOverAllThatWasAdded) {
  Features features;
  features.type = FeatureType::kSift;
  for (int count : {1, 7, 8, 9, 30, 100, 1000}) {
    KeyframeSample sample(8);
    for (int k = 1; k <= count; ++k) sample.Add(KeyframeId{k}, features);
    const auto& queries = sample.keyframes();
    ASSERT_LE(queries.size(), 8u) << count;
    ASSERT_GE(static_cast<int>(queries.size()), std::min(count, 4)) << count;
    EXPECT_EQ(queries.front().keyframe.value, 1);
    EXPECT_GE(2 * queries.back().keyframe.value, count) << "the last half of " << count;
    for (size_t i = 2; i < queries.size(); ++i) {
      EXPECT_EQ(queries[i].keyframe.value - queries[i - 1].keyframe.value,
                queries[1].keyframe.value - queries[0].keyframe.value)
          << count;
    }
  }
}

std::vector<SampledKeyframe> QueriesOf(const MapData& map) {
  std::vector<SampledKeyframe> queries;
  for (const Keyframe& keyframe : map.keyframes) {
    queries.push_back(
        {keyframe.id, ExtractFeatures(TheStage().frames[keyframe.frame], FeatureOptions{})});
  }
  return queries;
}

// Pictures may be wider than the working image.
TEST(FeaturesOfPicture, AreThoseOfTheKeyframeAtAnySizeOfThePicture) {
  const cv::Mat& frame = TheStage().frames[0];
  Keyframe keyframe;
  keyframe.width = frame.cols;
  keyframe.height = frame.rows;
  cv::Mat large;
  cv::resize(frame, large, {}, 1.5, 1.5, cv::INTER_CUBIC);
  keyframe.picture = EncodeJpeg(large, 95);
  const auto features = FeaturesOfPicture(keyframe, {});
  ASSERT_TRUE(features);
  EXPECT_EQ(features->width, frame.cols);
  const Features own = ExtractFeatures(frame, {});
  int same = 0;
  for (const Keypoint& found : features->keypoints) {
    same += std::ranges::any_of(own.keypoints, [&](const Keypoint& keypoint) {
      return (PositionOf(keypoint) - PositionOf(found)).norm() < 0.5;
    });
  }
  EXPECT_GT(same, features->size() / 2);
  keyframe.picture = {1, 2, 3};
  EXPECT_FALSE(FeaturesOfPicture(keyframe, {}));
}

TEST(CalibrateVerdict, TellsTheMapsOwnPlacesFromChance) {
  const MapData& map = TheMap().map;
  const VerdictModel model = CalibrateVerdict(*MapIndex::Build(map), QueriesOf(map), {}, {});
  EXPECT_GE(model.positives, static_cast<int>(map.keyframes.size()) / 2);
  EXPECT_GE(model.negatives, 1);
  EXPECT_GT(EstimateProbability({60, 0.7}, model), 0.95);
  EXPECT_LT(EstimateProbability({5, 0.1}, model), 0.3);
}

TEST(CalibrateVerdict, IsTheSameOnAnyNumberOfThreads) {
  const MapData& map = TheMap().map;
  const auto index = MapIndex::Build(map);
  const std::vector<SampledKeyframe> queries = QueriesOf(map);
  const VerdictModel all = CalibrateVerdict(*index, queries, {}, {});
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  EXPECT_EQ(CalibrateVerdict(*index, queries, {}, {}), all);
}

TEST(CalibrateVerdict, WithoutQueriesTheGeneralModelHolds) {
  EXPECT_EQ(CalibrateVerdict(*MapIndex::Build(TheMap().map), {}, {}, {}), VerdictModel{});
}

TEST(CalibrateVerdict, LearnsThatAnotherBuildingIsNotInTheMap) {
  const MapData& map = TheMap().map;
  const auto index = MapIndex::Build(map);
  const std::vector<SampledKeyframe> queries = QueriesOf(map);
  const std::vector<Features> outside = CachedNegatives(3, FeatureOptions{});
  // The map's own photos, taken for photos of another building, are negatives that fit well.
  std::vector<Features> own;
  for (const SampledKeyframe& query : queries) own.push_back(query.features);
  CalibrationOptions options;
  options.fit.min_samples = 1;  // the stage is small
  const VerdictModel plain = CalibrateVerdict(*index, queries, {}, options);
  const VerdictModel with = CalibrateVerdict(*index, queries, outside, options);
  EXPECT_GE(with.negatives, plain.negatives);
  EXPECT_LT(EstimateProbability({5, 0.1}, with), 0.3);
  EXPECT_LT(EstimateProbability({60, 0.7}, CalibrateVerdict(*index, queries, own, options)),
            EstimateProbability({60, 0.7}, with));
}

TEST(RenderNegatives, AreTheSameOnAnyNumberOfThreads) {
  const auto all = RenderNegatives(2, FeatureOptions{});
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  const auto again = RenderNegatives(2, FeatureOptions{});
  ASSERT_EQ(again.size(), all.size());
  for (size_t i = 0; i < all.size(); ++i) {
    EXPECT_GT(all[i].size(), 200);
    EXPECT_EQ(again[i].keypoints, all[i].keypoints);
  }
}

TEST(CachedNegatives, AreThoseOfTheirOptions) {
  FeatureOptions few;
  few.max_features = 100;
  const std::vector<Features> two = RenderNegatives(2, {});
  const std::vector<Features> one_of_few = RenderNegatives(1, few);
  const auto expect_cached = [](int count, const FeatureOptions& options,
                                const std::vector<Features>& rendered) {
    const std::vector<Features> cached = CachedNegatives(count, options);
    ASSERT_EQ(cached.size(), rendered.size());
    for (size_t i = 0; i < cached.size(); ++i) {
      EXPECT_EQ(cached[i].keypoints, rendered[i].keypoints);
      EXPECT_EQ(cached[i].descriptors, rendered[i].descriptors);
    }
  };
  expect_cached(2, {}, two);
  expect_cached(2, {}, two);
  expect_cached(1, few, one_of_few);
  EXPECT_EQ(CachedNegatives(1, {}).size(), 1u);
}

TEST(BuildMap, StoresTheModelOfItsVerdict) {
  ASSERT_TRUE(TheMap().map.verdict);
  EXPECT_GT(TheMap().map.verdict->positives, 0);
}

TEST(CalibrationOptions, OutOfTheirRangeAreRefused) {
  CalibrationOptions options;
  options.max_keyframes = 1;
  EXPECT_THROW(options.Check(), MapError);
  options = CalibrationOptions{};
  options.rendered_negatives = -1;
  EXPECT_THROW(options.Check(), MapError);
}

}  // namespace
}  // namespace waystone
