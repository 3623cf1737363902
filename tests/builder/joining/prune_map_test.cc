// SPDX-License-Identifier: Apache-2.0
#include "builder/joining/prune_map.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <set>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "builder/joining/merge_maps.h"
#include "schema/sessions.h"
#include "tests/builder/joining/walked_maps.h"

namespace waystone {
namespace {

constexpr double kChanged = 6;  // grey values
constexpr int kFrames = 40;

using Images = std::vector<cv::Mat>;

// A room with pictures on its northern wall; on the second day one is gone and one was exchanged.
constexpr const char* kThen = "###a###b##c##d##";
constexpr const char* kNow = "###a######e##d##";

World RoomWith(const std::string& northern_wall) {
  const std::string plan = northern_wall + R"(
#..............#
#..............#
#..............#
#..............#
#..............#
#..............#
################
)";
  return World(ParseFloorPlan(plan), {.texture_richness = 0.5, .poster_probability = 0});
}

const World& RoomThen() {
  static const World world = RoomWith(kThen);
  return world;
}
const World& RoomNow() {
  static const World world = RoomWith(kNow);
  return world;
}

// Along the northern wall; another day with another hand, at another pace and distance.
Walk WalkOnDay(int day) {
  WalkOptions options;
  options.step_m = day == 1 ? 0.1 : 0.11;
  options.gaze_rad = 0.3;
  options.gaze_offset_rad = std::numbers::pi / 2;
  options.seed = day;
  const double row = day == 1 ? 5.5 : 5.2;
  return WalkThrough(RoomThen().plan(), {{2.5, row}, {13.0, row - 0.5}}, options);
}

Images Rendered(const World& world, const Walk& walk) {
  Images images;
  for (int i = 0; i < kFrames; ++i) {
    images.push_back(TheStage().renderer.Render(world, walk.frames[i].world_from_camera).grey);
  }
  return images;
}

const Images& ImagesThen() {
  static const Images images = Rendered(RoomThen(), WalkOnDay(1));
  return images;
}

const MapData& FirstDay() {
  static const MapData map = MapOfImages(ImagesThen(), 0, kFrames - 1, "first");
  return map;
}

JoinResult WithWalk(MapData map, const Images& images, const std::string& name) {
  MemorySequence sequence{.name = name, .camera = {}};
  for (int i = 0; i < kFrames; ++i) {
    sequence.frames.emplace_back(FrameInfo{i, "frame " + std::to_string(i), i / 15.0},
                                 [image = images[i]] { return image; });
  }
  std::vector<std::unique_ptr<Source>> sources;
  sources.push_back(std::make_unique<MemorySource>(std::move(sequence)));
  BuildOptions options;
  options.map_name = name;
  BuildResult built = BuildMap(sources, options, {}, std::nullopt, BuiltFeatures::kKeep);
  return AddToMap(std::move(map), std::move(built.map), {}, built.features);
}

const JoinResult& Changed() {
  static const JoinResult joined =
      WithWalk(FirstDay(), Rendered(RoomNow(), WalkOnDay(2)), "second");
  return joined;
}

// What differs by more than rounding, and around it what features beside it see of it.
cv::Mat MaskOf(const cv::Mat& then, const cv::Mat& now) {
  cv::Mat difference;
  cv::absdiff(then, now, difference);
  cv::Mat changed = difference > kChanged;
  cv::dilate(changed, changed, cv::Mat(), {-1, -1}, 6);
  return changed;
}

// Features of the first day's map that a removal took, by whether they were on what changed.
struct Tally {
  int on_changed = 0;
  int on_changed_removed = 0;
  int elsewhere = 0;
  int elsewhere_removed = 0;
};

class Judge {
 public:
  Judge() {
    const Images now = Rendered(RoomNow(), WalkOnDay(1));
    for (int i = 0; i < kFrames; ++i) changed_.push_back(MaskOf(ImagesThen()[i], now[i]));
  }

  Tally Compare(const MapData& before, const MapData& after) const {
    Tally tally;
    std::set<std::tuple<int64_t, float, float, float>> left;
    for (const Plane& plane : after.planes) {
      for (const PlaneFeature& f : plane.features) left.insert(KeyOf(plane, f));
    }
    for (const Plane& plane : FirstDay().planes) {
      for (const PlaneFeature& f : plane.features) {
        if (!IsLeft(before, plane, f)) continue;
        Count(FrameOf(plane.reference), PositionOf(f.reference), left.contains(KeyOf(plane, f)),
              tally);
      }
    }
    for (size_t k = 0; k < FirstDay().keyframes.size(); ++k) {
      const Keyframe& keyframe = FirstDay().keyframes[k];
      for (const ImagePosition& position : keyframe.landmarks.positions) {
        const auto& kept = after.keyframes[k].landmarks.positions;
        Count(keyframe.frame, DecodePosition(position, keyframe.width, keyframe.height),
              std::ranges::find(kept, position) != kept.end(), tally);
      }
    }
    return tally;
  }

