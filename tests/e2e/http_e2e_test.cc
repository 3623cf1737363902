// SPDX-License-Identifier: Apache-2.0
// The real server over real sockets.
#include <gtest/gtest.h>

#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "api/json.h"
#include "core/base/version.h"
#include "schema/file/map_store.h"
#include "tests/e2e/calibrated_maps.h"
#include "tests/e2e/served_map.h"
#include "tests/e2e/shared_map.h"
#include "tests/server/service/made_map.h"
#include "tests/server/service/made_picture.h"

namespace waystone {
namespace {

class HttpTest : public testing::Test {
 protected:
  static void SetUpTestSuite() { served_ = std::make_unique<Served>(); }
  static void TearDownTestSuite() { served_.reset(); }

  Json Localize(const std::string& bytes) {
    const auto result = client_.Post("/v1/maps/room/localize?name=q.jpg", bytes, "image/jpeg");
    EXPECT_TRUE(result);
    if (!result) return {};
    EXPECT_EQ(result->status, 200) << result->body;
    return Json::parse(result->body);
  }

  static std::vector<std::string> KeysOf(const Json& json) {
    std::vector<std::string> keys;
    for (const auto& [key, value] : json.items()) keys.push_back(key);
    return keys;
  }

  static void ExpectProblem(const httplib::Result& result, int status, const std::string& code) {
    ASSERT_TRUE(result);
    EXPECT_EQ(result->status, status) << result->body;
    EXPECT_EQ(result->get_header_value("Content-Type"), "application/problem+json");
    const Json json = Json::parse(result->body);
    EXPECT_EQ(KeysOf(json),
              (std::vector<std::string>{"type", "title", "status", "detail", "code"}));
    EXPECT_EQ(json["status"], status);
    EXPECT_EQ(json["code"], code);
  }

