// SPDX-License-Identifier: Apache-2.0
// The real server over real sockets.
#include <gtest/gtest.h>

#include <atomic>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <memory>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include "api/json.h"
#include "cli/child_process.h"
#include "schema/file/map_store.h"
#include "tests/e2e/calibrated_maps.h"
#include "tests/e2e/shared_map.h"
#include "tests/server/http/made_map.h"
#include "tests/server/http/made_picture.h"

// After Eigen, for which the macro _res of the resolver's header spells trouble.
#include <httplib.h>

namespace waystone {
namespace {

constexpr int kPatienceS = 30;

// A server of the shared map, and a client.
class Served {
 public:
  explicit Served(const std::vector<std::string>& flags = {},
                  const std::filesystem::path& maps = TheMap().map) {
    std::vector<std::string> arguments = {WAYSTONE_PROGRAM, "serve", maps, "--port", "0"};
    arguments.insert(arguments.end(), flags.begin(), flags.end());
    process_ = std::make_unique<ChildProcess>(arguments, true);
    first_line_ = process_->ReadLine();
    second_line_ = process_->ReadLine();
    const size_t at = first_line_.find("http://");
    EXPECT_NE(at, std::string::npos) << first_line_;
    url_ = first_line_.substr(at);
  }

  httplib::Client NewClient() const {
    httplib::Client client(url_);
    client.set_read_timeout(kPatienceS);
    return client;
  }
  const std::string& url() const { return url_; }
  const std::string& curl_line() const { return second_line_; }
  ChildProcess& process() { return *process_; }

