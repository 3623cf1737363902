// SPDX-License-Identifier: Apache-2.0
// What stands around the handlers: who may ask, names of requests, health, metrics, reload, logs.
#include "server/service/application.h"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "api/logged_query.h"
#include "core/base/error.h"
#include "core/base/version.h"
#include "server/http/problem.h"
#include "server/service/map_catalog.h"
#include "tests/api/read_queries.h"
#include "tests/server/http/no_threads.h"
#include "tests/server/service/made_map.h"

namespace waystone {
namespace {

namespace fs = std::filesystem;
using Headers = std::map<std::string, std::string>;

class ApplicationTest : public testing::Test {
 protected:
  ApplicationTest() {
    std::string name = (fs::temp_directory_path() / "waystone-app-XXXXXX").string();
    EXPECT_NE(mkdtemp(name.data()), nullptr);
    folder_ = name;
  }
  ~ApplicationTest() override { fs::remove_all(folder_); }

  void Start(const ServiceOptions& options = {}) {
    catalog_ =
        std::make_shared<MapCatalog>(MapCatalog::Indices{{"lab", MapIndex::Build(MadeMap(3))}});
    app_ = std::make_unique<Application>(
        catalog_, options,
        Application::Sinks{[this](const std::string& line) { access_.push_back(line); },
                           [this](const std::string& line) { errors_.push_back(line); }});
  }

  HttpResponse Ask(const std::string& method, const std::string& path, const Headers& headers = {},
                   const std::string& body = "") {
    HttpRequest request;
    request.method = method;
    request.path = path;
    request.header = [&](const std::string& name) -> std::optional<std::string> {
      const auto it = headers.find(name);
      return it == headers.end() ? std::nullopt : std::optional(it->second);
    };
    request.read_body = [&] { return body; };
    return app_->Answer(request);
  }

  Tokens TokensOf(const std::string& text) const {
    std::ofstream(folder_ / "tokens") << text;
    return Tokens::FromFile(folder_ / "tokens");
  }

  static std::string HeaderOf(const HttpResponse& response, const std::string& name) {
    for (const auto& [key, value] : response.headers) {
      if (key == name) return value;
    }
    return "";
  }

