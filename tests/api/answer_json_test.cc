// SPDX-License-Identifier: Apache-2.0
#include "api/answer_json.h"

#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <limits>
#include <string>
#include <vector>

namespace waystone {
namespace {

Answer Localized() {
  Answer answer;
  answer.verdict = Verdict::kLocalized;
  answer.probability = 0.98;
  answer.image = "q.jpg";
  answer.map = "lab";
  answer.map_version = "sha256:00";
  answer.planes.keyframe = KeyframeRef{KeyframeId{17}, "kitchen", "rgb/000120.jpg", 4.0};
  answer.heading = Heading{0.31, 0.02, HeadingFrame::kKeyframe};
  RecognisedPlane plane;
  plane.id = PlaneId{3};
  plane.inliers = 143;
  plane.reference = {KeyframeId{12}, "kitchen", "rgb/000080.jpg", 2.5};
  plane.reference_from_query << 1.02, 0.01, -14.2, 0.0, 1.01, 3.3, 0.0, 0.0, 1.0;
  plane.outline = {{12.5, 80.0}, {400.0, 91.2}};
  plane.expect_next = {PlaneId{5}, PlaneId{7}};
  answer.planes.recognised.push_back(plane);
  answer.planes.runner_up = PlaceCandidate{{KeyframeId{90}, "kitchen", "rgb/9.jpg", {}}, 0.01, 12};
  answer.decided_by = DecidedBy::kHomographyInliers;
  answer.timing = {2.9, 58.1, 6.0, 2.2, 0, 69.4};
  return answer;
}

// Both have the same fields in the same order, but for what is null in one of them.
void ExpectSameFields(const Json& one, const Json& other, const std::string& path) {
  if (one.is_null() || other.is_null()) return;
  ASSERT_TRUE(one.type() == other.type() || (one.is_number() && other.is_number())) << path;
  if (one.is_array() && !one.empty()) {
    ASSERT_FALSE(other.empty()) << path;
    ExpectSameFields(one[0], other[0], path + "/0");
  }
  if (!one.is_object()) return;
  std::vector<std::string> names, other_names;
  for (const auto& [name, value] : one.items()) names.push_back(name);
  for (const auto& [name, value] : other.items()) other_names.push_back(name);
  ASSERT_EQ(names, other_names) << path;
  for (const std::string& name : names) {
    ExpectSameFields(one[name], other[name], path + "/" + name);
  }
}

TEST(AnswerJson, HasTheFieldsThatTheReadmeShows) {
  std::ifstream file(WAYSTONE_SOURCE_DIR "/README.md");
  const std::string readme(std::istreambuf_iterator<char>(file), {});
  const std::string fence = "```json\n";
  const size_t start = readme.find(fence + R"({"verdict":"localized")") + fence.size();
  const Json shown = Json::parse(readme.substr(start, readme.find("```", start) - start));
  Answer answer = Localized();
  answer.planes.epipolar = EpipolarMatches{answer.planes.keyframe.value(), 212, 287, {}, {}};
  ExpectSameFields(shown, ToJson(answer), "");
}

TEST(AnswerJson, LocalizedIsByteForByteTheSame) {
  EXPECT_EQ(
      Dump(ToJson(Localized())),
      R"({"verdict":"localized","probability":0.98,"image":"q.jpg","map":"lab",)"
      R"("map_version":"sha256:00",)"
      R"("place":{"layer":"planes","id":17,"name":null,"image":"rgb/000120.jpg","sequence":"kitchen",)"
      R"("time_s":4.0,"position":null,"heading":{"rad":0.31,"deviation_rad":0.02,"of":"keyframe"},)"
      R"("plan":null},)"
      R"("keyframe":{"id":17,"sequence":"kitchen","source":"rgb/000120.jpg","time_s":4.0},)"
      R"("heading":{"rad":0.31,"deviation_rad":0.02,"of":"keyframe"},)"
      R"("planes":[{"id":3,"inliers":143,"reference":{"id":12,"source":"rgb/000080.jpg"},)"
      R"("reference_from_query":[[1.02,0.01,-14.2],[0.0,1.01,3.3],[0.0,0.0,1.0]],)"
      R"("outline":[[12.5,80.0],[400.0,91.2]],"expect_next":[5,7]}],)"
      R"("runner_up":{"keyframe":{"id":90},"probability":0.01},)"
      R"("decided_by":"homography_inliers",)"
      R"("timing_ms":{"decode":2.9,"extract":58.1,"shortlist":6.0,"verify":2.2,"total":69.4}})");
}

// A place that no plane shows: its planes are empty, and its matches with the keyframe are there.
TEST(AnswerJson, LandmarksGiveEpipolarInliers) {
  Answer answer = Localized();
  answer.planes.recognised.clear();
  answer.planes.epipolar = EpipolarMatches{
      {KeyframeId{17}, "kitchen", "rgb/000120.jpg", 4.0}, 31, 40, {{1, 2}}, {{3, 4}}};
  answer.decided_by = DecidedBy::kEpipolarInliers;
  const Json json = ToJson(answer);
  EXPECT_TRUE(json["planes"].empty());
  EXPECT_EQ(json["keyframe"]["id"], 17);
  EXPECT_EQ(Dump(json["epipolar"]),
            R"({"keyframe":{"id":17,"source":"rgb/000120.jpg"},"inliers":31,"matches":40})");
  EXPECT_EQ(json["decided_by"], "epipolar_inliers");
  EXPECT_FALSE(ToJson(Localized()).contains("epipolar"));
}

Answer LocalizedPanorama() {
  Answer answer;
  answer.verdict = Verdict::kLocalized;
  answer.probability = 0.97;
  answer.heading = Heading{0.31, 0.02, HeadingFrame::kLayer};
  const NodeRef node{AppearanceNodeId{7}, "walk", "7.jpg", {}, {}};
  answer.panorama = PanoramaAnswer{.node = node,
                                   .pose = {1.5, -2, 0.31},
                                   .sigma = 0.25,
                                   .metres_per_unit = 0.5,
                                   .candidates = {{node, 0.97, 0.4, 120, {}}},
                                   .runner_up = {}};
  answer.decided_by = DecidedBy::kPanoramaFeatures;
  return answer;
}

TEST(AnswerJson, APanoramaHasItsPlace) {
  EXPECT_EQ(Dump(ToJson(LocalizedPanorama())["panorama"]),
            R"({"node":{"id":7,"sequence":"walk","source":"7.jpg","time_s":null},)"
            R"("position":{"x":1.5,"y":-2.0,"deviation":0.25,"metres_per_unit":0.5},)"
            R"("candidates":[{"node":{"id":7,"sequence":"walk","source":"7.jpg","time_s":null},)"
            R"("probability":0.97,"cost":0.4,"inliers":120}],"runner_up":null})");
}

TEST(AnswerJson, EveryLayerHasOnePlace) {
  EXPECT_EQ(
      Dump(ToJson(LocalizedPanorama())["place"]),
      R"({"layer":"appearance","id":7,"name":null,"image":"7.jpg","sequence":"walk","time_s":null,)"
      R"("position":{"x":1.5,"y":-2.0,"deviation":0.25,"metres_per_unit":0.5},)"
      R"("heading":{"rad":0.31,"deviation_rad":0.02,"of":"layer"},"plan":null})");
  Answer planned = LocalizedPanorama();
  planned.plan = PlanPosition{"Ground floor", {512.345, 88}};
  EXPECT_EQ(Dump(ToJson(planned)["place"]["plan"]),
            R"({"name":"Ground floor","x":512.35,"y":88.0})");
  EXPECT_EQ(ToJson(Localized())["place"]["layer"], "planes");
}

TEST(AnswerJson, ARefusedPanoramaHasNoPlace) {
  Answer answer = LocalizedPanorama();
  answer.verdict = Verdict::kNotInMap;
  EXPECT_TRUE(ToJson(answer)["place"].is_null());
  const Json panorama = ToJson(answer)["panorama"];
  EXPECT_TRUE(panorama["node"].is_null());
  EXPECT_TRUE(panorama["position"].is_null());
  EXPECT_EQ(panorama["candidates"].size(), 1U);
}

TEST(AnswerJson, WhatIsAbsentIsNull) {
  Answer answer;
  answer.message = "nothing here";
  EXPECT_EQ(
      Dump(ToJson(answer)),
      R"({"verdict":"not_in_map","probability":0.0,"image":"","map":"","map_version":"",)"
      R"("place":null,"keyframe":null,"heading":null,"planes":[],"runner_up":null,"decided_by":"",)"
      R"("message":"nothing here","timing_ms":{"decode":0.0,"extract":0.0,"shortlist":0.0,)"
      R"("verify":0.0,"total":0.0}})");
}

TEST(AnswerJson, PlacesOnlyWhenAmbiguous) {
  Answer answer = Localized();
  EXPECT_FALSE(ToJson(answer).contains("places"));
  EXPECT_FALSE(ToJson(answer).contains("message"));
  answer.verdict = Verdict::kAmbiguous;
  answer.planes.keyframe.reset();
  answer.planes.places = {{{KeyframeId{1}, "s", "a.jpg", {}}, 0.5, 40},
                          {{KeyframeId{2}, "s", "b.jpg", 1.0}, 0.4, 39}};
  const Json json = ToJson(answer);
  EXPECT_TRUE(json["keyframe"].is_null());
  EXPECT_EQ(json["places"].size(), 2u);
  EXPECT_EQ(json["places"][0]["keyframe"]["time_s"], nullptr);
  EXPECT_TRUE(json.contains("message"));
}

TEST(AnswerJson, NamesThatAreNotUtf8DoNotThrow) {
  Answer answer = Localized();
  answer.image = "caf\xE9.jpg";
  const std::string text = Dump(ToJson(answer));
  EXPECT_TRUE(Json::accept(text)) << text;
}

TEST(AnswerJson, HomographiesKeepTheirDigits) {
  Answer answer = Localized();
  answer.planes.recognised[0].reference_from_query(2, 0) = 1.23456789012345e-5;
  const Json json = Json::parse(Dump(ToJson(answer)));
  EXPECT_EQ(json["planes"][0]["reference_from_query"][2][0].get<double>(), 1.23456789012345e-5);
}

TEST(AnswerJson, NumbersThatAreNoneStayJson) {
  Answer answer = Localized();
  answer.planes.recognised[0].outline[0].x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(Json::accept(Dump(ToJson(answer))));
}

}  // namespace
}  // namespace waystone