 private:
  static std::tuple<int64_t, float, float, float> KeyOf(const Plane& plane, const PlaneFeature& f) {
    return {plane.id.value, f.reference.x_px, f.reference.y_px, f.reference.angle_rad};
  }
  static bool IsLeft(const MapData& map, const Plane& plane, const PlaneFeature& f) {
    for (const Plane& other : map.planes) {
      for (const PlaneFeature& g : other.features) {
        if (other.id == plane.id && g.reference == f.reference) return true;
      }
    }
    return false;
  }
  static int FrameOf(KeyframeId id) {
    return FirstDay().keyframes[static_cast<size_t>(id.value - 1)].frame;
  }

  void Count(int frame, const Eigen::Vector2d& x, bool left, Tally& tally) const {
    const cv::Mat& changed = changed_[frame];
    const auto column = static_cast<int>(std::lround(x.x()));
    const auto row = static_cast<int>(std::lround(x.y()));
    if (column < 0 || row < 0 || column >= changed.cols || row >= changed.rows) return;
    if (changed.at<uint8_t>(row, column) != 0) {
      ++tally.on_changed;
      tally.on_changed_removed += !left;
    } else {
      ++tally.elsewhere;
      tally.elsewhere_removed += !left;
    }
  }

  std::vector<cv::Mat> changed_;
};

TEST(PruneMap, LosesNothingWhereNothingChanged) {
  const JoinResult joined = WithWalk(FirstDay(), Rendered(RoomThen(), WalkOnDay(2)), "again");
  EXPECT_GT(joined.report.features_looked_for, 500);
  EXPECT_GT(joined.report.features_found, 0.9 * joined.report.features_looked_for);
  const PruneReport pruned = PruneMap(joined.map, 3, {}).report;
  EXPECT_LE(pruned.plane_features + pruned.landmarks, 0.002 * joined.report.features_looked_for);
  EXPECT_TRUE(pruned.planes.empty() || pruned.planes.front().left > 0);
}

TEST(PruneMap, LosesPicturesThatAreGoneOrExchangedAndLittleElse) {
  const PruneResult pruned = PruneMap(Changed().map, 3, {});
  const Tally tally = Judge().Compare(Changed().map, pruned.map);
  EXPECT_GT(tally.on_changed, 100);
  EXPECT_GT(tally.on_changed_removed, 0.7 * tally.on_changed);
  EXPECT_LE(tally.elsewhere_removed, 0.01 * tally.elsewhere);
  const PruneReport& report = pruned.report;
  ASSERT_EQ(report.sessions.size(), 1u);
  EXPECT_EQ(report.sessions[0].name, "second");
  EXPECT_EQ(report.sessions[0].landmarks, report.landmarks);
  EXPECT_EQ(SessionsOf(pruned.map), SessionsOf(Changed().map));
  EXPECT_EQ(FindParts(pruned.map), FindParts(Changed().map));
  EXPECT_EQ(WrittenAndRead(pruned.map).looks, pruned.map.looks);
  // What is left was pruned.
  const PruneResult again = PruneMap(pruned.map, 3, {});
  EXPECT_LT(again.report.plane_features + again.report.landmarks,
            0.1 * (report.plane_features + report.landmarks));
}

TEST(PruneMap, TakesMoreThanAFewLooks) {
  const PruneReport strict = PruneMap(Changed().map, 1, {}).report;
  const PruneReport usual = PruneMap(Changed().map, 3, {}).report;
  const PruneReport lenient = PruneMap(Changed().map, 200, {}).report;
  EXPECT_GE(strict.plane_features + strict.landmarks, usual.plane_features + usual.landmarks);
  EXPECT_FALSE(lenient.changed());
  EXPECT_EQ(lenient.looked_for, usual.looked_for);
}

// A map with one plane of 8 by 5 features, what two later walks found of them, and nothing else to
// be asked.
class CountedPlane {
 public:
  CountedPlane() : map_(FirstDay()) {
    for (Keyframe& keyframe : map_.keyframes) keyframe.picture.clear();  // nothing to calibrate by
    plane_ = &map_.planes.front();
    Descriptors descriptors(plane_->descriptors.bytes());
    plane_->features.clear();
    for (int i = 0; i < kCount; ++i) {
      const int row = i / 8;
      const int column = i % 8;
      Keypoint at{20.0f * static_cast<float>(column), 20.0f * static_cast<float>(row), 8, 0};
      plane_->features.push_back({at, 3, 3});
      descriptors.Append(std::vector<uint8_t>(128, static_cast<uint8_t>(i)).data());
    }
    plane_->descriptors = descriptors;
    for (int walk : {2, 3}) {
      Sequence sequence = map_.sequences.front();
      sequence.id = {walk};
      map_.sequences.push_back(sequence);
      map_.looks.planes.push_back({plane_->id, {walk}, std::vector<FeatureLooks>(kCount, {4, 4})});
    }
  }

