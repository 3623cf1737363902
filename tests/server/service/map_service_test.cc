// SPDX-License-Identifier: Apache-2.0
#include "server/service/application.h"

#include <gtest/gtest.h>

#include <memory>
#include <set>
#include <string>
#include <vector>

#include "api/graph_formats.h"
#include "api/json.h"
#include "api/map_json.h"
#include "core/base/error.h"
#include "core/base/version.h"
#include "core/image/decode.h"
#include "core/image/encode.h"
#include "server/http/router.h"
#include "server/service/map_catalog.h"
#include "server/service/map_service.h"
#include "tests/server/service/made_map.h"
#include "tests/server/service/made_picture.h"

namespace waystone {
namespace {

// The maps as the whole application shows them.
class MapServiceTest : public testing::Test {
 protected:
  MapServiceTest()
      : app_({{"lab", MapIndex::Build(MadeMap(7))}, {"a b", MapIndex::Build(MadeMap(1))}}, {}, {}) {
  }

  HttpResponse Get(const std::string& path, const std::map<std::string, std::string>& query = {},
                   const std::string& if_none_match = "") {
    HttpRequest request;
    request.method = "GET";
    request.path = path;
    request.query = query;
    request.header = [&](const std::string& name) -> std::optional<std::string> {
      if (name == "If-None-Match" && !if_none_match.empty()) return if_none_match;
      return std::nullopt;
    };
    return app_.Answer(request);
  }

  Json GetJson(const std::string& path, const std::map<std::string, std::string>& query = {}) {
    const HttpResponse response = Get(path, query);
    EXPECT_EQ(response.status, 200) << path << ": " << response.body;
    EXPECT_EQ(response.content_type, "application/json");
    return Json::parse(response.body);
  }

  HttpResponse Post(const std::string& type, const std::string& body,
                    const std::string& debug = "false") {
    HttpRequest request;
    request.method = "POST";
    request.path = "/v1/maps/lab/localize";
    request.query["name"] = "q.jpg";
    request.query["debug"] = debug;
    request.header = [&](const std::string& name) -> std::optional<std::string> {
      if (name == "Content-Type" && !type.empty()) return type;
      return std::nullopt;
    };
    request.read_body = [&] { return body; };
    return app_.Answer(request);
  }

  static std::string HeaderOf(const HttpResponse& response, const std::string& name) {
    for (const auto& [key, value] : response.headers) {
      if (key == name) return value;
    }
    return "";
  }