 private:
  std::unique_ptr<ChildProcess> process_;
  std::string first_line_;
  std::string second_line_;
  std::string url_;
};

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
  EXPECT_EQ(KeysOf(answer["place"]),
            (Keys{"layer", "id", "image", "sequence", "time_s", "position", "heading"}));
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
  EXPECT_EQ(named.NewClient().Get("/v1/maps", {{"Host", "maps.example"}})->status, 200);
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
  EXPECT_TRUE(client_.Get("/v1/maps/room/keyframes/1/image")->body.starts_with("\xFF\xD8\xFF"));
}

TEST_F(HttpTest, MapsAreCachedByTheirVersion) {
  const auto first = client_.Get("/v1/maps/room/graph");
  const std::string etag = first->get_header_value("ETag");
  EXPECT_EQ(
      etag,
      "\"" + Json::parse(client_.Get("/v1/maps/room")->body)["version"].get<std::string>() + "\"");
  const auto again = client_.Get("/v1/maps/room/graph", {{"If-None-Match", etag}});
  ASSERT_TRUE(again);
  EXPECT_EQ(again->status, 304);
  EXPECT_EQ(again->body, "");
}

TEST_F(HttpTest, PagesJoinToTheWholeList) {
  const size_t all = Json::parse(client_.Get("/v1/maps/room")->body)["keyframes"].get<size_t>();
  size_t seen = 0;
  std::string path = "/v1/maps/room/keyframes?limit=2";
  while (true) {
    const Json page = Json::parse(client_.Get(path)->body);
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
  EXPECT_EQ(client_.Delete("/v1/maps/room")->get_header_value("Allow"), "GET, HEAD");
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
  layered.keyframes[0].jpeg = MadePicture();
  layered.orientation->nodes[1].jpeg = MadePicture();
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

TEST(HttpLimits, FullQueueTurnsQueriesAway) {
  const Served served({"--threads", "1", "--queue", "0"});
  const std::string photo = ReadFile(TheMap().inside);
  std::atomic<int> ok = 0;
  std::atomic<int> busy = 0;
  std::vector<std::thread> threads;
  for (int i = 0; i < 12; ++i) {
    threads.emplace_back([&] {
      httplib::Client client = served.NewClient();
      const auto result = client.Post("/v1/maps/room/localize", photo, "image/jpeg");
      if (result && result->status == 200) ++ok;
      if (result && result->status == 429 && result->has_header("Retry-After")) ++busy;
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(ok + busy, 12);
  EXPECT_GE(ok, 1);
  EXPECT_GE(busy, 1);
}

TEST(HttpLifetime, SignalsEndTheServerInOrder) {
  for (const int signal : {SIGINT, SIGTERM}) {
    Served served;
    ASSERT_TRUE(served.NewClient().Get("/healthz"));
    served.process().Send(signal);
    EXPECT_EQ(served.process().Wait(), 0);
    EXPECT_FALSE(served.NewClient().Get("/healthz"));
  }
}

bool HasMapOpen(pid_t pid) {
  std::error_code ignored;
  for (const auto& file :
       std::filesystem::directory_iterator("/proc/" + std::to_string(pid) + "/fd", ignored)) {
    if (std::filesystem::read_symlink(file, ignored).extension() == ".db") return true;
  }
  return false;
}

// The command of the service, for this program and map.
std::vector<std::string> ServiceCommand() {
  const std::string unit = ReadFile(WAYSTONE_SERVICE);
  const std::string key = "\nExecStart=";
  const size_t start = unit.find(key) + key.size();
  std::istringstream line(unit.substr(start, unit.find('\n', start) - start));
  std::vector<std::string> command;
  for (std::string word; line >> word;) {
    if (word == "/usr/bin/waystone") word = WAYSTONE_PROGRAM;
    if (word == "$WAYSTONE_SERVE") word = TheMap().map;
    command.push_back(word);
  }
  command.insert(command.end(), {"--port", "0"});
  return command;
}

// A reload right after the start, while the libraries are loaded and nothing of ours has run.
TEST(HttpLifetime, TheServiceIsReloadedWhileItStarts) {
  ChildProcess server(ServiceCommand(), true);
  const std::string name = "/proc/" + std::to_string(server.pid()) + "/comm";
  for (int i = 0; i < 1000 * kPatienceS && ReadFile(name) != "waystone\n"; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  server.Send(SIGHUP);
  EXPECT_NE(server.ReadLine().find("Serving 1 map"), std::string::npos);
  server.Send(SIGTERM);
  while (!server.ReadLine().empty()) {
  }
  EXPECT_EQ(server.Wait(), 0);
}

// A server that reads many maps is told to reload and to end before it is ready.
TEST(HttpLifetime, SignalsWaitUntilTheMapsAreRead) {
  namespace fs = std::filesystem;
  const fs::path folder = FreshFolder();
  for (int i = 0; i < 40; ++i) {
    fs::copy_file(TheMap().map, folder / ("room" + std::to_string(i) + ".db"));
  }
  for (const int signal : {SIGHUP, SIGTERM}) {
    ChildProcess server({WAYSTONE_PROGRAM, "serve", folder, "--port", "0"}, true);
    for (int i = 0; i < 1000 * kPatienceS && !HasMapOpen(server.pid()); ++i) {
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    ASSERT_TRUE(HasMapOpen(server.pid()));
    server.Send(signal);
    EXPECT_NE(server.ReadLine().find("Serving 40 maps"), std::string::npos);
    if (signal == SIGHUP) server.Send(SIGTERM);
    while (!server.ReadLine().empty()) {
    }
    EXPECT_EQ(server.Wait(), 0);
  }
}

// Answers about the map in a folder while its file is replaced again and again: none fails, and
// each comes from one whole version.
TEST(HttpLifetime, MapsAreExchangedWithoutLosingARequest) {
  namespace fs = std::filesystem;
  const fs::path folder = FreshFolder();
  fs::copy_file(TheMap().map, folder / "room.db");
  Served served({"--watch", "0.05"}, folder);
  const std::string photo = ReadFile(TheMap().inside);
  std::atomic<bool> stop = false;
  std::atomic<int> answers = 0;
  std::atomic<int> failures = 0;
  std::vector<std::thread> clients;
  for (int i = 0; i < 2; ++i) {
    clients.emplace_back([&] {
      httplib::Client client = served.NewClient();
      while (!stop) {
        const auto result = client.Post("/v1/maps/room/localize", photo, "image/jpeg");
        const bool good =
            result && result->status == 200 && Json::parse(result->body)["verdict"] == "localized";
        ++(good ? answers : failures);
      }
    });
  }
  const auto until = [](const auto& holds) {
    for (int i = 0; i < 100 * kPatienceS && !holds(); ++i) {
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
  };
  const auto metrics = [&] { return served.NewClient().Get("/metrics")->body; };
  const auto swaps = [&] {
    const std::string text = metrics();
    const std::string name = "waystone_reloads_total{result=\"swapped\"} ";
    const size_t at = text.find(name);
    return at == std::string::npos ? 0 : std::stoi(text.substr(at + name.size()));
  };
  const auto answered = [&] {
    until([&, before = answers + failures] { return answers + failures >= before + 3; });
  };
  // Until a map was swapped and both clients were answered after it.
  auto pass = [&, seen = 0]() mutable {
    until([&] { return swaps() > seen; });
    seen = swaps();
    answered();
  };
  for (int i = 0; i < 3; ++i) {
    fs::copy_file(TheMap().map, folder / "new");
    fs::rename(folder / "new", folder / "room.db");
    pass();
    served.process().Send(SIGHUP);
    pass();
  }
  // Half a map is refused, and the one before is served on.
  WriteFile(folder / "room.db", ReadFile(TheMap().map).substr(0, 10'000));
  const std::string refused = "waystone_reloads_total{result=\"refused\"}";
  until([&] { return metrics().find(refused) != std::string::npos; });
  EXPECT_NE(metrics().find(refused), std::string::npos);
  answered();
  stop = true;
  for (std::thread& client : clients) client.join();
  EXPECT_EQ(failures, 0);
  EXPECT_GE(answers, 3 * 7);
  EXPECT_GE(swaps(), 6);
  // A new file is served, and one that goes isn't.
  fs::copy_file(TheMap().map, folder / "hall.db");
  fs::remove(folder / "room.db");
  until([&] { return served.NewClient().Get("/v1/maps/room")->status == 404; });
  EXPECT_EQ(served.NewClient().Get("/v1/maps/hall")->status, 200);
  EXPECT_EQ(served.NewClient().Get("/v1/maps/room")->status, 404);
  fs::remove_all(folder);
}

TEST(HttpLifetime, QueriesAreReplayed) {
  const std::filesystem::path folder = FreshFolder();
  {
    const Served served({"--query-log", (folder / "log").string()});
    httplib::Client client = served.NewClient();
    client.Post("/v1/maps/room/localize?top_k=2", ReadFile(TheMap().inside), "image/jpeg");
    client.Post("/v1/localize", ReadFile(TheMap().elsewhere), "image/jpeg");
  }
  const RunResult same = RunWaystone({"replay", folder / "log", TheMap().map});
  EXPECT_EQ(same.code, 0) << same.err;
  EXPECT_EQ(same.out, "0 of 2 answers changed\n");
  std::string lines = ReadFile(folder / "log" / "queries.jsonl");
  const std::string said = R"("verdict":"not_in_map")";
  lines.replace(lines.find(said), said.size(), R"("verdict":"localized")");
  WriteFile(folder / "log" / "queries.jsonl", lines);
  const Json changed =
      Json::parse(RunWaystone({"replay", folder / "log", TheMap().map, "--json"}).out);
  EXPECT_EQ(changed["changed"], 1);
  EXPECT_EQ(changed["changes"][0]["after"]["verdict"], "not_in_map");
  EXPECT_EQ(RunWaystone({"replay", folder, TheMap().map}).code, 3);
  std::filesystem::remove_all(folder);
}

TEST(HttpLifetime, OtherMachinesNeedATokenAndItIsAsked) {
  const std::filesystem::path folder = FreshFolder();
  const RunResult open = RunWaystone({"serve", TheMap().map, "--host", "0.0.0.0", "--port", "0"});
  EXPECT_EQ(open.code, 2);
  EXPECT_NE(open.err.find("--token-file"), std::string::npos) << open.err;
  WriteFile(folder / "tokens", "0123456789abcdef\n");
  const Served served({"--host", "0.0.0.0", "--token-file", (folder / "tokens").string()});
  EXPECT_EQ(served.NewClient().Get("/v1/maps")->status, 401);
  EXPECT_EQ(
      served.NewClient().Get("/v1/maps", {{"Authorization", "Bearer 0123456789abcdef"}})->status,
      200);
  EXPECT_NE(served.curl_line().find("Authorization: Bearer $TOKEN"), std::string::npos);
  std::filesystem::remove_all(folder);
}

TEST(HttpLifetime, TakenPortIsSaid) {
  const Served served;
  const std::string port = served.url().substr(served.url().rfind(':') + 1);
  const RunResult second = RunWaystone({"serve", TheMap().map, "--port", port});
  EXPECT_EQ(second.code, 2);
  EXPECT_NE(second.err.find("--port"), std::string::npos) << second.err;
}

}  // namespace
}  // namespace waystone
