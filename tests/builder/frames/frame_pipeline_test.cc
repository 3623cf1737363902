// SPDX-License-Identifier: Apache-2.0
#include "builder/frames/frame_pipeline.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <atomic>
#include <chrono>
#include <thread>

#include "builder/frames/shrink.h"
#include "builder/sources/memory_source.h"
#include "core/base/error.h"
#include "core/image/encode.h"

namespace waystone {
namespace {

// Takes the brightness of each frame, in the order in which it gets them.
struct Brightness : Observation {
  double mean = 0;
};

class BrightnessLayer : public LayerBuilder {
 public:
  explicit BrightnessLayer(bool joined = true) : joined_(joined) {}

  std::string stage() const override { return "brightness"; }
  bool NeedsJoinedFrames() const override { return joined_; }
  void StartSequence(SequenceId id, const Source&) override { sequences.push_back(id); }
  std::unique_ptr<Observation> Observe(const Frame& frame) const override {
    ++observed;
    const int now = ++in_observe_;
    for (int most = most_at_once; now > most && !most_at_once.compare_exchange_weak(most, now);) {
    }
    // Early frames take longest, so that an unordered pipeline would mix them up.
    std::this_thread::sleep_for(std::chrono::milliseconds(frame.info.number % 4 == 0 ? 8 : 1));
    auto brightness = std::make_unique<Brightness>();
    brightness->info = frame.info;
    brightness->error = frame.error;
    if (!frame.images.empty()) brightness->mean = cv::mean(frame.images.front())[0];
    joined_seen = joined_seen || !frame.grey.empty();
    --in_observe_;
    return brightness;
  }
  void Add(std::unique_ptr<Observation> observation, ProgressReporter& progress) override {
    if (observation->info.number == fail_at) throw MapError(ErrorCode::kBadSource, "refused");
    progress.AddPanorama();
    waiting = std::max(waiting, observed - static_cast<int>(added.size()));
    added.push_back(static_cast<const Brightness&>(*observation).mean);
  }
  void FinishSequence(const FrameReport& sequence) override { reports.push_back(sequence); }
  void Finish(MapData& map, ProgressReporter&) override { map.info.name = "bright"; }

  int fail_at = -1;
  std::vector<SequenceId> sequences;
  std::vector<FrameReport> reports;
  std::vector<double> added;
  int waiting = 0;  // most frames that were observed and not added
  mutable std::atomic<int> observed = 0;
  mutable std::atomic<int> most_at_once = 0;
  mutable std::atomic<bool> joined_seen = false;

 private:
  bool joined_;
  mutable std::atomic<int> in_observe_ = 0;
};

// Frames of brightness 0, 1, 2, ...; each counts how often it is loaded.
struct CountedFrames {
  explicit CountedFrames(int count, int broken = -1) : loads(count) {
    for (int i = 0; i < count; ++i) {
      frames.emplace_back(FrameInfo{i, std::to_string(i), {}}, [this, i, broken] {
        ++loads[i];
        if (i == broken) throw MapError(ErrorCode::kBadImage, "no image");
        return cv::Mat(4, 4, CV_8UC1, cv::Scalar(i));
      });
    }
  }
  MemorySource Open() const { return MemorySource({.name = "counted", .frames = frames}); }

