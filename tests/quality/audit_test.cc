// SPDX-License-Identifier: Apache-2.0
#include "quality/audit.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include "core/base/error.h"
#include "tests/localizer/made_map.h"

namespace waystone {
namespace {

// The made map with `count` features of plane 1 on plane 4 as well, where they are on plane 1: the
// same poster on a wall elsewhere.
MapData MapWithPoster(int count) {
  MapData map = MadeMap();
  const Plane& from = map.planes[0];
  Plane& to = map.planes[3];
  Descriptors descriptors(from.descriptors.bytes());
  for (int i = 0; i < kMapFeatures; ++i) {
    const bool copied = i < count;
    if (copied) to.features[i] = from.features[i];
    descriptors.Append((copied ? from : to).descriptors.row(i));
  }
  to.descriptors = descriptors;
  return map;
}

TEST(Audit, PlainMapHasNoFindings) {
  const AuditReport report = AuditMap(*MadeIndex());
  EXPECT_TRUE(report.aliases.empty());
  for (const WeakRun& run : report.weak) EXPECT_EQ(run.weakness, Weakness::kFewPlanes);
}

TEST(Audit, RepeatedPosterIsAnAlias) {
  const AuditReport report = AuditMap(*MapIndex::Build(MapWithPoster(25)));
  ASSERT_EQ(report.aliases.size(), 1u);
  const AliasPair& alias = report.aliases.front();
  EXPECT_EQ(alias.a, KeyframeId{1});
  EXPECT_EQ(alias.b, KeyframeId{5});
  ASSERT_EQ(alias.planes.size(), 1u);
  EXPECT_EQ(alias.planes[0].a, PlaneId{1});
  EXPECT_EQ(alias.planes[0].b, PlaneId{4});
  EXPECT_GE(alias.inliers, 20);
  EXPECT_LE(alias.inliers, 25);
  EXPECT_GT(alias.of_view, 0.2);
  EXPECT_LE(alias.of_view, 0.5);
}

TEST(Audit, TooLittleAlikeAnswersForNothing) {
  EXPECT_TRUE(AuditMap(*MapIndex::Build(MapWithPoster(8))).aliases.empty());
}

TEST(Audit, WholeSurfaceAlikeIsToBeJoinedAPosterToBeTold) {
  AuditOptions options;
  options.same_surface_share = 0.7;
  const auto remedy = [&](int count) {
    return AuditMap(*MapIndex::Build(MapWithPoster(count)), options).aliases.at(0).remedy;
  };
  EXPECT_EQ(remedy(kMapFeatures), Remedy::kJoin);
  EXPECT_EQ(remedy(25), Remedy::kMarker);
}

TEST(Audit, NeighboursAreNoAliases) {
  MapData map = MapWithPoster(25);
  Edge edge = map.edges.front();
  edge.a = PlaneId{1};
  edge.b = PlaneId{4};
  map.edges.insert(map.edges.begin() + 1, edge);
  EXPECT_TRUE(AuditMap(*MapIndex::Build(map)).aliases.empty());
}

// The made map with plane 1 seen in keyframe 5 too, as if a poster there had been fused with it.
MapData FusedMap() {
  MapData map = MadeMap();
  map.planes[0].views.push_back({KeyframeId{5}, Eigen::Matrix3d::Identity(), 30});
  return map;
}

TEST(Audit, FusedPosterIsALoneTie) {
  EXPECT_TRUE(AuditMap(*MadeIndex()).ties.empty());
  const AuditReport report = AuditMap(*MapIndex::Build(FusedMap()));
  ASSERT_EQ(report.ties.size(), 1u);
  EXPECT_EQ(report.ties[0].plane, PlaneId{1});
  EXPECT_EQ(report.ties[0].a, KeyframeId{3});
  EXPECT_EQ(report.ties[0].b, KeyframeId{5});
  EXPECT_EQ(report.ties[0].inliers, 30);
}

TEST(Audit, VisitsTiedByOtherPlanesAreOnePlace) {
  MapData map = FusedMap();
  map.planes[1].views.push_back({KeyframeId{5}, Eigen::Matrix3d::Identity(), 30});
  EXPECT_TRUE(AuditMap(*MapIndex::Build(map)).ties.empty()) << "two planes were seen again";
  map = FusedMap();
  Edge edge = map.edges.back();
  edge.b = PlaneId{4};
  map.edges.push_back(edge);
  EXPECT_TRUE(AuditMap(*MapIndex::Build(map)).ties.empty()) << "an edge leads from 2 to 4";
}

TEST(Audit, StretchWithOnePlaneIsWeak) {
  const AuditReport report = AuditMap(*MadeIndex());
  ASSERT_EQ(report.weak.size(), 1u);
  const WeakRun& run = report.weak.front();
  EXPECT_EQ(run.weakness, Weakness::kFewPlanes);
  EXPECT_EQ(run.first, KeyframeId{5});
  EXPECT_EQ(run.last, KeyframeId{6});
  EXPECT_EQ(run.keyframes, 2);
  EXPECT_EQ(run.planes, 1);
  EXPECT_EQ(run.remedy, Remedy::kSlowerPass) << "the sequence broke off before it";
  AuditOptions options;
  options.min_stretch_planes = 1;
  EXPECT_TRUE(AuditMap(*MadeIndex(), options).weak.empty());
}

TEST(Audit, KeyframesWithoutPlanesAreARun) {
  MapData map = MadeMap();
  for (int id = 7; id <= 10; ++id) {
    Keyframe keyframe = map.keyframes.front();
    keyframe.id = KeyframeId{id};
    keyframe.sequence = SequenceId{2};
    keyframe.stretch = 0;
    map.keyframes.push_back(keyframe);
  }
  map.sequences.push_back({SequenceId{2}, "corridor", "folder", 40, 0, std::nullopt});
  const WeakRun run = AuditMap(*MapIndex::Build(map)).weak.back();
  EXPECT_EQ(run.weakness, Weakness::kSeesNoPlane);
  EXPECT_EQ(run.first, KeyframeId{7});
  EXPECT_EQ(run.last, KeyframeId{10});
  EXPECT_EQ(run.keyframes, 4);
  EXPECT_EQ(run.features, 0);
  EXPECT_EQ(run.remedy, Remedy::kMarker);
}

TEST(Audit, FewFeaturesAreWeak) {
  AuditOptions options;
  options.min_view_features = 3 * kMapFeatures;
  options.min_stretch_planes = 0;
  const std::vector<WeakRun> weak = AuditMap(*MadeIndex(), options).weak;
  ASSERT_FALSE(weak.empty());
  for (const WeakRun& run : weak) {
    EXPECT_EQ(run.weakness, Weakness::kFewFeatures);
    EXPECT_LT(run.features, options.min_view_features);
    EXPECT_GT(run.features, 0);
  }
  EXPECT_EQ(weak.back().last, KeyframeId{6});
}

TEST(Audit, EmptyMap) {
  MapData map;
  const AuditReport report = AuditMap(*MapIndex::Build(map));
  EXPECT_TRUE(report.aliases.empty());
  EXPECT_TRUE(report.weak.empty());
}

TEST(Audit, SameOnAnyNumberOfThreads) {
  const auto index = MapIndex::Build(MapWithPoster(30));
  const auto text = [&] {
    std::string out;
    for (const AliasPair& alias : AuditMap(*index).aliases) {
      out += std::to_string(alias.inliers) + " " + std::to_string(alias.shared) + " " +
             std::to_string(alias.of_view) + "\n";
    }
    return out;
  };
  const std::string many = text();
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  EXPECT_EQ(text(), many);
  EXPECT_NE(many, "");
}

TEST(Audit, OptionsOutOfRange) {
  AuditOptions options;
  options.max_voters = 0;
  EXPECT_THROW(AuditMap(*MadeIndex(), options), MapError);
  options = {};
  options.same_surface_share = 1.5;
  EXPECT_THROW(AuditMap(*MadeIndex(), options), MapError);
}

}  // namespace
}  // namespace waystone
