// SPDX-License-Identifier: Apache-2.0
#include "builder/planes/keyframe_selector.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "core/base/error.h"
#include "core/base/random.h"

namespace waystone {
namespace {

constexpr int kVisible = 100;  // features of a frame
constexpr int kLandmarks = 4000;

// Random ORB descriptors are so far apart that every landmark matches itself alone: two frames have
// as many matches as they have landmarks in common.
const Descriptors& Landmarks() {
  static const Descriptors landmarks = [] {
    Random random(1);
    std::vector<uint8_t> data(static_cast<size_t>(kLandmarks) * 32);
    for (uint8_t& byte : data) byte = random.Below(256);
    return Descriptors(32, std::move(data));
  }();
  return landmarks;
}

// A frame that sees the landmarks first to first + count - 1.
ExtractedFrame FrameAt(int number, int first, int count = kVisible) {
  ExtractedFrame frame;
  frame.info.number = number;
  frame.features.type = FeatureType::kOrb;
  frame.features.descriptors = Descriptors(32);
  for (int i = first; i < first + count; ++i) {
    frame.features.descriptors.Append(Landmarks().row(i));
    frame.features.keypoints.push_back({static_cast<float>(i), 0, 1, 0});
  }
  return frame;
}

KeyframeOptions Options() {
  KeyframeOptions options;
  options.min_matches_last = 60;
  options.min_matches_before_last = 30;
  options.min_matches_stretch = 10;
  return options;
}

struct Chosen {
  int number = 0;
  bool starts_stretch = false;

