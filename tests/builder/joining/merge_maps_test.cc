// SPDX-License-Identifier: Apache-2.0
#include "builder/joining/merge_maps.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <set>

#include "builder/calibration/rendered_negatives.h"
#include "builder/joining/append_map.h"
#include "builder/joining/recognise_keyframes.h"
#include "builder/joining/remove_keyframes.h"
#include "core/base/error.h"
#include "localizer/planes/surroundings.h"
#include "schema/sessions.h"
#include "tests/builder/joining/walked_maps.h"

namespace waystone {
namespace {

const JoinResult& Joined() {
  static const JoinResult joined = MergeMaps({FirstHalf(), SecondHalf()}, "joined", {});
  return joined;
}

std::string MessageOf(const std::function<void()>& run) {
  try {
    run();
  } catch (const MapError& error) {
    EXPECT_EQ(error.code(), ErrorCode::kBadRequest);
    return error.what();
  }
  return "";
}

TEST(MergeMaps, HasWhatBothHadAndFusesWhatBothSaw) {
  const MapData& map = Joined().map;
  EXPECT_EQ(map.info.name, "joined");
  EXPECT_EQ(map.sequences.size(), 2u);
  EXPECT_EQ(map.keyframes.size(), FirstHalf().keyframes.size() + SecondHalf().keyframes.size());
  EXPECT_GT(Joined().report.planes_fused, 0);
  EXPECT_EQ(map.planes.size() + Joined().report.planes_fused,
            FirstHalf().planes.size() + SecondHalf().planes.size());
  EXPECT_EQ(FindParts(map).size(), 1u);
  ASSERT_TRUE(map.verdict);
  EXPECT_GT(map.verdict->positives, 0);
  EXPECT_EQ(WrittenAndRead(map).planes, map.planes);
}

TEST(MergeMaps, AnswersAsTheMapOfTheWholeDoes) {
  const auto whole = MapIndex::Build(TheMap().map);
  const auto joined = MapIndex::Build(Joined().map);
  std::vector<Features> queries = FeaturesOfFrames();
  const size_t inside = queries.size();
  for (Features& outside : CachedNegatives(15, FeatureOptions{})) {
    queries.push_back(std::move(outside));
  }
  int same = 0;
  int localized = 0;
  int near = 0;
  for (size_t i = 0; i < queries.size(); ++i) {
    const Answer expected = LocalizeFeatures(*whole, queries[i], {});
    const Answer answer = LocalizeFeatures(*joined, queries[i], {});
    same += answer.verdict == expected.verdict;
    if (answer.verdict != Verdict::kLocalized) continue;
    ASSERT_LT(i, inside) << "another building";
    ++localized;
    const int frame = joined->FindKeyframe(answer.planes.keyframe->id)->frame;
    near += std::abs(frame - static_cast<int>(i)) <= 12;
  }
  EXPECT_GE(same, std::ceil(0.98 * static_cast<double>(queries.size())));
  EXPECT_GE(localized, 40);
  // Two photos of what both halves show ahead are answered with a keyframe of the other half.
  EXPECT_GE(near, localized - 2);
}

// Thirteen frames at the beginning of a walk and as many at its end, from where the same room is
// seen: too few features are alike for fusing planes, but the keyframes are recognised.
TEST(MergeMaps, LinksKeyframesThatShowOnePlace) {
  const MapData begin = MapOfFrames(0, 12, "begin");
  const MapData end = MapOfFrames(32, 44, "end");
  const JoinResult joined = MergeMaps({begin, end}, "joined", {});
  EXPECT_GT(joined.report.keyframes_recognised, 0);
  ASSERT_FALSE(joined.map.links.empty());
  EXPECT_EQ(WrittenAndRead(joined.map).links, joined.map.links);
  EXPECT_EQ(FindParts(joined.map).size(), 1u);
  const auto index = MapIndex::Build(joined.map);
  for (const KeyframeLink& link : joined.map.links) {
    const int a = index->IndexOf(link.a);
    const int b = index->IndexOf(link.b);
    EXPECT_NE(joined.map.keyframes[a].sequence, joined.map.keyframes[b].sequence);
    EXPECT_TRUE(KeyframesAreNear(*index, a, b));
    EXPECT_TRUE(KeyframesAreNear(*index, b, a));
  }
  for (int i = 0; i <= 44; ++i) {
    EXPECT_NE(LocalizeFeatures(*index, FeaturesOfFrames()[i], {}).verdict, Verdict::kAmbiguous)
        << i;
  }
  // Without the second walk the links go, too.
  std::set<KeyframeId> second;
  for (const Keyframe& keyframe : joined.map.keyframes) {
    if (keyframe.sequence == SequenceId{2}) second.insert(keyframe.id);
  }
  EXPECT_TRUE(RemoveFromMap(joined.map, {second, {}}, {}).map.links.empty());
}

TEST(RecogniseKeyframes, AsksSeveralMapsAsItAsksEach) {
  const MapData walk = MapOfFrames(12, 32, "walk");
  const std::vector<AskedMap> asked{AskMap(FirstHalf(), {}, {}, {}),
                                    AskMap(SecondHalf(), {}, {}, {})};
  const auto ask = [&](const std::vector<const AskedMap*>& maps) {
    std::vector<std::vector<std::pair<size_t, size_t>>> found;
    for (const auto& of_map : RecogniseKeyframes(maps, walk, {}, {})) {
      found.emplace_back();
      for (const RecognisedKeyframe& one : of_map) found.back().emplace_back(one.asking, one.found);
    }
    return found;
  };
  const auto together = ask({&asked[0], &asked[1]});
  ASSERT_EQ(together.size(), 2U);
  EXPECT_EQ(together[0], ask({&asked[0]}).front());
  EXPECT_EQ(together[1], ask({&asked[1]}).front());
  EXPECT_FALSE(together[0].empty());
  EXPECT_NE(together[0], together[1]);
}

// The keyframes of an added walk are asked in the map, and none of the map in the walk.
TEST(AddToMap, LinksTheAddedKeyframes) {
  const JoinResult joined = AddToMap(FirstHalf(), SecondHalf(), {});
  EXPECT_GT(joined.report.keyframes_recognised, 0);
  EXPECT_LE(joined.report.keyframes_recognised,
            static_cast<int>(joined.map.keyframes.size() - FirstHalf().keyframes.size()));
}

TEST(AddToMap, AsksTheMapAsConfigured) {
  BuildOptions strict;
  strict.calibration.localize.planes.gates.min_probability = 1 - 1e-12;
  EXPECT_EQ(AddToMap(FirstHalf(), SecondHalf(), strict).report.keyframes_recognised, 0);
}

TEST(MergeMaps, DoesNotDependOnTheOrder) {
  EXPECT_TRUE(MergeMaps({SecondHalf(), FirstHalf()}, "joined", {}).map == Joined().map);
}

TEST(MergeMaps, RecordsItsSessions) {
  const std::vector<MapSession> sessions = SessionsOf(Joined().map);
  ASSERT_EQ(sessions.size(), 2u);
  std::vector<std::string> names{sessions[0].name, sessions[1].name};
  std::ranges::sort(names);
  EXPECT_EQ(names, (std::vector<std::string>{"first", "second"}));
  EXPECT_EQ(sessions[0].sequences, std::vector{SequenceId{1}});
  EXPECT_EQ(sessions[1].sequences, std::vector{SequenceId{2}});
  const bool first_leads = sessions[0].name == "first";
  EXPECT_EQ(sessions[0].version, (first_leads ? FirstHalf() : SecondHalf()).info.version);
}

TEST(MergeMaps, KeepsNamedPlaces) {
  MapData first = FirstHalf();
  MapData second = SecondHalf();
  const int64_t last = second.planes.back().id.value;
  first.names = {{"Hall", {{NamedKind::kKeyframes, 1, 3}}, {}}};
  second.names = {{"Hall", {{NamedKind::kKeyframes, 2, 2}}, {}},
                  {"Walls", {{NamedKind::kPlanes, 1, last}}, {}}};
  const MapData joined = MergeMaps({first, second}, "joined", {}).map;
  ASSERT_EQ(joined.names.size(), 2u);
  const auto shift = static_cast<int64_t>(
      SessionsOf(joined)[0].name == "first" ? first.keyframes.size() : second.keyframes.size());
  const bool first_leads = SessionsOf(joined)[0].name == "first";
  const NamedPlace hall{
      "Hall",
      first_leads ? std::vector<NamedRange>{{NamedKind::kKeyframes, 1, 3},
                                            {NamedKind::kKeyframes, 2 + shift, 2 + shift}}
                  : std::vector<NamedRange>{{NamedKind::kKeyframes, 2, 2},
                                            {NamedKind::kKeyframes, 1 + shift, 3 + shift}},
      {}};
  EXPECT_EQ(joined.names[0], hall);
  // Each plane of the second map is in it, as itself or as part of the one that it was fused with.
  std::set<int64_t> held;
  for (const NamedRange& range : joined.names[1].ranges) {
    for (int64_t id = range.first; id <= range.last; ++id) held.insert(id);
  }
  for (const Plane& plane : joined.planes) {
    const bool seen_by_second = std::ranges::any_of(plane.views, [&](const PlaneView& view) {
      return joined.keyframes[static_cast<size_t>(view.keyframe.value - 1)].sequence ==
             SequenceId{first_leads ? 2 : 1};
    });
    EXPECT_EQ(held.contains(plane.id.value), seen_by_second) << plane.id.value;
  }
  EXPECT_EQ(WrittenAndRead(joined).names, joined.names);
}

TEST(MergeMaps, JoinsAJoinedMapToAThird) {
  const MapData third = MapOfFrames(30, 40, "third");
  const MapData joined = MergeMaps({WrittenAndRead(Joined().map), third}, "all", {}).map;
  EXPECT_EQ(SessionsOf(joined).size(), 3u);
  EXPECT_EQ(FindParts(joined).size(), 1u);
}

TEST(MergeMaps, WhatDoesNotMeetStaysApart) {
  const MapData elsewhere = MapOfAnotherBuilding();
  const JoinResult joined = MergeMaps({FirstHalf(), elsewhere}, "apart", {});
  EXPECT_EQ(joined.report.keyframes_recognised, 0);
  EXPECT_EQ(joined.map.planes.size(), FirstHalf().planes.size() + elsewhere.planes.size());
  EXPECT_TRUE(joined.map.links.empty());
  EXPECT_EQ(FindParts(joined.map), (std::vector<std::vector<SequenceId>>{{{1}}, {{2}}}));
}

TEST(MergeMaps, RefusesWhatCannotBeJoined) {
  EXPECT_EQ(MessageOf([] { MergeMaps({FirstHalf()}, "one", {}); }),
            "1 map given; joining takes two or more");
  const MapData orb = MapOfFrames(0, 8, "orb", FeatureType::kOrb);
  EXPECT_EQ(MessageOf([&] {
              MergeMaps({FirstHalf(), orb}, "both", {});
            }),
            "map 'first' has sift features and map 'orb' has orb; build them with the same "
            "--features");
  EXPECT_EQ(MessageOf([] {
              MergeMaps({Joined().map, FirstHalf()}, "twice", {});
            }),
            "session 'first' is in map 'joined' and again in map 'first'; give each session once");
  const MapData part = MapOfFrames(0, FirstHalf().keyframes[2].frame, "part");
  EXPECT_TRUE(MessageOf([&] {
                AddToMap(FirstHalf(), part, {});
              }).ends_with("pictures as map 'first'; give each walk once"));
  EXPECT_NE(MessageOf([&] {
              MergeMaps({part, FirstHalf()}, "both", {});
            }).find("session 'part' has the same "),
            std::string::npos);
}

TEST(MergeMaps, RefusesIdsThatCannotBeCountedOn) {
  MapData last = FirstHalf();
  last.info.version = "";  // the first of the two
  last.planes.back().id = {INT64_MAX};
  last.edges.clear();
  EXPECT_THROW(MergeMaps({last, SecondHalf()}, "full", {}), MapError);
  last = FirstHalf();
  last.sequences.back().id = {INT64_MAX};
  EXPECT_THROW(AppendedSequences(SecondHalf(), last), MapError);
}

}  // namespace
}  // namespace waystone