  fs::path folder_;
  std::vector<std::string> access_;
  std::vector<std::string> errors_;
  std::shared_ptr<MapCatalog> catalog_;
  std::unique_ptr<Application> app_;
};

const char* const kToken = "0123456789abcdef";

TEST_F(ApplicationTest, OnlyTokensLetIn) {
  ServiceOptions options;
  options.tokens = TokensOf("# robots\n\n0123456789abcdef\nfedcba9876543210-second\n");
  Start(options);
  const auto status = [&](const std::string& authorization) {
    return Ask("GET", "/v1/maps", {{"Authorization", authorization}}).status;
  };
  EXPECT_EQ(status(std::string("Bearer ") + kToken), 200);
  EXPECT_EQ(status(std::string("bearer ") + kToken), 200);
  EXPECT_EQ(status("Bearer fedcba9876543210-second"), 200);
  for (const std::string wrong :
       {"", "Bearer", "Bearer ", "Bearer 0123456789abcde", "Bearer 0123456789abcdeff",
        "Basic 0123456789abcdef", "0123456789abcdef", "Bearer # robots"}) {
    EXPECT_EQ(status(wrong), 401) << wrong;
  }
  EXPECT_EQ(HeaderOf(Ask("GET", "/v1/maps"), "WWW-Authenticate"), "Bearer");
  EXPECT_EQ(Ask("POST", "/v1/localize", {}, "x").status, 401);
  EXPECT_EQ(Ask("GET", "/metrics").status, 401);
  EXPECT_EQ(Ask("GET", "/healthz").status, 200);
  EXPECT_EQ(Ask("GET", "/readyz").status, 200);
  // The page asks its reader for a token, and shows nothing of a map without.
  EXPECT_EQ(Ask("GET", "/").status, 200);
  EXPECT_EQ(Ask("GET", "/page/main.js").status, 200);
  EXPECT_EQ(Ask("GET", "/plain").status, 401);
  EXPECT_EQ(Ask("GET", "/page").status, 401);
  EXPECT_EQ(Ask("GET", "/page%2Fmain.js").status, 401);
}

TEST_F(ApplicationTest, TokenFilesAreChecked) {
  for (const char* text : {"", "# none\n", "short\n", "0123456789 abcdef\n"}) {
    EXPECT_THROW(TokensOf(text), MapError) << text;
  }
  EXPECT_THROW(Tokens::FromFile(folder_ / "nowhere"), MapError);
  EXPECT_THROW(Tokens::FromFile("/dev/zero"), MapError);
}

TEST_F(ApplicationTest, RequestsHaveNamesAndHeaders) {
  Start();
  EXPECT_EQ(HeaderOf(Ask("GET", "/healthz", {{"X-Request-Id", "robot-7.a"}}), "X-Request-Id"),
            "robot-7.a");
  const std::string made =
      HeaderOf(Ask("GET", "/healthz", {{"X-Request-Id", "a\"b c"}}), "X-Request-Id");
  EXPECT_NE(made, "a\"b c");
  EXPECT_NE(made, HeaderOf(Ask("GET", "/healthz"), "X-Request-Id"));
  const HttpResponse response = Ask("GET", "/nowhere");
  EXPECT_EQ(HeaderOf(response, "Content-Security-Policy"),
            "default-src 'none'; frame-ancestors 'none'");
  EXPECT_EQ(HeaderOf(response, "Access-Control-Allow-Origin"), "");
}

TEST_F(ApplicationTest, LogsALineOfJsonARequest) {
  Start();
  Ask("GET", "/v1/maps/lab/planes/2", {{"X-Request-Id", "seven"}});
  Ask("GET", "/v1/maps/a\"\n\xff/graph");
  ASSERT_EQ(access_.size(), 2u);
  const Json line = Json::parse(access_[0]);
  EXPECT_EQ(line["id"], "seven");
  EXPECT_EQ(line["route"], "/v1/maps/{map}/planes/{id}");
  EXPECT_EQ(line["status"], 200);
  EXPECT_EQ(access_[1].find('\n'), std::string::npos);
  EXPECT_EQ(Json::parse(access_[1])["status"], 404);
}

// Whatever couldn't be read of it.
TEST_F(ApplicationTest, RefusedRequestsAreLoggedLikeOthers) {
  Start();
  HttpRequest request;
  request.refusal.emplace(ErrorCode::kBadRequest, "malformed");
  request.header = [](const std::string&) { return std::nullopt; };
  const HttpResponse response = app_->Answer(request);
  EXPECT_EQ(response.status, 400);
  EXPECT_NE(HeaderOf(response, "X-Request-Id"), "");
  ASSERT_EQ(access_.size(), 1u);
  EXPECT_EQ(Json::parse(access_[0])["status"], 400);
}

TEST_F(ApplicationTest, ControlCharactersOfNamesAreShown) {
  Start();
  const HttpResponse response = Ask("GET", std::string("/v1/maps/c5\0x", 13));
  EXPECT_EQ(response.status, 404);
  EXPECT_EQ(Json::parse(response.body)["detail"],
            "no map 'c5\\u0000x'; GET /v1/maps lists the maps");
}

TEST_F(ApplicationTest, CountsWhatItDoes) {
  Start();
  Ask("GET", "/v1/maps/lab/planes/2");
  Ask("GET", "/v1/maps/lab/planes/3");
  Ask("BREW", "/pot");
  Ask("POST", "/v1/maps/lab/localize", {}, "no image");
  const HttpResponse metrics = Ask("GET", "/metrics");
  EXPECT_EQ(metrics.content_type, "text/plain; version=0.0.4");
  for (const char* line :
       {R"(waystone_localized_total{verdict="bad_image"} 1)", "waystone_maps 1",
        R"(waystone_localized_total{verdict="localized"} 0)",
        R"(waystone_reloads_total{result="refused"} 0)", "waystone_queries_waiting 0",
        R"(method="GET",route="/v1/maps/{map}/planes/{id}",status="200"} 2)",
        R"(method="other",route="none",status="501"} 1)", "process_resident_memory_bytes"}) {
    EXPECT_NE(metrics.body.find(line), std::string::npos) << line << "\n" << metrics.body;
  }
}

TEST_F(ApplicationTest, ReadyUntilItEnds) {
  Start();
  EXPECT_EQ(Ask("GET", "/readyz").status, 200);
  app_->BeginStop();
  EXPECT_EQ(Ask("GET", "/readyz").status, 503);
  EXPECT_EQ(Ask("GET", "/v1/maps").status, 200);
}

TEST_F(ApplicationTest, QueriesAreTurnedAwayAtTheEnd) {
  Start();
  EXPECT_EQ(Ask("POST", "/v1/localize", {}, "x").status, 200);
  app_->EndQueue();
  const HttpResponse response = Ask("POST", "/v1/localize", {}, "x");
  EXPECT_EQ(response.status, 503);
  EXPECT_EQ(Json::parse(response.body)["code"], "not_ready");
  EXPECT_EQ(Ask("GET", "/v1/maps").status, 200);
}

TEST_F(ApplicationTest, VersionAndContract) {
  Start();
  EXPECT_TRUE(Json::parse(Ask("GET", "/version").body).contains("program"));
  const Json contract = Json::parse(Ask("GET", "/openapi.json").body);
  EXPECT_EQ(contract["openapi"], "3.1.0");
  const std::string page = Ask("GET", "/api").body;
  for (const auto& [path, operations] : contract["paths"].items()) {
    EXPECT_NE(page.find(" " + path + "</code>"), std::string::npos) << path;
  }
}

// Parameters are references, and some are the whole path's.
TEST_F(ApplicationTest, TheContractsPageHasAllParameters) {
  Start();
  const std::string page = Ask("GET", "/api").body;
  const auto section = [&](const std::string& operation) {
    const size_t begin = page.find("<h2><code>" + operation + "</code>");
    EXPECT_NE(begin, std::string::npos) << operation;
    return page.substr(begin, page.find("<h2>", begin + 1) - begin);
  };
  const std::string features = section("GET /v1/maps/{map}/planes/{id}/features");
  for (const char* name : {"map", "id", "limit", "cursor", "If-None-Match"}) {
    EXPECT_NE(features.find("<code>" + std::string(name) + "</code> "), std::string::npos)
        << name << "\n"
        << features;
  }
  EXPECT_NE(section("GET /v1/maps").find("Maximum rows per page."), std::string::npos);
  EXPECT_NE(section("GET /page/{file}").find("<code>file</code>"), std::string::npos);
  EXPECT_EQ(section("GET /healthz").find("<ul>"), std::string::npos);
}

// The fields of schemas and parameters by which values are bounded.
void ExpectNumbers(const Json& node, const std::string& path) {
  static const std::set<std::string> kBounds = {"minimum",   "maximum",  "minLength",
                                                "maxLength", "minItems", "maxItems"};
  for (const auto& [key, value] : node.items()) {
    if (!value.is_structured()) {
      EXPECT_TRUE(!kBounds.contains(key) || value.is_number()) << path << '/' << key;
    } else {
      ExpectNumbers(value, path + "/" + key);
    }
  }
}

TEST_F(ApplicationTest, BoundsOfTheContractAreNumbers) {
  Start();
  ExpectNumbers(Json::parse(Ask("GET", "/openapi.json").body), "");
}

TEST_F(ApplicationTest, MapsAreExchangedUnderWay) {
  Start();
  const std::shared_ptr<const ServedMap> under_way = catalog_->Find("lab");
  MapData other = MadeMap(5);
  other.info.version = "sha256:other";
  catalog_->Put("lab", MapIndex::Build(std::move(other)));
  EXPECT_EQ(under_way->index().map().planes.size(), 3u);
  EXPECT_EQ(Json::parse(Ask("GET", "/v1/maps/lab").body)["planes"], 5);
  EXPECT_EQ(HeaderOf(Ask("GET", "/v1/maps/lab"), "ETag"),
            std::string("\"sha256:other-") + kVersion + "\"");
  catalog_->Remove("lab");
  EXPECT_EQ(Ask("GET", "/v1/maps/lab").status, 404);
  EXPECT_EQ(Ask("GET", "/readyz").status, 503);
  EXPECT_EQ(Ask("POST", "/v1/localize", {}, "x").status, 503);
  const std::string hinted = R"({"images": [{"data": "eA=="}], "hints": {}})";
  const HttpResponse none =
      Ask("POST", "/v1/localize", {{"Content-Type", "application/json"}}, hinted);
  EXPECT_EQ(Json::parse(none.body)["code"], "not_ready") << none.body;
}

TEST_F(ApplicationTest, QueriesAreLoggedAndReadAgain) {
  ServiceOptions options;
  options.query_log = folder_ / "log";
  Start(options);
  Ask("POST", "/v1/maps/lab/localize", {{"X-Request-Id", "../../x"}}, "one");
  Ask("POST", "/v1/maps/lab/localize", {}, "one");
  Ask("POST", "/v1/localize", {}, "two");
  const std::vector<LoggedQuery> queries = ReadQueries(options.query_log);
  ASSERT_EQ(queries.size(), 3u);
  EXPECT_EQ(queries[0].map, "lab");
  EXPECT_EQ(queries[0].request.images[0].bytes, "one");
  EXPECT_EQ(queries[2].map, nullptr);
  EXPECT_EQ(queries[2].answer["verdict"], "bad_image");
  // Two images, the lines, and nothing else anywhere.
  EXPECT_EQ(std::distance(fs::directory_iterator(options.query_log), {}), 3);
}

// A query with a deadline computes in a thread of its own.
TEST_F(ApplicationTest, AThreadThatCannotBeStartedIsSaid) {
  Start();
  const auto ask = [this] {
    return Ask("POST", "/v1/maps/lab/localize", {{"Content-Type", "application/json"}},
               R"({"images": [{"data": "eA=="}], "deadline_ms": 20000})");
  };
  EXPECT_EQ(ask().status, 200);
  {
    const NoThreads none;
    const HttpResponse response = ask();
    EXPECT_EQ(response.status, 503);
    EXPECT_EQ(HeaderOf(response, "Retry-After"), "1");
    const Json problem = Json::parse(response.body);
    EXPECT_EQ(problem["code"], "out_of_memory");
    EXPECT_TRUE(problem["detail"].get<std::string>().starts_with("cannot start a thread ("))
        << problem["detail"];
  }
  EXPECT_EQ(ask().status, 200) << "its turn was given back";
}

// The queries of a server run in parallel, each in one thread.
TEST_F(ApplicationTest, ImagesAreComputedInOneThread) {
  cv::setNumThreads(2);
  Start();
  EXPECT_EQ(cv::getNumThreads(), 1);
}

// Waiting for another's audit would take a thread, and many who wait all of them.
TEST_F(ApplicationTest, WhoAsksWhileAMapIsAuditedIsToldToTryAgain) {
  const ServedMap map("lab", MapIndex::Build(MadeMap(3)));
  QueryGate gate(1, 10);
  std::thread first;
  {
    const QueryGate::Turn busy = gate.Enter();
    first = std::thread([&] { map.Audit(gate); });
    while (gate.load().waiting == 0) std::this_thread::yield();
    EXPECT_THROW(map.Audit(gate), BusyError);
    EXPECT_EQ(gate.load().waiting, 1);
  }
  first.join();
  EXPECT_EQ(&map.Audit(gate), &map.Audit(gate)) << "made once";
  EXPECT_EQ(gate.load().running, 0);
}

// A photo of 48 megapixels takes half a second to decode, and nothing interrupts that.
TEST_F(ApplicationTest, DeadlinesAreKeptWhileAnImageIsDecoded) {
  using Clock = std::chrono::steady_clock;
  std::vector<uint8_t> jpeg;
  cv::Mat photo(6000, 8000, CV_8UC3);
  cv::randu(photo, 0, 60);
  cv::imencode(".jpg", photo, jpeg, {cv::IMWRITE_JPEG_QUALITY, 60});
  ServiceOptions options;
  options.query_threads = 1;
  Start(options);
  std::string body(jpeg.begin(), jpeg.end());
  HttpRequest request;
  request.method = "POST";
  request.path = "/v1/maps/lab/localize";
  request.header = [](const std::string&) { return std::nullopt; };
  request.read_body = [&] { return body; };
  Json answer;
  const auto ask_ms = [&] {
    const Clock::time_point start = request.received = Clock::now();
    answer = Json::parse(app_->Answer(request).body);
    return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
  };
  const double whole_ms = ask_ms();  // most of it decodes
  for (const int deadline_ms : {1, 30}) {
    request.query = {{"deadline_ms", std::to_string(deadline_ms)}};
    EXPECT_LT(ask_ms(), deadline_ms + std::max(100.0 * WAYSTONE_SLOWDOWN, whole_ms / 8));
    EXPECT_EQ(answer["verdict"], "undecided") << answer.dump();
    EXPECT_EQ(answer["stage"], "queue");
  }
}

// Photos of people's rooms, in a folder that everybody may read, of a program without a umask.
TEST_F(ApplicationTest, QueryLogIsPrivate) {
  const auto rights = [](const fs::path& path) { return fs::status(path).permissions(); };
  const fs::perms file = fs::perms::owner_read | fs::perms::owner_write;
  ServiceOptions options;
  for (const mode_t mask : {0, 0777}) {
    const fs::path open = folder_ / std::to_string(mask);
    fs::create_directory(open);
    std::ofstream(open / kQueryLogLines) << "";  // of an earlier version
    fs::permissions(open, fs::perms::all);
    fs::permissions(open / kQueryLogLines, fs::perms::all);
    for (const fs::path& log : {open, open / "new"}) {
      const mode_t before = umask(mask);
      options.query_log = log;
      Start(options);
      Ask("POST", "/v1/localize", {}, "x");
      umask(before);
      EXPECT_EQ(ReadQueries(log).size(), 1U);
      for (const auto& entry : fs::directory_iterator(log)) {
        if (!entry.is_regular_file()) continue;
        EXPECT_EQ(rights(entry), file) << entry.path();
      }
    }
    EXPECT_EQ(rights(open / "new"), fs::perms::owner_all);
  }
}

// Who may write to the folder leads the log to no other file.
TEST_F(ApplicationTest, QueryLogFollowsNoLinks) {
  std::ofstream(folder_ / "precious") << "mine";
  fs::create_directory(folder_ / "log");
  fs::create_symlink(folder_ / "precious", folder_ / "log" / kQueryLogLines);
  ServiceOptions options;
  options.query_log = folder_ / "log";
  EXPECT_THROW(Start(options), MapError);
  EXPECT_EQ(fs::file_size(folder_ / "precious"), 4U);
}

TEST_F(ApplicationTest, FullQueryLogSaysSoOnce) {
  ServiceOptions options;
  options.query_log = folder_ / "log";
  options.query_log_bytes = 10;
  Start(options);
  for (int i = 0; i < 3; ++i) Ask("POST", "/v1/localize", {}, "x");
  EXPECT_EQ(ReadQueries(options.query_log).size(), 1u);
  ASSERT_EQ(errors_.size(), 1u);
  EXPECT_NE(errors_[0].find("full"), std::string::npos);
}

// One body of JSON is parsed at a time.
TEST_F(ApplicationTest, WhoWaitsTooLongToBeParsedIsToldToTryAgain) {
  Start();
  const auto post = [this](Clock::time_point received, const std::function<std::string()>& body) {
    HttpRequest request;
    request.method = "POST";
    request.path = "/v1/maps/lab/localize";
    request.header = [](const std::string& name) -> std::optional<std::string> {
      if (name == "Content-Type") return "application/json";
      return std::nullopt;
    };
    request.received = received;
    request.read_body = body;
    return app_->Answer(request);
  };
  const auto body = [] { return std::string(R"({"images": [{"data": "eA=="}]})"); };
  const Clock::time_point long_ago = Clock::now() - std::chrono::hours(1);
  HttpResponse late;
  const HttpResponse first = post(long_ago, [&] {
    std::thread([&] { late = post(long_ago, body); }).join();
    return body();
  });
  EXPECT_EQ(first.status, 200) << "nobody was before it";
  EXPECT_EQ(late.status, 429);
  EXPECT_EQ(HeaderOf(late, "Retry-After"), "1");
}

TEST_F(ApplicationTest, UnusedFieldsAreNamed) {
  Start();
  const auto ask = [&](const std::string& json) {
    return Ask("POST", "/v1/maps/lab/localize", {{"Content-Type", "application/json"}},
               R"({"images":[{"data":""}],)" + json + "}");
  };
  const HttpResponse good = ask(R"("prior":{"keyframe":2},"previous":{"heading_rad":1})");
  ASSERT_EQ(good.status, 200) << good.body;
  EXPECT_EQ(Json::parse(good.body)["unused"], Json({"prior", "previous"}));
  EXPECT_EQ(ask(R"("prior":{"keyframe":3})").status, 400);
  const Json late = Json::parse(ask(R"("top_k":2,"debug":true)").body);
  EXPECT_TRUE(late["candidates"].empty());
  EXPECT_FALSE(late.contains("explanation")) << "bytes that are no image have none";
  EXPECT_FALSE(late.contains("unused"));
}

}  // namespace
}  // namespace waystone