  Application app_;
};

TEST_F(MapServiceTest, HealthAndHome) {
  EXPECT_EQ(Get("/healthz").body, "ok\n");
  const HttpResponse home = Get("/");
  EXPECT_EQ(home.content_type, "text/html; charset=utf-8");
  const HttpResponse plain = Get("/plain");
  EXPECT_EQ(plain.content_type, "text/html; charset=utf-8");
  EXPECT_NE(plain.body.find("/v1/maps/lab/localize"), std::string::npos);
  EXPECT_NE(plain.body.find("/v1/maps/a%20b/localize"), std::string::npos);
}

TEST_F(MapServiceTest, OverviewHasEverythingByColumns) {
  const Json json = GetJson("/v1/maps/lab/overview");
  EXPECT_EQ(json["layers"], Json({"planes"}));
  EXPECT_EQ(json["keyframes"]["id"], Json({1, 2}));
  EXPECT_EQ(json["keyframes"]["planes"], Json({7, 7}));
  EXPECT_EQ(json["keyframes"]["features"], Json({35, 35}));
  EXPECT_EQ(json["planes"]["id"].size(), 7u);
  EXPECT_EQ(json["planes"]["keyframes"][3], Json({1, 2}));
  EXPECT_EQ(json["planes"]["stretch"][0], 0);
  EXPECT_EQ(json["planes"]["surface"], Json({1, 2, 2, 4, 5, 6, 7}));
  EXPECT_EQ(json["edges"]["a"], Json({1, 2, 3, 4, 5, 6}));
  EXPECT_EQ(json["edges"]["third_eigenvalue"][0], 1.5);
}

TEST_F(MapServiceTest, AuditsAMap) {
  const Json json = GetJson("/v1/maps/lab/audit");
  EXPECT_TRUE(json["aliases"].is_array());
  EXPECT_TRUE(json["ties"].is_array());
  ASSERT_FALSE(json["weak"].empty()) << "35 features in view at either keyframe";
  EXPECT_EQ(json["weak"][0]["first"]["id"], 1);
  EXPECT_NE(json["weak"][0]["advice"], "");
  EXPECT_EQ(GetJson("/v1/maps/lab/audit"), json) << "the same when asked again";
}

TEST_F(MapServiceTest, DebugIsASwitch) {
  EXPECT_EQ(Post("image/jpeg", "no image", "true").status, 200);
  const HttpResponse bad = Post("image/jpeg", "no image", "perhaps");
  EXPECT_EQ(bad.status, 400);
  EXPECT_NE(bad.body.find("debug=perhaps"), std::string::npos);
}

TEST_F(MapServiceTest, ListsMaps) {
  const Json json = GetJson("/v1/maps");
  ASSERT_EQ(json["maps"].size(), 2u);
  EXPECT_EQ(json["maps"][1]["name"], "lab");
  EXPECT_EQ(json["maps"][1]["planes"], 7);
  EXPECT_EQ(json["maps"][1]["surfaces"], 6);
  EXPECT_EQ(json["maps"][1]["edges"], 6);
  EXPECT_EQ(json["maps"][1]["features"], 35);
  EXPECT_TRUE(json["next"].is_null());
  const Json page = GetJson("/v1/maps", {{"limit", "1"}});
  EXPECT_EQ(page["maps"].size(), 1u);
  EXPECT_EQ(GetJson("/v1/maps", {{"cursor", page["next"]}})["maps"][0]["name"], "lab");
}

TEST_F(MapServiceTest, ShowsAMap) {
  const Json json = GetJson("/v1/maps/lab");
  EXPECT_EQ(json["version"], "sha256:abc123");
  EXPECT_EQ(json["sequences"][0]["name"], "kit\"chen");
  EXPECT_EQ(json["sequences"][0]["camera"], nullptr);
}

TEST_F(MapServiceTest, PagesPlanes) {
  std::set<int> ids;
  std::map<std::string, std::string> query = {{"limit", "3"}};
  for (int page = 0; page < 3; ++page) {
    const Json json = GetJson("/v1/maps/lab/planes", query);
    for (const Json& plane : json["planes"]) ids.insert(plane["id"].get<int>());
    EXPECT_EQ(json["next"].is_null(), page == 2);
    if (!json["next"].is_null()) query["cursor"] = json["next"];
  }
  EXPECT_EQ(ids.size(), 7u);
  EXPECT_EQ(Get("/v1/maps/lab/planes", {{"cursor", "bogus"}}).status, 400);
}

TEST_F(MapServiceTest, ShowsAPlane) {
  const Json json = GetJson("/v1/maps/lab/planes/2");
  EXPECT_EQ(json["surface"], 2);
  EXPECT_EQ(GetJson("/v1/maps/lab/planes/3")["surface"], 2);
  EXPECT_EQ(json["neighbours"], Json({1, 3}));
  EXPECT_EQ(json["features"].size(), 5u);
  EXPECT_EQ(json["views"][1]["reference_from_keyframe"][0][2], 4.25);
  EXPECT_EQ(json["outline"][1][0], 100.12);
  EXPECT_EQ(json["reference"]["source"], "rgb/0.jpg");
}

TEST_F(MapServiceTest, ShowsTheGraph) {
  const Json json = GetJson("/v1/maps/lab/graph");
  EXPECT_EQ(json["nodes"].size(), 7u);
  EXPECT_EQ(json["nodes"][2]["surface"], 2);
  EXPECT_EQ(json["edges"].size(), 6u);
  EXPECT_EQ(json["edges"][0]["third_eigenvalue"], 1.5);
}

TEST_F(MapServiceTest, ShowsKeyframesAndTheirImages) {
  const Json json = GetJson("/v1/maps/lab/keyframes");
  ASSERT_EQ(json["keyframes"].size(), 2u);
  EXPECT_EQ(json["keyframes"][0]["image"], "/v1/maps/lab/keyframes/1/image");
  EXPECT_TRUE(json["keyframes"][1]["image"].is_null());
  EXPECT_EQ(json["keyframes"][0]["sequence_id"], 1);
  EXPECT_EQ(json["keyframes"][0]["landmarks"], 0);
  EXPECT_EQ(GetJson("/v1/maps/lab/keyframes/2")["planes"].size(), 7u);
  EXPECT_EQ(GetJson("/v1/maps/lab/keyframes/2")["planes"][2]["surface"], 2);
  EXPECT_EQ(GetJson("/v1/maps/a b/keyframes/1")["image"], "/v1/maps/a%20b/keyframes/1/image");
  const HttpResponse image = Get("/v1/maps/lab/keyframes/1/image");
  EXPECT_EQ(image.content_type, "image/jpeg");
  EXPECT_EQ(image.body, "\xFF\xD8\xFF\xD9");
  EXPECT_EQ(Get("/v1/maps/lab/keyframes/2/image").status, 404);
}

TEST_F(MapServiceTest, WhatIsNotThereIsNotFound) {
  for (const char* path :
       {"/v1", "/v1/maps/nowhere", "/v1/maps/lab/planes/99", "/v1/maps/lab/planes/x",
        "/v1/maps/lab/planes/0", "/v1/maps/lab/planes/2x", "/v1/maps/lab/planes/-1",
        "/v1/maps/lab/planes/99999999999999999999", "/v1/maps/lab/keyframes/3",
        "/v1/maps/nowhere/graph"}) {
    const HttpResponse response = Get(path);
    EXPECT_EQ(response.status, 404) << path;
    EXPECT_EQ(response.content_type, "application/problem+json");
  }
}

TEST_F(MapServiceTest, AnEncodedSlashIsPartOfAName) {
  for (const char* path : {"/v1/maps/lab%2Fplanes", "/v1/maps/lab%2Fplanes/2", "/v1%2Fmaps/lab",
                           "/v1/maps/lab/planes%2F2", "/v1/maps/..%2Flab"}) {
    EXPECT_EQ(Get(path).status, 404) << path;
  }
  const std::string body = Get("/v1/maps/lab%2Fplanes").body;
  EXPECT_NE(body.find("no map 'lab/planes'"), std::string::npos) << body;
}

TEST_F(MapServiceTest, SameVersionIsNotSentAgain) {
  const std::string etag = HeaderOf(Get("/v1/maps/lab/graph"), "ETag");
  EXPECT_EQ(etag, std::string("\"sha256:abc123-") + kVersion + "\"");
  const HttpResponse again = Get("/v1/maps/lab/graph", {}, "\"other\", " + etag);
  EXPECT_EQ(again.status, 304);
  EXPECT_EQ(again.body, "");
  EXPECT_EQ(HeaderOf(again, "ETag"), etag);
  EXPECT_EQ(Get("/v1/maps/lab/graph", {}, "\"other\"").status, 200);
  EXPECT_EQ(Get("/v1/maps/lab/graph", {}, "*").status, 304);
  EXPECT_EQ(Get("/v1/maps/lab/planes/99", {}, etag).status, 404);
}

TEST_F(MapServiceTest, BytesThatAreNoImageAreAnAnswer) {
  const HttpResponse response = Post("image/jpeg", "this is text");
  EXPECT_EQ(response.status, 200) << response.body;
  const Json json = Json::parse(response.body);
  EXPECT_EQ(json["verdict"], "bad_image");
  EXPECT_EQ(json["map"], "lab");
  EXPECT_EQ(json["image"], "q.jpg");
  EXPECT_NE(json["message"], "");
}

TEST_F(MapServiceTest, TakesImagesByTheirTypeAlone) {
  for (const char* type : {"", "image/png", "IMAGE/JPEG", "application/octet-stream",
                           "image/jpeg; charset=x", "application/x-www-form-urlencoded"}) {
    EXPECT_EQ(Post(type, "x").status, 200) << type;
  }
  for (const char* type : {"text/plain", "multipart/mixed", "imagine/jpeg", "text/json"}) {
    EXPECT_EQ(Post(type, "x").status, 415) << type;
  }
}

TEST_F(MapServiceTest, PagesFeaturesAndViews) {
  const Json features = GetJson("/v1/maps/lab/planes/2/features", {{"limit", "4"}});
  EXPECT_EQ(features["features"].size(), 4u);
  EXPECT_EQ(GetJson("/v1/maps/lab/planes/2/features", {{"cursor", features["next"]}})["features"],
            Json::array({GetJson("/v1/maps/lab/planes/2")["features"][4]}));
  EXPECT_EQ(GetJson("/v1/maps/lab/planes/2/views")["views"][1]["keyframe"], 2);
  EXPECT_EQ(Get("/v1/maps/lab/planes/99/views").status, 404);
}

TEST_F(MapServiceTest, GraphForOtherPrograms) {
  const HttpResponse graphml = Get("/v1/maps/lab/graph", {{"format", "graphml"}});
  EXPECT_EQ(graphml.content_type, "application/xml");
  EXPECT_NE(graphml.body.find("<data key=\"surface\">2</data>"), std::string::npos);
  EXPECT_NE(graphml.body.find("<edge source=\"p6\" target=\"p7\">"), std::string::npos);
  EXPECT_NE(Get("/v1/maps/lab/graph", {{"format", "dot"}}).body.find("p6 -- p7"),
            std::string::npos);
  EXPECT_EQ(Get("/v1/maps/lab/graph", {{"format", "svg"}}).status, 400);
  // What needs poses isn't made up.
  for (const char* format : {"g2o", "geojson", "ply", "tum", "poses"}) {
    EXPECT_EQ(Get("/v1/maps/lab/graph", {{"format", format}}).status, 422) << format;
  }
}

// A list of maps is made while maps come and go.
TEST(MapLists, LeaveOutWhatIsGone) {
  struct OneIsGone : MapCatalog {
    OneIsGone() : MapCatalog({{"lab", MapIndex::Build(MadeMap(2))}}) {}
    std::vector<std::string> Names() const override { return {"gone", "lab"}; }
  };
  QueryGate gate(1, 0);
  OneIsGone maps;
  MapService service(maps, gate);
  Router router;
  service.AddTo(router);
  HttpRequest request;
  request.method = "GET";
  request.path = "/v1/maps";
  request.header = [](const std::string&) { return std::nullopt; };
  const HttpResponse response = router.Dispatch(request);
  ASSERT_EQ(response.status, 200) << response.body;
  const Json json = Json::parse(response.body);
  ASSERT_EQ(json["maps"].size(), 1u);
  EXPECT_EQ(json["maps"][0]["name"], "lab");
  EXPECT_TRUE(json["next"].is_null());
}

// The pictures of a map as a stranger may have made it.
class MapPicturesTest : public testing::Test {
 protected:
  void Start(const std::vector<uint8_t>& picture) {
    MapData map = MadeMap(2);
    map.keyframes[0].picture = picture;
    maps_ = std::make_unique<MapCatalog>(MapCatalog::Indices{{"lab", MapIndex::Build(map)}});
    service_ = std::make_unique<MapService>(*maps_, gate_);
    service_->AddTo(router_);
  }
  HttpResponse Get(const std::string& what, const std::string& width = "0") {
    HttpRequest request;
    request.method = "GET";
    request.path = "/v1/maps/lab/keyframes/1/" + what;
    request.query["width"] = width;
    request.header = [](const std::string&) { return std::nullopt; };
    return router_.Dispatch(request);
  }

