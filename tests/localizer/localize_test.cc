// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <string>
#include <thread>
#include <vector>

#include "core/base/check.h"
#include "core/homography/homography.h"
#include "localizer/localizer.h"
#include "tests/localizer/made_map.h"

namespace waystone {
namespace {

using Eigen::Vector2d;

// Everything of an answer but its times, as text: equal answers have equal texts.
std::string TextOf(const Answer& answer) {
  std::ostringstream out;
  out.precision(17);
  const auto keyframe = [&](const KeyframeRef& ref) {
    out << ref.id.value << " " << ref.sequence << " " << ref.source << " "
        << ref.time_s.value_or(-1) << "\n";
  };
  out << NameOf(answer.verdict) << " " << answer.probability << " " << answer.image << " "
      << answer.map << " " << answer.map_version << " " << NameOf(answer.decided_by) << " "
      << answer.message << "\n";
  if (answer.planes.keyframe) keyframe(*answer.planes.keyframe);
  for (const RecognisedPlane& plane : answer.planes.recognised) {
    out << plane.id.value << " " << plane.inliers << "\n" << plane.reference_from_query << "\n";
    keyframe(plane.reference);
    for (PlaneId id : plane.expect_next) out << id.value << " ";
    for (const auto* points : {&plane.outline, &plane.query_points, &plane.reference_points}) {
      for (const Vector2d& x : *points) out << x.transpose() << " ";
    }
  }
  std::vector<PlaceCandidate> places = answer.planes.places;
  if (answer.planes.runner_up) places.push_back(*answer.planes.runner_up);
  for (const PlaceCandidate& place : places) {
    out << place.probability << " " << place.inliers << " ";
    keyframe(place.keyframe);
  }
  return out.str();
}

std::vector<int64_t> PlaneIdsOf(const Answer& answer) {
  std::vector<int64_t> ids;
  for (const RecognisedPlane& plane : answer.planes.recognised) ids.push_back(plane.id.value);
  std::sort(ids.begin(), ids.end());
  return ids;
}

const RecognisedPlane& PlaneWithId(const Answer& answer, int64_t id) {
  return *std::find_if(answer.planes.recognised.begin(), answer.planes.recognised.end(),
                       [&](const auto& plane) { return plane.id.value == id; });
}

// The largest error, in reference pixels, of a plane's homography at the query points behind it.
double LargestError(const RecognisedPlane& plane, const MadePose& pose) {
  const Eigen::Matrix3d truth = ReferenceFromQuery(plane.id.value, pose);
  double largest = 0;
  for (const Vector2d& x : plane.query_points) {
    largest = std::max(largest, (Apply(plane.reference_from_query, x) - Apply(truth, x)).norm());
  }
  return largest;
}

std::vector<int64_t> Ids(const std::vector<PlaneId>& planes) {
  std::vector<int64_t> ids;
  for (PlaneId id : planes) ids.push_back(id.value);
  return ids;
}

TEST(LocalizeFeatures, FindsThePlanesAndTheirHomographies) {
  const MapData map = MadeMap();
  const auto index = MapIndex::Build(map);
  for (uint64_t seed = 1; seed <= 20; ++seed) {
    Random random(seed);
    const MadePose pose = PoseOf(random.Uniform(1, 3));
    const Answer answer =
        LocalizeFeatures(*index, QueryOf(map, {1, 2}, pose, 200, seed), LocalizeOptions{});
    ASSERT_EQ(answer.verdict, Verdict::kLocalized) << answer.message << ", seed " << seed;
    EXPECT_EQ(PlaneIdsOf(answer), (std::vector<int64_t>{1, 2})) << "seed " << seed;
    for (const RecognisedPlane& plane : answer.planes.recognised) {
      EXPECT_LT(LargestError(plane, pose), 0.5) << "plane " << plane.id.value << ", seed " << seed;
      EXPECT_GE(plane.inliers, 50);
      EXPECT_EQ(plane.query_points.size(), static_cast<size_t>(plane.inliers));
      EXPECT_EQ(plane.reference_points.size(), plane.query_points.size());
      EXPECT_EQ(plane.reference.id, KeyframeId{1});
    }
    EXPECT_GE(answer.planes.recognised[0].inliers, answer.planes.recognised[1].inliers)
        << "most inliers first";
    EXPECT_GT(answer.probability, 0.99);
    EXPECT_LE(answer.probability, 1);
    EXPECT_TRUE(answer.planes.places.empty());
    EXPECT_EQ(answer.map, "made");
    EXPECT_EQ(answer.map_version, "sha256:0");
  }
}

TEST(LocalizeFeatures, TheOutlineIsThatOfThePlaneInTheQuery) {
  const MapData map = MadeMap();
  const auto index = MapIndex::Build(map);
  const MadePose pose = PoseOf(2);
  const Answer answer = LocalizeFeatures(*index, QueryOf(map, {1}, pose, 50, 1), {});
  ASSERT_EQ(answer.planes.recognised.size(), 1u);
  const Eigen::Matrix3d query_from_reference = ReferenceFromQuery(1, pose).inverse();
  ASSERT_EQ(answer.planes.recognised[0].outline.size(), map.planes[0].outline.size());
  for (size_t i = 0; i < map.planes[0].outline.size(); ++i) {
    const Vector2d corner = Apply(query_from_reference, map.planes[0].outline[i]);
    EXPECT_LT((answer.planes.recognised[0].outline[i] - corner).norm(), 1.0) << i;
  }
}

TEST(LocalizeFeatures, TheNearestKeyframeIsNamed) {
  const MapData map = MadeMap();
  const auto index = MapIndex::Build(map);
  for (int keyframe : {1, 2, 3}) {
    for (double off : {-0.3, 0.0, 0.3}) {
      const Features query = QueryOf(map, {1, 2}, PoseOf(keyframe + off), 100, 3);
      const Answer answer = LocalizeFeatures(*index, query, {});
      ASSERT_TRUE(answer.planes.keyframe) << keyframe << " " << off;
      EXPECT_EQ(answer.planes.keyframe->id, KeyframeId{keyframe}) << off;
      EXPECT_EQ(answer.planes.keyframe->sequence, "walk");
      EXPECT_EQ(answer.planes.keyframe->source, "rgb/" + std::to_string(10 * keyframe) + ".jpg");
      EXPECT_EQ(answer.planes.keyframe->time_s, 0.5 * keyframe);
    }
  }
}

TEST(LocalizeFeatures, CovisiblePlanesThatAreNotInTheQueryAreExpectedNext) {
  const MapData map = MadeMap();
  const auto index = MapIndex::Build(map);
  const Answer one = LocalizeFeatures(*index, QueryOf(map, {1}, PoseOf(2), 100, 4), {});
  ASSERT_EQ(PlaneIdsOf(one), std::vector<int64_t>{1});
  EXPECT_EQ(Ids(one.planes.recognised[0].expect_next), std::vector<int64_t>{2});
  const Answer two = LocalizeFeatures(*index, QueryOf(map, {1, 2}, PoseOf(2), 100, 5), {});
  ASSERT_EQ(PlaneIdsOf(two), (std::vector<int64_t>{1, 2}));
  EXPECT_TRUE(PlaneWithId(two, 1).expect_next.empty());
  EXPECT_EQ(Ids(PlaneWithId(two, 2).expect_next), std::vector<int64_t>{3});
  const Answer four = LocalizeFeatures(*index, QueryOf(map, {4}, PoseOf(5.5), 100, 6), {});
  ASSERT_EQ(PlaneIdsOf(four), std::vector<int64_t>{4});
  EXPECT_TRUE(four.planes.recognised[0].expect_next.empty());
}

TEST(LocalizeFeatures, RandomFeaturesAreNotInTheMap) {
  const MapData map = MadeMap();
  const auto index = MapIndex::Build(map);
  for (uint64_t seed = 1; seed <= 20; ++seed) {
    const Answer answer = LocalizeFeatures(*index, QueryOf(map, {}, PoseOf(1), 800, seed), {});
    EXPECT_EQ(answer.verdict, Verdict::kNotInMap) << "seed " << seed;
    EXPECT_FALSE(answer.planes.keyframe);
    EXPECT_TRUE(answer.planes.recognised.empty());
    EXPECT_NE(answer.decided_by, DecidedBy::kNone);
    EXPECT_FALSE(answer.message.empty());
    EXPECT_LT(answer.probability, 0.5);
  }
}

// The right looks at the wrong places: a jumble of the map's own features.
TEST(LocalizeFeatures, TheRightDescriptorsInDisorderAreNotInTheMap) {
  const MapData map = MadeMap();
  const auto index = MapIndex::Build(map);
  for (uint64_t seed = 1; seed <= 20; ++seed) {
    Features query = QueryOf(map, {1, 2}, PoseOf(2), 0, seed);
    Random random(seed);
    for (Keypoint& keypoint : query.keypoints) {
      keypoint.x_px = static_cast<float>(random.Uniform(0, 639));
      keypoint.y_px = static_cast<float>(random.Uniform(0, 479));
    }
    const Answer answer = LocalizeFeatures(*index, query, {});
    EXPECT_EQ(answer.verdict, Verdict::kNotInMap) << "seed " << seed;
    EXPECT_EQ(answer.decided_by, DecidedBy::kHomographyInliers);
  }
}

TEST(LocalizeFeatures, TooFewFeaturesAreNotInTheMap) {
  const MapData map = MadeMap();
  const auto index = MapIndex::Build(map);
  const Features whole = QueryOf(map, {1}, PoseOf(2), 0, 7);
  for (int count : {0, 1, 3, 4, 5, 7}) {
    const Answer answer = LocalizeFeatures(*index, FirstFeatures(whole, count), {});
    EXPECT_EQ(answer.verdict, Verdict::kNotInMap) << count;
    EXPECT_EQ(answer.decided_by, DecidedBy::kFeatures) << count;
    EXPECT_NE(answer.message.find(std::to_string(count)), std::string::npos) << answer.message;
  }
  // Enough for a plane but not for a place.
  const Answer few = LocalizeFeatures(*index, FirstFeatures(whole, 8), {});
  EXPECT_EQ(few.verdict, Verdict::kNotInMap);
  EXPECT_EQ(few.decided_by, DecidedBy::kPlaceProbability);
  ASSERT_TRUE(few.planes.runner_up);
  EXPECT_LE(few.planes.runner_up->inliers, 8);
  EXPECT_LT(few.probability, 0.9);
  EXPECT_EQ(LocalizeFeatures(*index, FirstFeatures(whole, 25), {}).verdict, Verdict::kLocalized);
}

// The message speaks of the gate that refused, whatever the others would have said.
TEST(LocalizeFeatures, ARefusalNamesItsGate) {
  const MapData map = MadeMap();
  const auto index = MapIndex::Build(map);
  const auto ask = [&](const Features& query, const GateOptions& gates) {
    LocalizeOptions options;
    options.planes.gates = gates;
    Answer answer = LocalizeFeatures(*index, query, options);
    EXPECT_EQ(answer.verdict, Verdict::kNotInMap);
    return answer;
  };
  const auto says = [](const Answer& answer, const std::string& words) {
    return answer.message.find(words) != std::string::npos;
  };
  Features query = QueryOf(map, {1}, PoseOf(1), 0, 5);
  for (int i = 0; i < query.size() / 4; ++i) query.keypoints[4 * i].x_px = 10;  // outliers
  const Answer share = ask(query, {.min_inlier_share = 0.99});
  EXPECT_EQ(share.decided_by, DecidedBy::kInlierShare);
  EXPECT_TRUE(says(share, "99%")) << share.message;
  EXPECT_EQ(share.probability, 0) << "no place, whatever number of inliers";
  EXPECT_FALSE(says(share, "probability")) << share.message;

  query = QueryOf(map, {1}, PoseOf(1), 0, 5);
  for (Keypoint& keypoint : query.keypoints) {  // the wall, three times as large
    keypoint.x_px *= 3;
    keypoint.y_px *= 3;
  }
  const Answer scale = ask(query, {.max_scale = 2});
  EXPECT_EQ(scale.decided_by, DecidedBy::kHomographyScale);
  EXPECT_TRUE(says(scale, "factor of 2;")) << scale.message;
  EXPECT_EQ(scale.probability, 0);
  EXPECT_FALSE(says(scale, "probability")) << scale.message;

  const Answer few = ask(QueryOf(map, {1}, PoseOf(1), 60, 5), {.min_inliers = 100});
  EXPECT_EQ(few.decided_by, DecidedBy::kHomographyInliers);
  EXPECT_TRUE(says(few, "required are 100")) << few.message;

  const Answer place = ask(FirstFeatures(QueryOf(map, {1}, PoseOf(2), 0, 7), 8), {});
  EXPECT_EQ(place.decided_by, DecidedBy::kPlaceProbability);
  EXPECT_TRUE(says(place, "probability")) << place.message;
}

TEST(LocalizeFeatures, AMapWithoutPlanesKnowsNoPlace) {
  MapData empty = MadeMap();
  empty.planes.clear();
  empty.edges.clear();
  const auto index = MapIndex::Build(std::move(empty));
  const Answer answer = LocalizeFeatures(*index, QueryOf(MadeMap(), {1}, PoseOf(1), 50, 8), {});
  EXPECT_EQ(answer.verdict, Verdict::kNotInMap);
  EXPECT_EQ(answer.decided_by, DecidedBy::kShortlistVotes);
}

// One corner of the image, however many features it gives, is one piece of evidence.
TEST(LocalizeFeatures, FeaturesOfOneSpotCountOnce) {
  const MapData map = MadeMap();
  const auto index = MapIndex::Build(map);
  Features query = QueryOf(map, {1}, PoseOf(2), 0, 9);
  for (int i = 8; i < query.size(); ++i) query.keypoints[i] = query.keypoints[i % 8];
  EXPECT_EQ(LocalizeFeatures(*index, query, {}).verdict, Verdict::kNotInMap);
}

MapData MapWithAlikePlanes() {
  MapData map = MadeMap();
  map.planes[3].features = map.planes[0].features;
  map.planes[3].descriptors = map.planes[0].descriptors;
  return map;
}

TEST(LocalizeFeatures, TwoFarPlanesThatLookAlikeAreAmbiguous) {
  const MapData map = MapWithAlikePlanes();
  const auto index = MapIndex::Build(map);
  const Answer answer = LocalizeFeatures(*index, QueryOf(map, {1}, PoseOf(2), 100, 10), {});
  EXPECT_EQ(answer.verdict, Verdict::kAmbiguous);
  EXPECT_EQ(answer.decided_by, DecidedBy::kAmbiguousPlaces);
  EXPECT_FALSE(answer.planes.keyframe);
  ASSERT_EQ(answer.planes.places.size(), 2u);
  std::vector<int64_t> keyframes;
  for (const PlaceCandidate& place : answer.planes.places)
    keyframes.push_back(place.keyframe.id.value);
  std::sort(keyframes.begin(), keyframes.end());
  EXPECT_EQ(keyframes, (std::vector<int64_t>{2, 6}));
  EXPECT_GE(answer.planes.places[0].inliers, answer.planes.places[1].inliers);
}

// What else is seen settles it: the place with the right wall has more evidence.
TEST(LocalizeFeatures, ASecondPlaneTellsAlikePlacesApart) {
  const MapData map = MapWithAlikePlanes();
  const auto index = MapIndex::Build(map);
  const Answer answer = LocalizeFeatures(*index, QueryOf(map, {1, 2}, PoseOf(2), 100, 11), {});
  EXPECT_EQ(answer.verdict, Verdict::kLocalized);
  EXPECT_EQ(PlaneIdsOf(answer), (std::vector<int64_t>{1, 2}));
  ASSERT_TRUE(answer.planes.runner_up);
  EXPECT_EQ(answer.planes.runner_up->keyframe.id, KeyframeId{6});
}

// Two posters in one room: wherever it is of the two, the place is the same.
TEST(LocalizeFeatures, AlikePlanesOfOneSurroundingAreNotAmbiguous) {
  MapData map = MapWithAlikePlanes();
  map.edges.push_back(map.edges[1]);
  map.edges.back().a = PlaneId{1};
  map.edges.back().b = PlaneId{4};
  const auto index = MapIndex::Build(map);
  const Answer answer = LocalizeFeatures(*index, QueryOf(map, {1}, PoseOf(2), 100, 12), {});
  EXPECT_EQ(answer.verdict, Verdict::kLocalized);
}

TEST(LocalizeFeatures, SeveralThreadsGetTheSameAnswers) {
  const MapData map = MapWithAlikePlanes();
  const auto index = MapIndex::Build(map);
  const std::vector<Features> queries = {
      QueryOf(map, {1, 2}, PoseOf(2), 100, 1), QueryOf(map, {1}, PoseOf(1.5), 200, 2),
      QueryOf(map, {}, PoseOf(1), 300, 3), QueryOf(map, {2, 3}, PoseOf(3.5), 50, 4)};
  std::vector<std::string> expected;
  for (const Features& query : queries) {
    expected.push_back(TextOf(LocalizeFeatures(*index, query, {})));
  }
  std::vector<std::vector<std::string>> found(4);
  std::vector<std::thread> threads;
  for (std::vector<std::string>& answers : found) {
    threads.emplace_back([&] {
      for (int round = 0; round < 3; ++round) {
        for (const Features& query : queries) {
          answers.push_back(TextOf(LocalizeFeatures(*index, query, {})));
        }
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  for (const std::vector<std::string>& answers : found) {
    ASSERT_EQ(answers.size(), 3 * queries.size());
    for (size_t i = 0; i < answers.size(); ++i)
      EXPECT_EQ(answers[i], expected[i % expected.size()]);
  }
}

// Samples differ with the order, so the last digits may; what is said may not.
TEST(LocalizeFeatures, TheOrderOfTheFeaturesDoesNotMatter) {
  const MapData map = MadeMap();
  const auto index = MapIndex::Build(map);
  const MadePose pose = PoseOf(2.2);
  for (uint64_t seed = 1; seed <= 10; ++seed) {
    const Features query = QueryOf(map, {1, 2}, pose, 300, seed);
    const Answer one = LocalizeFeatures(*index, query, {});
    const Answer other = LocalizeFeatures(*index, Shuffled(query, seed), {});
    EXPECT_EQ(one.verdict, other.verdict) << "seed " << seed;
    ASSERT_EQ(PlaneIdsOf(one), PlaneIdsOf(other)) << "seed " << seed;
    ASSERT_TRUE(one.planes.keyframe && other.planes.keyframe);
    EXPECT_EQ(one.planes.keyframe->id, other.planes.keyframe->id);
    EXPECT_EQ(one.decided_by, other.decided_by);
    EXPECT_NEAR(one.probability, other.probability, 1e-6);
    for (const RecognisedPlane& plane : one.planes.recognised) {
      const RecognisedPlane& same = PlaneWithId(other, plane.id.value);
      EXPECT_NEAR(plane.inliers, same.inliers, 2);
      EXPECT_EQ(plane.expect_next, same.expect_next);
      for (const Vector2d& x : plane.query_points) {
        EXPECT_LT(
            (Apply(plane.reference_from_query, x) - Apply(same.reference_from_query, x)).norm(),
            0.5)
            << "seed " << seed;
      }
    }
  }
}

TEST(LocalizeFeatures, FeaturesOfAnotherTypeAreAProgrammersError) {
  Features query;
  query.type = FeatureType::kOrb;
  EXPECT_THROW(LocalizeFeatures(*MadeIndex(), query, {}), CheckFailure);
}

}  // namespace
}  // namespace waystone