  static inline std::unique_ptr<Served> served_;
  httplib::Client client_ = served_->NewClient();
};

using Keys = std::vector<std::string>;

TEST_F(HttpTest, AnswerHasTheDocumentedFields) {
  const Json answer = Localize(ReadFile(TheMap().inside));
  ASSERT_EQ(answer["verdict"], "localized") << answer.dump();
  EXPECT_EQ(KeysOf(answer),
            (Keys{"verdict", "probability", "image", "map", "map_version", "place", "keyframe",
                  "heading", "planes", "epipolar", "runner_up", "decided_by", "timing_ms"}));
  EXPECT_EQ(answer["image"], "q.jpg");
  EXPECT_EQ(answer["map"], "room");
  EXPECT_EQ(KeysOf(answer["place"]), (Keys{"layer", "id", "name", "image", "sequence", "time_s",
                                           "position", "heading", "plan"}));
  EXPECT_EQ(answer["place"]["id"], answer["keyframe"]["id"]);
  EXPECT_EQ(KeysOf(answer["keyframe"]), (Keys{"id", "sequence", "source", "time_s"}));
  EXPECT_EQ(KeysOf(answer["timing_ms"]),
            (Keys{"decode", "extract", "shortlist", "verify", "total"}));
  ASSERT_FALSE(answer["planes"].empty());
  EXPECT_EQ(KeysOf(answer["planes"][0]),
            (Keys{"id", "inliers", "reference", "reference_from_query", "outline", "expect_next"}));
  EXPECT_EQ(answer["planes"][0]["reference_from_query"].size(), 3u);
  EXPECT_GE(answer["planes"][0]["outline"].size(), 3u);
}

TEST_F(HttpTest, OtherBuildingIsNotInTheMap) {
  const Json answer = Localize(ReadFile(TheMap().elsewhere));
  EXPECT_EQ(answer["verdict"], "not_in_map");
  EXPECT_TRUE(answer["place"].is_null());
  EXPECT_TRUE(answer["keyframe"].is_null());
  EXPECT_NE(answer["message"], "");
}

TEST_F(HttpTest, PagesOfOthersReachNothing) {
  const std::string port = served_->url().substr(served_->url().rfind(':') + 1);
  const auto get = [&](const std::string& host) {
    return client_.Get("/v1/maps", {{"Host", host}});
  };
  ExpectProblem(get("evil.example:" + port), 421, "misdirected");
  ExpectProblem(get("localhost:1"), 421, "misdirected");
  EXPECT_EQ(get("localhost:" + port)->status, 200);
  const auto post = [&](const std::string& name, const std::string& value) {
    return client_.Post("/v1/maps/room/localize", {{name, value}}, ReadFile(TheMap().inside),
                        "image/jpeg");
  };
  ExpectProblem(post("Origin", "http://evil.example"), 403, "foreign_page");
  ExpectProblem(post("Sec-Fetch-Site", "cross-site"), 403, "foreign_page");
  EXPECT_EQ(post("Origin", "http://localhost:" + port)->status, 200);
  const Served named({"--public-name", "maps.example"});
  EXPECT_EQ(Checked(named.NewClient().Get("/v1/maps", {{"Host", "maps.example"}}))->status, 200);
}

TEST_F(HttpTest, BadImagesAreAnswersAndCheap) {
  const std::string good = ReadFile(TheMap().inside);
  const std::map<std::string, std::string> bad = {
      {"empty", ""},
      {"text", "this is a text file called .jpg"},
      {"cut", good.substr(0, good.size() / 2)},
      {"header", good.substr(0, 20)},
      {"bomb", WithJpegSize(good, 30'000, 30'000)},
      {"flat", WithJpegSize(good, 640, 0)},
  };
  for (const auto& [name, bytes] : bad) {
    const auto start = std::chrono::steady_clock::now();
    const Json answer = Localize(bytes);
    EXPECT_EQ(answer["verdict"], "bad_image") << name;
    EXPECT_NE(answer["message"], "") << name;
    EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(2)) << name;
  }
}

TEST_F(HttpTest, EveryInspectionRouteAnswers) {
  for (const char* path :
       {"/", "/healthz", "/v1/maps", "/v1/maps/room", "/v1/maps/room/planes",
        "/v1/maps/room/planes/1", "/v1/maps/room/graph", "/v1/maps/room/overview",
        "/v1/maps/room/audit", "/plain", "/page/main.js", "/v1/maps/room/keyframes",
        "/v1/maps/room/keyframes/1", "/v1/maps/room/keyframes/1/image"}) {
    const httplib::Headers plain = {{"Accept-Encoding", "identity"}};  // a length to compare
    const auto get = client_.Get(path, plain);
    ASSERT_TRUE(get) << path;
    EXPECT_EQ(get->status, 200) << path;
    const auto head = client_.Head(path, plain);
    ASSERT_TRUE(head) << path;
    EXPECT_EQ(head->status, 200) << path;
    EXPECT_EQ(head->body, "") << path;
    EXPECT_EQ(head->get_header_value("Content-Length"), std::to_string(get->body.size())) << path;
  }
  const auto image = Checked(client_.Get("/v1/maps/room/keyframes/1/image"));
  EXPECT_TRUE(image->body.starts_with("RIFF"));
  EXPECT_EQ(image->get_header_value("Content-Type"), "image/webp");
  const auto smaller = Checked(client_.Get("/v1/maps/room/keyframes/1/image?width=16"));
  EXPECT_TRUE(smaller->body.starts_with("\xFF\xD8\xFF"));
  EXPECT_EQ(smaller->get_header_value("Content-Type"), "image/jpeg");
}

TEST_F(HttpTest, MapsAreCachedByTheirVersion) {
  const auto first = client_.Get("/v1/maps/room/graph");
  const std::string etag = first->get_header_value("ETag");
  const std::string version = Json::parse(Checked(client_.Get("/v1/maps/room"))->body)["version"];
  EXPECT_EQ(etag, "\"" + version + "-" + kVersion + "\"");
  const auto again = client_.Get("/v1/maps/room/graph", {{"If-None-Match", etag}});
  ASSERT_TRUE(again);
  EXPECT_EQ(again->status, 304);
  EXPECT_EQ(again->body, "");
}

TEST_F(HttpTest, PagesJoinToTheWholeList) {
  const size_t all =
      Json::parse(Checked(client_.Get("/v1/maps/room"))->body)["keyframes"].get<size_t>();
  size_t seen = 0;
  std::string path = "/v1/maps/room/keyframes?limit=2";
  while (true) {
    const Json page = Json::parse(Checked(client_.Get(path))->body);
    seen += page["keyframes"].size();
    if (page["next"].is_null() || seen > all) break;
    path = "/v1/maps/room/keyframes?limit=2&cursor=" + page["next"].get<std::string>();
  }
  EXPECT_EQ(seen, all);
}

TEST_F(HttpTest, ErrorsAreProblems) {
  ExpectProblem(client_.Get("/nowhere"), 404, "not_found");
  ExpectProblem(client_.Get("/v1/maps/attic"), 404, "not_found");
  ExpectProblem(client_.Get("/v1/maps/room/planes/999999"), 404, "not_found");
  ExpectProblem(client_.Get("/v1/maps/room/keyframes/one"), 404, "not_found");
  ExpectProblem(client_.Post("/v1/maps/attic/localize", "x", "image/jpeg"), 404, "not_found");
  ExpectProblem(client_.Get("/v1/maps/room/localize"), 405, "method_not_allowed");
  ExpectProblem(client_.Put("/v1/maps/room", "x", "text/plain"), 400, "bad_request");
  ExpectProblem(client_.Delete("/v1/maps/room"), 405, "method_not_allowed");
  ExpectProblem(client_.Get("/v1/maps?limit=none"), 400, "bad_request");
  ExpectProblem(client_.Get("/v1/maps?cursor=none"), 400, "bad_request");
  ExpectProblem(client_.Post("/v1/maps/room/localize", "x", "text/plain"), 415,
                "unsupported_media_type");
  ExpectProblem(
      client_.Post("/v1/maps/room/localize", {{"Content-Encoding", "gzip"}}, "x", "image/jpeg"),
      415, "unsupported_media_type");
  ExpectProblem(client_.Post("/v1/maps/room/localize", std::string(20'000'001, 'x'), "image/jpeg"),
                413, "payload_too_large");
  EXPECT_EQ(Checked(client_.Delete("/v1/maps/room"))->get_header_value("Allow"), "GET, HEAD");
}

TEST_F(HttpTest, ConnectionsAreKept) {
  httplib::Client client = served_->NewClient();
  client.set_keep_alive(true);
  for (int i = 0; i < 30; ++i) {
    const auto result = client.Get("/healthz");
    ASSERT_TRUE(result) << i;
    EXPECT_EQ(result->status, 200);
  }
}

TEST_F(HttpTest, ManyAtOnceGetTheSameAnswer) {
  const std::string photo = ReadFile(TheMap().inside);
  std::vector<std::string> answers(8);
  std::vector<std::thread> threads;
  for (std::string& answer : answers) {
    threads.emplace_back([&answer, &photo] {
      httplib::Client client = served_->NewClient();
      const auto result = client.Post("/v1/maps/room/localize", photo, "image/jpeg");
      if (!result) return;
      Json json = Json::parse(result->body);
      json.erase("timing_ms");
      answer = json.dump();
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_NE(answers[0].find("localized"), std::string::npos) << answers[0];
  for (const std::string& answer : answers) EXPECT_EQ(answer, answers[0]);
}

TEST_F(HttpTest, SameAnswerAsWithoutAServer) {
  Json served = Localize(ReadFile(TheMap().inside));
  const RunResult run = RunWaystone({"localize", TheMap().map, TheMap().inside, "--json"});
  Json local = Json::parse(run.out);
  for (const char* differs : {"timing_ms", "image"}) {
    served.erase(differs);
    local.erase(differs);
  }
  EXPECT_EQ(served.dump(), local.dump());
}

// Debian's Python, for which packages.txt installs what is imported. Every route and body and some
// hundred generated requests against clients/openapi.yaml.
TEST_F(HttpTest, KeepsItsContract) {
  const std::filesystem::path folder = FreshFolder();
  MapData layered = MadeLayeredMap(3);
  layered.sequences[0].camera = MadeCamera();
  layered.keyframes[0].picture = MadePicture();
  layered.orientation->nodes[1].picture = MadePicture();
  AddMadePoses(layered);
  AddMadeFloorPlan(layered);
  layered.edges.clear();  // whose homologies are made up: a file is checked
  WriteMap(layered, folder / "layered.db", {});
  const Served served({(folder / "layered.db").string(), TheCorner().map.string()});
  const std::string root = WAYSTONE_SOURCE_DIR;
  ChildProcess contract({"/usr/bin/python3", root + "/tests/e2e/contract.py", served.url(),
                         root + "/clients/openapi.yaml", "room", "layered", "walls",
                         TheMap().inside, TheMap().elsewhere},
                        false);
  EXPECT_EQ(contract.Wait(), 0);
  std::filesystem::remove_all(folder);
}

TEST_F(HttpTest, CurlLineIsReadyToUse) {
  EXPECT_NE(served_->curl_line().find("curl --data-binary @photo.jpg"), std::string::npos);
  EXPECT_NE(served_->curl_line().find(served_->url() + "/v1/maps/room/localize"),
            std::string::npos);
}

}  // namespace
}  // namespace waystone