  bool operator==(const Chosen&) const = default;
};

void PrintTo(const Chosen& chosen, std::ostream* out) {
  *out << chosen.number << (chosen.starts_stretch ? "*" : "");
}

// The keyframes chosen from frames whose first landmarks are given. Negative: the frame is blurred
// and sees none.
std::vector<Chosen> Select(const std::vector<int>& firsts, const KeyframeOptions& options) {
  KeyframeSelector selector(options, MatchOptions{});
  std::vector<Chosen> all;
  const auto take = [&](const std::vector<ChosenKeyframe>& chosen) {
    for (const ChosenKeyframe& keyframe : chosen) {
      all.push_back({keyframe.frame.info.number, keyframe.starts_stretch});
    }
  };
  for (int number = 0; number < static_cast<int>(firsts.size()); ++number) {
    const bool blurred = firsts[number] < 0;
    take(selector.Add(FrameAt(number, blurred ? 0 : firsts[number], blurred ? 0 : kVisible)));
  }
  take(selector.Finish());
  return all;
}

// A camera that passes `step` landmarks a frame.
std::vector<int> SteadyWalk(int frames, int step) {
  std::vector<int> firsts;
  for (int k = 0; k < frames; ++k) firsts.push_back(k * step);
  return firsts;
}

TEST(KeyframeSelector, TakesAsManyFramesAsPossibleBetweenTwo) {
  // 5 landmarks a frame: after 8 frames 60 of 100 are left, after 9 frames 55; with the one before,
  // 16 frames back, there would be 20 < N, so that condition binds: 14 frames back there are 30.
  KeyframeOptions options = Options();
  options.min_matches_before_last = 20;
  EXPECT_EQ(Select(SteadyWalk(33, 5), options),
            (std::vector<Chosen>{{0, true}, {8, false}, {16, false}, {24, false}, {32, false}}));
}

TEST(KeyframeSelector, TheOneBeforeTheLastMustBeSeenToo) {
  // As above, but N = 30 keeps keyframes that are two apart within 14 frames.
  const std::vector<Chosen> chosen = Select(SteadyWalk(60, 5), Options());
  for (size_t i = 2; i < chosen.size(); ++i) {
    EXPECT_LE(chosen[i].number - chosen[i - 1].number, 8);
    EXPECT_LE(chosen[i].number - chosen[i - 2].number, 14);
  }
  EXPECT_EQ((std::vector<Chosen>{chosen[0], chosen[1], chosen[2]}),
            (std::vector<Chosen>{{0, true}, {8, false}, {14, false}}));
}

TEST(KeyframeSelector, AStillCameraThatSeesLittleGetsFewKeyframes) {
  KeyframeOptions options;  // asks for 300 matches
  ASSERT_GT(options.min_matches_last, kVisible);
  const std::vector<int> still(10 * options.max_gap + 1, 0);
  EXPECT_EQ(Select(still, options).size(), 11u);
  // One that walks gets as many as if it saw more, in proportion.
  EXPECT_EQ(Select(SteadyWalk(60, 5), options), Select(SteadyWalk(60, 5), Options()));
}

TEST(KeyframeSelector, AFrameOfNothingBecomesNoKeyframe) {
  EXPECT_EQ(Select({-1, -1, 0, 5, -1}, Options()), (std::vector<Chosen>{{2, true}, {3, false}}));
  EXPECT_TRUE(Select({-1, -1}, Options()).empty());
}

TEST(KeyframeSelector, PassesOverNoPhotoOfAnotherPlace) {
  // Photos that share little. The third has more in common with the first than the second does,
  // which alone shows its place.
  EXPECT_EQ(Select({0, 85, 70}, Options()), (std::vector<Chosen>{{0, true}, {2, false}}))
      << "the third shows what the second does";
  EXPECT_EQ(Select({0, 1000, 80}, Options()),
            (std::vector<Chosen>{{0, true}, {1, true}, {2, true}}));
}

// The three conditions over random walks: what is skipped could not have been the next keyframe's
// better choice, and what is chosen fulfils the conditions.
TEST(KeyframeSelector, HoldsItsThreeConditionsOnRandomWalks) {
  for (uint64_t seed = 1; seed <= 20; ++seed) {
    Random random(seed);
    std::vector<int> firsts = {0};
    for (int k = 1; k < 150; ++k) firsts.push_back(firsts.back() + random.Below(12));
    const KeyframeOptions options = Options();
    const std::vector<Chosen> chosen = Select(firsts, options);
    const auto common = [&](int a, int b) {
      return std::max(0, kVisible - std::abs(firsts[a] - firsts[b]));
    };
    const auto fulfils = [&](size_t i, int frame) {
      return common(chosen[i - 1].number, frame) >= options.min_matches_last &&
             (i < 2 || common(chosen[i - 2].number, frame) >= options.min_matches_before_last);
    };
    ASSERT_EQ(chosen.front(), (Chosen{0, true})) << "seed " << seed;
    for (size_t i = 1; i < chosen.size(); ++i) {
      EXPECT_FALSE(chosen[i].starts_stretch) << "seed " << seed;
      const int next = chosen[i].number + 1;
      const bool first_choice = fulfils(i, chosen[i].number);
      // A frame that doesn't fulfil them is taken only when the very next one didn't either.
      EXPECT_TRUE(first_choice || !fulfils(i, chosen[i - 1].number + 1)) << "seed " << seed;
      if (first_choice && next < static_cast<int>(firsts.size())) {
        EXPECT_FALSE(fulfils(i, next)) << "seed " << seed << ": frame " << next << " is farther";
      }
    }
  }
}

TEST(KeyframeSelector, IdsAreInOrderAndNoFrameComesTwice) {
  Random random(2);
  std::vector<int> firsts;
  for (int k = 0; k < 300; ++k) {
    firsts.push_back(random.Below(10) == 0 ? -1 : random.Below(kLandmarks - kVisible) / 40 * 40);
  }
  const std::vector<Chosen> chosen = Select(firsts, Options());
  ASSERT_GT(chosen.size(), 10u);
  for (size_t i = 1; i < chosen.size(); ++i) {
    EXPECT_LT(chosen[i - 1].number, chosen[i].number);
  }
}

TEST(KeyframeSelector, ASingleBadFrameIsJumpedOver) {
  for (int bad = 1; bad < 20; ++bad) {
    std::vector<int> firsts = SteadyWalk(30, 3);
    firsts[bad] = -1;
    const std::vector<Chosen> chosen = Select(firsts, Options());
    ASSERT_GT(chosen.size(), 1u) << "bad frame " << bad;
    for (const Chosen& keyframe : chosen) {
      EXPECT_NE(keyframe.number, bad);
      EXPECT_EQ(keyframe.starts_stretch, keyframe.number == 0) << "bad frame " << bad;
    }
  }
}

TEST(KeyframeSelector, AsManyBadFramesAsTheLookaheadAreJumpedOver) {
  KeyframeOptions options = Options();
  for (const int lookahead : {0, 1, 3, 5}) {
    options.lookahead = lookahead;
    std::vector<int> firsts = SteadyWalk(20, 1);
    std::fill_n(firsts.begin() + 8, lookahead, -1);
    // The farthest frame is beyond the gap, and nothing between is a keyframe.
    EXPECT_EQ(Select(firsts, options), (std::vector<Chosen>{{0, true}, {19, false}}))
        << "lookahead " << lookahead;
  }
}

TEST(KeyframeSelector, MoreBadFramesThanTheLookaheadEndTheSearch) {
  KeyframeOptions options = Options();
  options.lookahead = 2;
  std::vector<int> firsts = SteadyWalk(20, 1);
  std::fill_n(firsts.begin() + 8, 3, -1);
  const std::vector<Chosen> chosen = Select(firsts, options);
  ASSERT_GE(chosen.size(), 2u);
  EXPECT_EQ(chosen[1], (Chosen{7, false}));
}

TEST(KeyframeSelector, ABreakStartsANewStretch) {
  std::vector<int> firsts = SteadyWalk(10, 2);
  for (int k = 0; k < 12; ++k) firsts.push_back(2000 + 2 * k);
  const std::vector<Chosen> chosen = Select(firsts, Options());
  EXPECT_EQ(chosen, (std::vector<Chosen>{{0, true}, {9, false}, {10, true}, {21, false}}));
}

// After a break the keyframe before has nothing to do with the new stretch: condition N is off.
TEST(KeyframeSelector, TheFirstPairOfAStretchIsFreeOfTheOneBefore) {
  std::vector<int> firsts = {0, 0};
  for (int k = 0; k < 9; ++k) firsts.push_back(2000 + 5 * k);
  const std::vector<Chosen> chosen = Select(firsts, Options());
  EXPECT_EQ(chosen, (std::vector<Chosen>{{0, true}, {1, false}, {2, true}, {10, false}}));
}

TEST(KeyframeSelector, WeakOverlapIsNoBreak) {
  // Every frame has 40 landmarks in common with the one before: below M, above the break.
  const std::vector<Chosen> chosen = Select(SteadyWalk(12, 60), Options());
  ASSERT_EQ(chosen.size(), 12u);
  for (const Chosen& keyframe : chosen) {
    EXPECT_EQ(keyframe.starts_stretch, keyframe.number == 0) << keyframe.number;
  }
}

TEST(KeyframeSelector, AStandingCameraIsBoundedByMaxGap) {
  KeyframeOptions options = Options();
  options.max_gap = 25;
  EXPECT_EQ(Select(std::vector<int>(101, 0), options),
            (std::vector<Chosen>{{0, true}, {25, false}, {50, false}, {75, false}, {100, false}}));
}

TEST(KeyframeSelector, HoldsAHandfulOfFramesAtMost) {
  // Each frame shows another place: each is a stretch of its own in the end.
  KeyframeSelector selector(Options(), MatchOptions{});
  int given = 0;
  for (int number = 0; number < 100; ++number) {
    given += static_cast<int>(selector.Add(FrameAt(number, 20 * number, 10)).size());
    EXPECT_LE(number + 1 - given, Options().lookahead + 2);
  }
}

TEST(KeyframeSelector, TheFirstFrameIsGivenAtOnce) {
  KeyframeSelector selector(Options(), MatchOptions{});
  const std::vector<ChosenKeyframe> chosen = selector.Add(FrameAt(0, 0));
  ASSERT_EQ(chosen.size(), 1u);
  EXPECT_TRUE(chosen[0].starts_stretch);
  EXPECT_EQ(chosen[0].frame.features.size(), kVisible);
  EXPECT_TRUE(selector.Finish().empty());
}

TEST(KeyframeSelector, FinishFlushesWhatIsUndecided) {
  KeyframeSelector selector(Options(), MatchOptions{});
  selector.Add(FrameAt(0, 0));
  EXPECT_TRUE(selector.Add(FrameAt(1, 1)).empty());
  EXPECT_TRUE(selector.Add(FrameAt(2, 2)).empty());
  EXPECT_TRUE(selector.Add(FrameAt(3, 1000)).empty());
  const std::vector<ChosenKeyframe> rest = selector.Finish();
  ASSERT_EQ(rest.size(), 2u);
  EXPECT_EQ(rest[0].frame.info.number, 2);
  EXPECT_FALSE(rest[0].starts_stretch);
  EXPECT_EQ(rest[1].frame.info.number, 3);
  EXPECT_TRUE(rest[1].starts_stretch);
  EXPECT_TRUE(selector.Finish().empty()) << "nothing is left after the end";
}

TEST(KeyframeSelector, FinishOfNothingIsNothing) {
  EXPECT_TRUE(KeyframeSelector(Options(), MatchOptions{}).Finish().empty());
}

TEST(KeyframeOptions, OutOfTheirRangeAreRefused) {
  const auto expect_refused = [](auto change) {
    KeyframeOptions options;
    change(options);
    try {
      const KeyframeSelector selector(options, MatchOptions{});
      ADD_FAILURE() << "an option out of its range was taken";
    } catch (const MapError& error) {
      EXPECT_EQ(error.code(), ErrorCode::kBadOptions);
    }
  };
  expect_refused([](auto& o) { o.min_matches_last = o.min_matches_before_last - 1; });
  expect_refused([](auto& o) { o.min_matches_before_last = o.min_matches_stretch - 1; });
  expect_refused([](auto& o) { o.min_matches_stretch = 3; });
  expect_refused([](auto& o) { o.lookahead = -1; });
  expect_refused([](auto& o) { o.max_gap = 0; });
  EXPECT_NO_THROW(KeyframeOptions{}.Check());
}

}  // namespace
}  // namespace waystone
