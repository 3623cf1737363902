// SPDX-License-Identifier: Apache-2.0
#include "localizer/session.h"

#include <gtest/gtest.h>

#include <numbers>
#include <opencv2/imgcodecs.hpp>

#include "core/base/error.h"
#include "localizer/localizer.h"
#include "tests/localizer/made_map.h"

namespace waystone {
namespace {

QueryImage EncodedFlat(const std::string& name, int width = 64, int height = 48) {
  std::vector<uint8_t> bytes;
  cv::imencode(".png", cv::Mat(height, width, CV_8UC1, cv::Scalar(90)), bytes);
  return {name, std::string(bytes.begin(), bytes.end())};
}

QueryRequest RequestFor(std::vector<QueryImage> images) {
  QueryRequest request;
  request.images = std::move(images);
  return request;
}

RequestAnswer AnswersWith(std::vector<Answer> maps) {
  RequestAnswer answer;
  answer.images = {std::move(maps)};
  return answer;
}

Answer LocalizedIn(const std::string& map, double probability) {
  Answer answer;
  answer.verdict = Verdict::kLocalized;
  answer.probability = probability;
  answer.map = map;
  answer.planes.keyframe = KeyframeRef{KeyframeId{1}, "walk", map + ".jpg", {}};
  return answer;
}

TEST(Session, AnswersAsTheEngineDoesByTheNameItIsAskedBy) {
  const auto index = MadeIndex();
  const QueryImage image = EncodedFlat("q.png");
  const Session session(RequestFor({image}), {{"lab", index}}, {});
  const RequestAnswer answer = session.Ask();
  const Answer engine = LocalizeImage(*index, cv::Mat(48, 64, CV_8UC1, cv::Scalar(90)), {});
  ASSERT_EQ(answer.images.size(), 1u);
  EXPECT_EQ(answer.images[0][0].verdict, engine.verdict);
  EXPECT_EQ(answer.images[0][0].decided_by, engine.decided_by);
  EXPECT_EQ(answer.images[0][0].map, "lab");
  EXPECT_EQ(answer.images[0][0].image, "q.png");
  EXPECT_FALSE(answer.series);
  EXPECT_FALSE(answer.belief);
}

TEST(Session, AnImageThatIsDecodedAlreadyIsAnsweredAlike) {
  const auto index = MadeIndex();
  const QueryImage decoded{"q", "no image", cv::Mat(48, 64, CV_8UC1, cv::Scalar(90))};
  const Answer answer = OverallAnswer(Session(RequestFor({decoded}), {{"lab", index}}, {}).Ask());
  EXPECT_EQ(answer.decided_by, DecidedBy::kFeatures);
  const Answer broken =
      OverallAnswer(Session(RequestFor({{"q", "no image"}}), {{"lab", index}}, {}).Ask());
  EXPECT_EQ(broken.verdict, Verdict::kBadImage);
}

TEST(Session, APriorThatTheMapDoesNotHaveIsABadRequest) {
  QueryRequest request = RequestFor({EncodedFlat("q")});
  request.prior_keyframe = KeyframeId{2};
  EXPECT_NO_THROW(Session(request, {{"lab", MadeIndex()}}, {}));
  request.prior_keyframe = KeyframeId{99};
  try {
    const Session session(request, {{"lab", MadeIndex()}}, {});
    ADD_FAILURE();
  } catch (const MapError& error) {
    EXPECT_EQ(error.code(), ErrorCode::kBadRequest);
  }
}

TEST(Session, ADeadlineCountsFromItsBeginning) {
  QueryRequest request = RequestFor({EncodedFlat("q")});
  EXPECT_FALSE(Session(request, {{"lab", MadeIndex()}}, {}).deadline());
  request.deadline_ms = 3'600'000;
  const Session session(request, {{"lab", MadeIndex()}}, {});
  ASSERT_TRUE(session.deadline());
  EXPECT_FALSE(HasPassed(session.deadline()));
  // What it waited before a session began counts.
  request.received = Clock::now() - std::chrono::hours(2);
  EXPECT_TRUE(HasPassed(Session(request, {{"lab", MadeIndex()}}, {}).deadline()));
  const Answer late = OverallAnswer(session.TimeOut());
  EXPECT_EQ(late.verdict, Verdict::kUndecided);
  EXPECT_EQ(late.last_stage, Stage::kQueue);
  EXPECT_EQ(late.map, "lab");
  EXPECT_EQ(late.image, "q");
  EXPECT_EQ(late.map_version, "sha256:0");
}

TEST(OverallAnswer, SeveralMapsThatRecogniseThePlaceAreAmbiguous) {
  const Answer one = OverallAnswer(AnswersWith({LocalizedIn("a", 0.97), Answer{}}));
  EXPECT_EQ(one.verdict, Verdict::kLocalized);
  const Answer two = OverallAnswer(AnswersWith({LocalizedIn("a", 0.97), LocalizedIn("b", 0.95)}));
  EXPECT_EQ(two.verdict, Verdict::kAmbiguous);
  EXPECT_EQ(two.decided_by, DecidedBy::kAmbiguousMaps);
  EXPECT_FALSE(two.planes.keyframe);
  ASSERT_EQ(two.planes.places.size(), 2u);
  EXPECT_EQ(two.planes.places[1].keyframe.source, "b.jpg");
}

TEST(OverallAnswer, AMapThatFindsThePlaceTwiceCountsAgainstAnother) {
  Answer twice;
  twice.verdict = Verdict::kAmbiguous;
  twice.probability = 0.96;
  twice.map = "b";
  for (const char* source : {"b1.jpg", "b2.jpg"}) {
    twice.planes.places.push_back({KeyframeRef{KeyframeId{1}, "walk", source, {}}, 0.96, 40});
  }
  const Answer overall = OverallAnswer(AnswersWith({LocalizedIn("a", 0.97), twice}));
  EXPECT_EQ(overall.verdict, Verdict::kAmbiguous);
  EXPECT_EQ(overall.decided_by, DecidedBy::kAmbiguousMaps);
  ASSERT_EQ(overall.planes.places.size(), 3u);
  EXPECT_EQ(overall.planes.places[0].keyframe.source, "a.jpg");
  EXPECT_EQ(overall.planes.places[2].keyframe.source, "b2.jpg");
  const Answer alone = OverallAnswer(AnswersWith({twice, Answer{}}));
  EXPECT_EQ(alone.planes.places.size(), 2u);
  EXPECT_NE(alone.decided_by, DecidedBy::kAmbiguousMaps);
}

// As those of ambiguous maps do, landmarks among them.
TEST(OverallAnswer, PlacesOfLocalizedMapsHaveTheirCandidatesInliers) {
  Answer first = LocalizedIn("a", 0.97);
  first.planes.recognised.emplace_back().inliers = 20;
  first.planes.candidates.push_back({*first.planes.keyframe, 0.97, 75});
  const Answer overall = OverallAnswer(AnswersWith({first, LocalizedIn("b", 0.95)}));
  ASSERT_EQ(overall.planes.places.size(), 2u);
  EXPECT_EQ(overall.planes.places[0].inliers, 75);
}

// They share the answer's probability; each one's own says whether the map contains the place.
TEST(OverallAnswer, PanoramasAlikeCountWhereTheyAreProbable) {
  Answer alike;
  alike.verdict = Verdict::kAmbiguous;
  alike.probability = 0.5;
  alike.map = "b";
  alike.panorama.emplace();
  alike.panorama->candidates.emplace_back().probability = 0.95;
  RequestAnswer asked = AnswersWith({LocalizedIn("a", 0.97), alike});
  EXPECT_EQ(OverallAnswer(asked).verdict, Verdict::kAmbiguous);
  asked.min_panorama_probability = 0.96;
  EXPECT_EQ(OverallAnswer(asked).verdict, Verdict::kLocalized);
  asked.min_panorama_probability = 0.9;
  asked.images[0][1].panorama->candidates[0].probability = 0.3;
  EXPECT_EQ(OverallAnswer(asked).verdict, Verdict::kLocalized);
}

TEST(OverallAnswer, OfSeveralMapsSaysNothingThatHoldsForOneAlone) {
  Answer first = LocalizedIn("a", 0.97);
  first.planes.keyframe.reset();
  first.panorama.emplace();
  first.heading = Heading{1, 0.1, HeadingFrame::kLayer};
  first.building.emplace();
  first.place_name = "Kitchen";
  first.plan = PlanPosition{"ground", {3, 4}};
  first.pose.emplace();
  Answer second = first;
  second.map = "b";
  const Answer overall = OverallAnswer(AnswersWith({first, second}));
  EXPECT_EQ(overall.verdict, Verdict::kAmbiguous);
  EXPECT_FALSE(overall.heading || overall.building || overall.place_name || overall.plan);
  EXPECT_FALSE(overall.pose);
  EXPECT_FALSE(overall.pose_reason.empty());
  EXPECT_TRUE(overall.planes.places.empty());
  EXPECT_NE(overall.message.find("2 maps contain this place (a, b)"), std::string::npos)
      << overall.message;
}

TEST(ResolveCamera, FollowsTheRequest) {
  MapData map;
  map.sequences.push_back({SequenceId{1}, "walk", "folder", 1, 0,
                           Camera{CameraModel::kPinhole, 640, 480, {500, 500, 320, 240}}});
  const QueryImage image = EncodedFlat("q", 640, 480);
  QueryRequest request;
  EXPECT_FALSE(ResolveCamera(request, map, image));
  request.fov_rad = std::numbers::pi / 2;
  EXPECT_NEAR(ResolveCamera(request, map, image)->camera.params[0], 320, 1e-9);
  EXPECT_EQ(ResolveCamera(request, map, image)->source, CameraSource::kFov);
  EXPECT_FALSE(ResolveCamera(request, map, {"q", "no image"}));
  request.fov_rad.reset();
  request.stored_camera = "walk";
  EXPECT_EQ(ResolveCamera(request, map, image)->camera, map.sequences[0].camera);
  EXPECT_EQ(ResolveCamera(request, map, image)->source, CameraSource::kStored);
  EXPECT_THROW(ResolveCamera(request, map, EncodedFlat("q", 320, 240)), MapError);
  request.stored_camera = "run";
  EXPECT_THROW(ResolveCamera(request, map, image), MapError);
}

}  // namespace
}  // namespace waystone
