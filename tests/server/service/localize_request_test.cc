// SPDX-License-Identifier: Apache-2.0
#include "server/service/localize_request.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>
#include <string>

#include "core/base/error.h"
#include "server/http/body_parts.h"

namespace waystone {
namespace {

using Query = std::map<std::string, std::string>;

QueryRequest Read(const std::string& type, const std::string& body, const Query& query = {}) {
  HttpRequest request;
  request.query = query;
  request.header = [&](const std::string&) { return type; };
  request.read_body = [&] { return body; };
  return ReadQueryRequest(request, {.max_images = 3});
}

std::string Refusal(const std::string& type, const std::string& body, const Query& query = {}) {
  try {
    Read(type, body, query);
  } catch (const MapError& error) {
    return error.what();
  }
  return "";
}

ErrorCode CodeOf(const std::string& type, const std::string& body, const Query& query = {}) {
  try {
    Read(type, body, query);
  } catch (const MapError& error) {
    return error.code();
  }
  return ErrorCode::kInternal;
}

std::string Part(const std::string& disposition, const std::string& bytes) {
  return "--B\r\nContent-Disposition: form-data; " + disposition + "\r\n\r\n" + bytes + "\r\n";
}

const char* const kForm = "Multipart/Form-Data; boundary=\"B\"";

TEST(LocalizeRequest, RawBytesTakeQueryParameters) {
  const QueryRequest request = Read("image/jpeg", "bytes",
                                    {{"name", "a.jpg"},
                                     {"fx", "500"},
                                     {"fy", "501.5"},
                                     {"cx", "320"},
                                     {"cy", "-1e1"},
                                     {"prior_keyframe", "7"},
                                     {"top_k", "3"},
                                     {"debug", "true"},
                                     {"deadline_ms", "250"}});
  ASSERT_EQ(request.images.size(), 1u);
  EXPECT_EQ(request.images[0].name, "a.jpg");
  EXPECT_EQ(request.images[0].bytes, "bytes");
  EXPECT_EQ(request.intrinsics->fy, 501.5);
  EXPECT_EQ(request.intrinsics->cy, -10);
  EXPECT_EQ(request.prior_keyframe, KeyframeId{7});
  EXPECT_EQ(request.top_k, 3);
  EXPECT_TRUE(request.debug);
  EXPECT_EQ(request.deadline_ms, 250);
}

TEST(LocalizeRequest, FormsHoldSeveralImagesAndARequest) {
  const QueryRequest request =
      Read(kForm, Part("name=\"image\"; filename=\"left \\\"1\\\".jpg\"", "one\r\n--A") +
                      Part("name=request", R"({"fov_deg": 90, "previous": {"keyframe": 3}})") +
                      Part("name=image", "") + "--B--\r\n");
  ASSERT_EQ(request.images.size(), 2u);
  EXPECT_EQ(request.images[0].name, "left \"1\".jpg");
  EXPECT_EQ(request.images[0].bytes, "one\r\n--A");
  EXPECT_EQ(request.images[1].bytes, "");
  EXPECT_NEAR(*request.fov_rad, std::numbers::pi / 2, 1e-12);
  EXPECT_EQ(request.previous->keyframe, KeyframeId{3});
  EXPECT_FALSE(request.previous->belief);
}

// RFC 2046, section 5.1.1, and RFC 5322, section 2.2.3.
TEST(LocalizeRequest, FormsMayHaveAPreamblePaddingAndFoldedHeaders) {
  const std::string part = Part("name=image; filename=a.jpg", "one");
  const std::string end = "--B--\r\n";
  const std::string padded = "--B \t" + part.substr(3);
  const std::string folded =
      "--B\r\nContent-Type: image/jpeg;\r\n name=request\r\nContent-Disposition: form-data;\r\n"
      "\tname=image;\r\n  filename=a.jpg\r\n\r\none\r\n";
  for (const std::string& body : {"\r\n" + part + end, "This is a form: --B\r\n\r\n" + part + end,
                                  padded + end, part + padded + end, folded + end}) {
    const QueryRequest request = Read(kForm, body);
    ASSERT_FALSE(request.images.empty()) << body;
    EXPECT_EQ(request.images.back().name, "a.jpg") << body;
    EXPECT_EQ(request.images.back().bytes, "one") << body;
  }
}

TEST(LocalizeRequest, JsonHoldsBase64) {
  const QueryRequest request = Read("application/json; charset=utf-8",
                                    R"({"camera":"walk","images":[{"name":"x","data":"aGVsbG8="},)"
                                    R"({"data":"data:image/png;base64,aGk="}]})");
  EXPECT_EQ(request.stored_camera, "walk");
  EXPECT_EQ(request.images[0].bytes, "hello");
  EXPECT_EQ(request.images[1].bytes, "hi");
}

TEST(LocalizeRequest, ASeriesHasABeliefAndMotionsAndComesBackFromTheLog) {
  const QueryRequest request =
      Read("application/json",
           R"({"images":[{"data":""},{"data":""}],"previous":{"map_version":"v","belief":[)"
           R"({"node":3,"probability":0.5,"heading_rad":1,"deviation_rad":0.1}]},)"
           R"("odometry":[null,{"x":1,"y":-2,"heading_rad":0.5}]})");
  EXPECT_EQ(request.previous->map_version, "v");
  EXPECT_EQ(request.previous->belief->at(0), (NodeBelief{AppearanceNodeId{3}, 0.5, 1, 0.1}));
  ASSERT_EQ(request.odometry.size(), 2u);
  EXPECT_FALSE(request.odometry[0]);
  EXPECT_EQ(request.odometry[1], (Pose2{1, -2, 0.5}));
  const QueryRequest again = ParseQueryRequest(ToJson(request), {});
  EXPECT_EQ(again.odometry, request.odometry);
  EXPECT_EQ(again.previous, request.previous);
}

// To JSON Schema, 2.0 is an integer.
TEST(LocalizeRequest, IntegersMayHaveAFractionOfZero) {
  const QueryRequest request =
      Read("application/json",
           R"({"images":[{"data":""}],"top_k":2.0,"deadline_ms":5e3,"prior":{"keyframe":7.0}})");
  EXPECT_EQ(request.top_k, 2);
  EXPECT_EQ(request.deadline_ms, 5000);
  EXPECT_EQ(request.prior_keyframe, KeyframeId{7});
  EXPECT_EQ(Read("image/jpeg", "x", {{"top_k", "2.0"}}).top_k, 2);
  for (const char* keyframe : {"9223372036854775808.0", "-1.0", "0.0", "1e300", "7.5"}) {
    EXPECT_EQ(CodeOf("image/jpeg", "x", {{"prior_keyframe", keyframe}}), ErrorCode::kBadRequest)
        << keyframe;
  }
}

TEST(LocalizeRequest, WhatIsWrongIsABadRequest) {
  const std::vector<Query> queries = {
      {{"fx", "500"}},
      {{"fov_deg", "0"}},
      {{"fov_deg", "x"}},
      {{"fov_deg", "[60]"}},
      {{"fov_deg", "60"}, {"camera", "walk"}},
      {{"fx", "0"}, {"fy", "1"}, {"cx", "1"}, {"cy", "1"}},
      {{"fx", "1e999"}, {"fy", "1"}, {"cx", "1"}, {"cy", "1"}},
      {{"top_k", "0"}},
      {{"top_k", "2.5"}},
      {{"top_k", "99999999999999999999"}},
      {{"deadline_ms", "0"}},
      {{"debug", "maybe"}},
      {{"prior", "7"}},
      {{"prior_keyframe", "-1"}},
      {{"unknown", "1"}},
  };
  for (const Query& query : queries) {
    EXPECT_EQ(CodeOf("image/jpeg", "x", query), ErrorCode::kBadRequest) << query.begin()->first;
  }
  const std::string deep(100'000, '[');
  for (const std::string& body : std::vector<std::string>{
           "", "null", "[]", "{", deep, "{\"images\":[]}", R"({"images":[{"data":"a"}]})",
           R"({"images":[{"data":"=aaa"}]})", R"({"images":[{"data":"a\na="}]})",
           R"({"images":[{"data":7}]})", R"({"images":[{}]})", R"({"images":{"data":""}})",
           R"({"images":[{"data":""},{"data":""},{"data":""},{"data":""}]})",
           R"({"images":[{"data":""}],"other":1})",
           R"({"images":[{"data":""}],"prior":{"keyframe":1.5}})",
           R"({"images":[{"data":""}],"previous":{"pose":1}})",
           R"({"images":[{"data":""}],"previous":{"belief":7}})",
           R"({"images":[{"data":""}],"previous":{"belief":[{"node":1,"probability":1}]}})",
           // NOLINTNEXTLINE(bugprone-suspicious-missing-comma)
           R"({"images":[{"data":""}],"previous":{"belief":[{"node":1,"probability":2,)"
           R"("heading_rad":0,"deviation_rad":1}]}})",
           R"({"images":[{"data":""}],"odometry":[]})",
           R"({"images":[{"data":""}],"odometry":[{"x":1,"y":2}]})",
           R"({"images":[{"data":""}],"odometry":[null,null]})",
           R"({"images":[{"data":""}],"debug":1})", "{\"images\":[{\"name\":\"\xff\"}]}"}) {
    EXPECT_EQ(CodeOf("application/json", body), ErrorCode::kBadRequest) << body.substr(0, 80);
  }
  EXPECT_EQ(CodeOf("application/json", R"({"images":[{"data":""}]})", {{"top_k", "1"}}),
            ErrorCode::kBadRequest);
}

TEST(LocalizeRequest, FieldsThatAreGivenTwiceAreNamed) {
  EXPECT_EQ(Refusal("application/json", R"({"fov_deg":60,"images":[{"data":""}],"fov_deg":90})"),
            "the JSON has the field 'fov_deg' more than once in an object; give it once");
  EXPECT_NE(Refusal("application/json", R"({"images":[{"data":"","data":""}]})").find("'data'"),
            std::string::npos);
  EXPECT_EQ(Refusal("application/json", R"({"images":[{"data":""},{"data":""}]})"), "");
}

// The parser compares a field's name with all before it: 10,000 long ones took seconds.
TEST(LocalizeRequest, ObjectsHaveABound) {
  const auto with_fields = [](int count, size_t bytes) {
    std::string body = R"({"images":[{"data":""}])";
    for (int i = 0; i < count; ++i) {
      std::string name(bytes, 'n');
      name.replace(0, 5, std::to_string(10'000 + i));
      body += ",\"" + name + "\":1";
    }
    return body + "}";
  };
  EXPECT_NE(Refusal("application/json", with_fields(63, 200)).find("unknown"), std::string::npos);
  EXPECT_NE(Refusal("application/json", with_fields(64, 200)).find("more than 64 fields"),
            std::string::npos);
  EXPECT_NE(Refusal("application/json", with_fields(1, 201)).find("201 bytes; the limit is 200"),
            std::string::npos);
}

TEST(LocalizeRequest, JsonThatCannotBeReadSaysWhere) {
  EXPECT_EQ(Refusal("application/json", R"({"images":)"),
            "invalid JSON: it ends too early, after 10 bytes");
  EXPECT_EQ(Refusal("application/json", R"({"top_k":])"),
            "invalid JSON: unexpected text at byte 10");
  EXPECT_EQ(Refusal("application/json", R"({"fx":1e999})"),
            "invalid JSON: a number in it is too large");
}

TEST(LocalizeRequest, NamesHaveABound) {
  EXPECT_EQ(Read("image/jpeg", "x", {{"name", std::string(200, 'n')}}).images[0].name.size(), 200u);
  EXPECT_EQ(Refusal("image/jpeg", "x", {{"name", std::string(201, 'n')}}),
            "name must be a string of at most 200 bytes");
}

TEST(LocalizeRequest, BrokenFormsAreBadRequests) {
  const std::string image = Part("name=image", "x");
  for (const std::string& body : std::vector<std::string>{
           "", "x", "--B", "--B--", "--B\r\n", "--B\r\n--B--", image, image + "--Bx",
           "x" + image + "--B--", "--B x" + image.substr(3) + "--B--", "--B  ", image + "--B --",
           "--B\r\n\r\nx\r\n--B--", Part("name=x", "") + "--B--", Part("filename=x", "") + "--B--",
           Part("name=request", "{}") + "--B--",
           Part("name=request", "{}") + Part("name=request", "{}") + "--B--",
           image + image + image + image + "--B--",
           image + Part("name=request", "[1]") + "--B--"}) {
    EXPECT_EQ(CodeOf(kForm, body), ErrorCode::kBadRequest) << body.substr(0, 80);
  }
  EXPECT_EQ(CodeOf("multipart/form-data", image + "--B--"), ErrorCode::kBadRequest);
  EXPECT_EQ(CodeOf("multipart/form-data; boundary=" + std::string(80, 'x'), image),
            ErrorCode::kBadRequest);
}

TEST(LocalizeRequest, ObjectsSurviveTheLog) {
  QueryRequest request = Read("image/jpeg", "x", {{"fov_deg", "60"}, {"top_k", "2"}});
  const QueryRequest again = ParseQueryRequest(ToJson(request), {});
  EXPECT_NEAR(*again.fov_rad, *request.fov_rad, 1e-12);
  EXPECT_EQ(again.top_k, 2);
}

TEST(LocalizeRequest, UnknownQueryParametersAreNamed) {
  const std::string refusal = Refusal("image/jpeg", "bytes", {{"foo", "abc"}});
  EXPECT_NE(refusal.find("unknown"), std::string::npos) << refusal;
  EXPECT_NE(refusal.find("foo"), std::string::npos) << refusal;
  EXPECT_NE(Refusal("image/jpeg", "bytes", {{"top_k", "many"}}).find("top_k"), std::string::npos);
}

TEST(LocalizeRequest, WhatIsKnownIsListedWhereItIsValid) {
  const std::string url = Refusal("image/jpeg", "bytes", {{"foo", "abc"}});
  const std::string json = Refusal("application/json", R"({"images":[{"data":""}],"foo":1})");
  const std::string form = Refusal(kForm, Part("name=request", R"({"foo":1})") + "--B--");
  const auto lists = [](const std::string& refusal, const std::string& name) {
    const std::string known =
        refusal.substr(std::min(refusal.find("; known"), refusal.size())) + ",";
    return known.find(" " + name + ",") != std::string::npos;
  };
  for (const char* name : {"camera", "cx", "deadline_ms", "debug", "fov_deg", "top_k"}) {
    for (const std::string& refusal : {url, json, form}) EXPECT_TRUE(lists(refusal, name)) << name;
  }
  for (const char* name : {"name", "prior_keyframe"}) {
    EXPECT_TRUE(lists(url, name)) << url;
    EXPECT_FALSE(lists(json, name)) << json;
  }
  for (const char* name : {"hints", "odometry", "previous", "prior"}) {
    EXPECT_FALSE(lists(url, name)) << url;
    EXPECT_TRUE(lists(json, name)) << json;
    EXPECT_TRUE(lists(form, name)) << form;
  }
  EXPECT_TRUE(lists(json, "images")) << json;
  EXPECT_FALSE(lists(form, "images")) << form;
}

}  // namespace
}  // namespace waystone