  std::vector<std::atomic<int>> loads;
  std::vector<EncodedFrame> frames;
};

TEST(FramePipeline, DecodesOnceAndAddsInOrderForEveryLayer) {
  const CountedFrames frames(40);
  for (const int threads : {1, 4}) {
    MemorySource source = frames.Open();
    BrightnessLayer first;
    BrightnessLayer second;
    LayerBuilder* const layers[] = {&first, &second};
    ProgressReporter progress;
    tbb::task_arena arena(threads);
    const Sequence sequence =
        arena.execute([&] { return ObserveSequence(source, SequenceId{7}, layers, progress); });
    EXPECT_EQ(sequence.id.value, 7);
    EXPECT_EQ(sequence.name, "counted");
    EXPECT_EQ(sequence.frames, 40);
    ASSERT_EQ(first.added.size(), 40U);
    for (int i = 0; i < 40; ++i) EXPECT_EQ(first.added[i], i);
    EXPECT_EQ(second.added, first.added);
    EXPECT_LE(first.waiting, 2 * threads + 1);
  }
  for (const auto& loads : frames.loads) EXPECT_EQ(loads, 2);  // once for each of the two runs
}

TEST(FramePipeline, ObservesSeveralFramesAtOnce) {
  const tbb::global_control four(tbb::global_control::max_allowed_parallelism, 4);
  const CountedFrames frames(40);
  MemorySource source = frames.Open();
  BrightnessLayer layer;
  tbb::task_arena(4).execute([&] { BuildLayer({&source}, layer); });
  EXPECT_GT(layer.most_at_once, 1);
}

TEST(FramePipeline, CountsAndNamesWhatALayerSkips) {
  const CountedFrames frames(5, 3);
  MemorySource source = frames.Open();
  BrightnessLayer layer;
  const MapData map = BuildLayer({&source}, layer);
  EXPECT_EQ(map.info.name, "bright");
  ASSERT_EQ(map.sequences.size(), 1U);
  EXPECT_EQ(map.sequences[0].skipped, 1);
  ASSERT_EQ(layer.reports.size(), 1U);
  EXPECT_EQ(layer.reports[0].frames, 5);
  EXPECT_EQ(layer.reports[0].skipped_names, std::vector<std::string>{"3: no image"});
  EXPECT_EQ(layer.added.size(), 5U);  // unusable frames are added too, with their error
}

TEST(FramePipeline, RefusesASequenceThatIsMostlyUnusable) {
  const auto code_of = [](int broken, double max_share) {
    std::vector<EncodedFrame> frames;
    for (int i = 0; i < 10; ++i) {
      frames.emplace_back(FrameInfo{i, std::to_string(i), {}}, [bad = i < broken] {
        if (bad) throw MapError(ErrorCode::kBadImage, "no image");
        return cv::Mat(4, 4, CV_8UC1, cv::Scalar(1));
      });
    }
    MemorySource source({.name = "walk", .frames = frames});
    BrightnessLayer layer;
    LayerBuilder* const layers[] = {&layer};
    ProgressReporter progress;
    try {
      ObserveSequence(source, SequenceId{1}, layers, progress, max_share);
    } catch (const MapError& error) {
      EXPECT_NE(std::string(error.what()).find("'walk'"), std::string::npos) << error.what();
      EXPECT_NE(std::string(error.what()).find("first: 0: no image"), std::string::npos);
      return error.code();
    }
    return ErrorCode::kInternal;
  };
  EXPECT_EQ(code_of(5, 0.5), ErrorCode::kInternal);
  EXPECT_EQ(code_of(6, 0.5), ErrorCode::kUnreadableFrames);
  EXPECT_EQ(code_of(6, 0.6), ErrorCode::kInternal);
  EXPECT_EQ(code_of(1, 0), ErrorCode::kUnreadableFrames);
  EXPECT_EQ(code_of(10, 0.5), ErrorCode::kBadSource);
  EXPECT_EQ(code_of(10, 1), ErrorCode::kBadSource);
  EXPECT_EQ(InfoOf(ErrorCode::kUnreadableFrames).exit_code, 4);
}

TEST(FramePipeline, JoinsARigsImagesOnlyForALayerThatWantsIt) {
  const CountedFrames frames(2);
  for (const bool wanted : {true, false}) {
    MemorySource source = frames.Open();
    BrightnessLayer layer(wanted);
    BuildLayer({&source}, layer);
    EXPECT_EQ(layer.joined_seen, wanted);
    EXPECT_EQ(layer.added[1], 1);
  }
}

TEST(FramePipeline, TellsProgressAndStops) {
  const CountedFrames frames(30);
  MemorySource source = frames.Open();
  BrightnessLayer layer;
  std::vector<BuildProgress> told;
  try {
    BuildLayer({&source}, layer, [&](const BuildProgress& now) {
      told.push_back(now);
      return now.done < 5;
    });
    FAIL();
  } catch (const MapError& error) {
    EXPECT_EQ(error.code(), ErrorCode::kInterrupted);
  }
  ASSERT_EQ(told.size(), 5U);
  EXPECT_EQ(told.back().stage, "brightness");
  EXPECT_EQ(told.back().total, 30);
  EXPECT_GE(told.back().panoramas, 5);
}

TEST(FramePipeline, PassesOnWhatALayerThrows) {
  const CountedFrames frames(30);
  MemorySource source = frames.Open();
  BrightnessLayer layer;
  layer.fail_at = 4;
  EXPECT_THROW(BuildLayer({&source}, layer), MapError);
  EXPECT_EQ(layer.added.size(), 4U);
  EXPECT_THROW(BuildLayer({}, layer), MapError);
}

TEST(FrameReport, NamesTheFirstTwenty) {
  FrameReport one;
  for (int i = 0; i < 15; ++i) one.Count({i, std::to_string(i), {}}, "bad");
  FrameReport sum;
  sum.Append(one);
  sum.Append(one);
  EXPECT_EQ(sum.skipped, 30);
  EXPECT_EQ(sum.skipped_names.size(), 20U);
  EXPECT_EQ(sum.skipped_names[15], "0: bad");
}

TEST(ShrinkToWidth, KeepsTheShapeAndNeverEnlarges) {
  const cv::Mat picture(100, 400, CV_8UC1, cv::Scalar(9));
  EXPECT_EQ(ShrinkToWidth(picture, 100).size(), cv::Size(100, 25));
  EXPECT_EQ(ShrinkToWidth(picture, 500).size(), picture.size());
  EXPECT_EQ(ShrinkToWidth(cv::Mat(1, 400, CV_8UC1, cv::Scalar(9)), 10).size(), cv::Size(10, 1));
  const cv::Mat tall(4 * kMaxPictureSide, 40, CV_8UC1, cv::Scalar(9));
  EXPECT_EQ(ShrinkToWidth(tall, 320).size(), cv::Size(10, kMaxPictureSide));
}

}  // namespace
}  // namespace waystone