  static constexpr int kCount = 40;

  // Walk 1 or 2 found so much of some features.
  CountedPlane& Set(int walk, const std::vector<int>& features, FeatureLooks looks) {
    for (const int f : features) map_.looks.planes[walk - 1].features[f] = looks;
    return *this;
  }

  int Removed() const { return PruneMap(map_, 3, {}).report.plane_features; }
  const MapData& map() const { return map_; }

 private:
  MapData map_;
  Plane* plane_;
};

const std::vector<int> kCorner{0, 1, 2, 8, 9, 10, 16, 17, 18};  // three by three

TEST(PruneMap, TakesWhatNoWalkFoundWithWhatIsAround) {
  EXPECT_EQ(CountedPlane().Removed(), 0);
  const int removed = CountedPlane().Set(1, kCorner, {4, 0}).Set(2, kCorner, {4, 0}).Removed();
  EXPECT_GE(removed, 4);
  EXPECT_LE(removed, 9);
}

TEST(PruneMap, LeavesASingleFeatureThatIsHardToFind) {
  EXPECT_EQ(CountedPlane().Set(1, {6}, {4, 0}).Set(2, {6}, {4, 0}).Removed(), 0);
}

TEST(PruneMap, CountsSinceAWalkFoundThemLast) {
  EXPECT_GE(CountedPlane().Set(2, kCorner, {4, 0}).Removed(), 4);  // gone since the first walk
  EXPECT_EQ(CountedPlane().Set(1, kCorner, {4, 0}).Removed(), 0);  // back again
  EXPECT_EQ(CountedPlane().Set(2, kCorner, {2, 0}).Removed(), 0);  // two looks are too few
  // One look of each walk, and two.
  EXPECT_EQ(CountedPlane().Set(1, kCorner, {1, 0}).Set(2, kCorner, {1, 0}).Removed(), 0);
  EXPECT_GE(CountedPlane().Set(1, kCorner, {1, 0}).Set(2, kCorner, {2, 0}).Removed(), 4);
  EXPECT_EQ(CountedPlane().Set(1, kCorner, {0, 0}).Set(2, kCorner, {0, 0}).Removed(), 0);
}

TEST(PruneMap, APlaneWithTooFewFeaturesGoesWithItsEdges) {
  std::vector<int> most;
  for (int f = 0; f < CountedPlane::kCount - 2; ++f) most.push_back(f);
  CountedPlane counted;
  const MapData map = counted.Set(1, most, {4, 0}).Set(2, most, {4, 0}).map();
  const PlaneId id = map.planes.front().id;
  const PruneResult pruned = PruneMap(map, 3, {});
  EXPECT_EQ(pruned.map.planes.size() + 1, map.planes.size());
  EXPECT_EQ(pruned.report.plane_features, CountedPlane::kCount);
  EXPECT_EQ(pruned.report.edges, static_cast<int>(map.edges.size() - pruned.map.edges.size()));
  for (const Edge& edge : pruned.map.edges) EXPECT_TRUE(edge.a != id && edge.b != id);
  ASSERT_EQ(pruned.report.planes.size(), 1u);
  EXPECT_EQ(pruned.report.planes[0].id, id);
  EXPECT_EQ(pruned.report.planes[0].left, 0);
}

TEST(PruneMap, RefusesAMapThatWasNeverLookedAtAgain) {
  try {
    PruneMap(FirstDay(), 3, {});
    ADD_FAILURE() << "pruned";
  } catch (const MapError& error) {
    EXPECT_EQ(error.code(), ErrorCode::kBadRequest);
    EXPECT_NE(std::string(error.what()).find("never looked at again"), std::string::npos);
  }
  EXPECT_THROW(PruneMap(FirstDay(), 0, {}), MapError);
}

}  // namespace
}  // namespace waystone