  QueryGate gate_{1, 0};
  std::unique_ptr<MapCatalog> maps_;
  std::unique_ptr<MapService> service_;
  Router router_;
};

TEST_F(MapPicturesTest, SmallerPicturesWaitForTheirTurn) {
  Start(MadePicture());  // of 320 px
  {
    const QueryGate::Turn busy = gate_.Enter();
    EXPECT_EQ(Get("image", "100").status, 429);
    EXPECT_EQ(Get("thumbnail").status, 429);
    EXPECT_EQ(Get("image").status, 200) << "as it is stored";
    EXPECT_EQ(Get("image", "320").status, 200) << "no wider";
  }
  const HttpResponse small = Get("image", "100");
  ASSERT_EQ(small.status, 200) << small.body;
  const std::vector<uint8_t> bytes(small.body.begin(), small.body.end());
  EXPECT_EQ(ReadImageHeader(bytes).width, 100);
  EXPECT_EQ(ReadImageHeader(bytes).height, 75);
  EXPECT_EQ(gate_.load().running, 0);
}

TEST_F(MapPicturesTest, PicturesThatNoBuildStoresAreNotDecoded) {
  Start(EncodeJpeg(cv::Mat(6000, 8000, CV_8UC1, cv::Scalar(90))));
  const HttpResponse response = Get("image", "1");
  EXPECT_EQ(response.status, 422);
  EXPECT_NE(response.body.find("8000x6000 px"), std::string::npos) << response.body;
  EXPECT_EQ(Get("image").status, 200);
  EXPECT_EQ(gate_.load().running, 0) << "its turn was given back";
}

TEST(MapJson, RowsOfListsAreThoseOfSingleKeyframes) {
  const auto index = MapIndex::Build(MadeMap(7));
  const KeyframeRows rows("lab", *index);
  for (const Keyframe& keyframe : index->map().keyframes) {
    const Json row = rows.Row(keyframe);
    EXPECT_EQ(row, KeyframeJson("lab", *index, keyframe));
    EXPECT_EQ(row["planes"].size(), 7u);
  }
}

// Lists of maps show each, however large, whenever they are asked for.
TEST(MapJson, AServedMapKeepsItsSummary) {
  const ServedMap map("lab", MapIndex::Build(MadeMap(3)));
  EXPECT_EQ(map.summary(), MapJson("lab", map.index()));
  EXPECT_EQ(&map.summary(), &map.summary());
}

TEST(GraphFormats, NamesThatAreNoUtf8AreReplaced) {
  MapData map = MadeMap(1);
  map.keyframes[0].source = "k\xFC<\x01\xEF\xBF\xBF.jpg";
  const auto index = MapIndex::Build(std::move(map));
  const std::string replaced = "k\xEF\xBF\xBD";
  EXPECT_NE(FormatGraph(*index, "graphml").text.find(">" + replaced + "&lt;??.jpg</data>"),
            std::string::npos);
  EXPECT_NE(FormatGraph(*index, "dot").text.find(replaced + "<??.jpg"), std::string::npos);
}

TEST_F(MapServiceTest, WidthsAreChecked) {
  for (const char* width : {"-1", "x", "4097", "1.5", ""}) {
    EXPECT_EQ(Get("/v1/maps/lab/keyframes/1/image", {{"width", width}}).status, 400) << width;
  }
  EXPECT_EQ(Get("/v1/maps/lab/keyframes/2/thumbnail").status, 404);
}

TEST(ServiceOptions, OutOfRangeIsRefused) {
  ServiceOptions options;
  options.query_threads = -1;
  EXPECT_THROW(options.Check(), MapError);
  options.query_threads = 0;
  options.queue_length = -1;
  EXPECT_THROW(options.Check(), MapError);
}

}  // namespace
}  // namespace waystone
