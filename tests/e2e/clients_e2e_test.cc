// SPDX-License-Identifier: Apache-2.0
// The clients against the real server.
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cstdlib>
#include <filesystem>
#include <memory>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/videoio.hpp>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include "api/json.h"
#include "cli/system/child_process.h"
#include "tests/e2e/shared_map.h"

// After Eigen, for which the macro _res of the resolver's header spells trouble.
#include "clients/cpp/waystone_client.h"

namespace waystone {
namespace {

namespace fs = std::filesystem;

// Debian's Python; the clients need nothing but its library.
TEST(Clients, PythonRosAndExamplesWithALiveServer) {
  const std::string command =
      "WAYSTONE_CPP_EXAMPLE=" WAYSTONE_CPP_EXAMPLE " /usr/bin/python3 " WAYSTONE_SOURCE_DIR
      "/tests/e2e/clients.py " WAYSTONE_PROGRAM " " +
      TheMap().map.string() + " " + TheMap().inside.string() + " " + TheMap().elsewhere.string();
  const int status = std::system(command.c_str());  // NOLINT(cert-env33-c): made of our own paths
  constexpr int kSkipped = 77;
  if (WIFEXITED(status) && WEXITSTATUS(status) == kSkipped) {
    GTEST_SKIP() << "the client for JavaScript: Node is missing";
  }
  EXPECT_EQ(status, 0);
}

// Every command block of the documents, and what they say of the source.
TEST(Docs, CommandsRunAndTextsAreTrue) {
  const std::string command = "/usr/bin/python3 " WAYSTONE_SOURCE_DIR
                              "/tests/e2e/docs.py " WAYSTONE_PROGRAM " " +
                              TheMap().map.string() + " " + TheMap().images.string() + " " +
                              TheMap().inside.string() + " " + TheMap().elsewhere.string();
  EXPECT_EQ(std::system(command.c_str()), 0);  // NOLINT(cert-env33-c): made of our own paths
}

// Two servers of the shared map, one of which wants a token.
class CppClient : public testing::Test {
 protected:
  static constexpr const char* kToken = "an-entirely-secret-token";

  static void SetUpTestSuite() {
    folder_ = FreshFolder();
    WriteFile(folder_ / "tokens", std::string(kToken) + "\n");
    open_ = std::make_unique<ChildProcess>(
        std::vector<std::string>{WAYSTONE_PROGRAM, "serve", TheMap().map, "--port", "0"}, true);
    guarded_ = std::make_unique<ChildProcess>(
        std::vector<std::string>{WAYSTONE_PROGRAM, "serve", TheMap().map, "--port", "0",
                                 "--token-file", (folder_ / "tokens").string()},
        true);
    url_ = UrlOf(*open_);
    guarded_url_ = UrlOf(*guarded_);
  }
  static void TearDownTestSuite() {
    open_.reset();
    guarded_.reset();
    fs::remove_all(folder_);
  }

  static std::string UrlOf(ChildProcess& server) {
    const std::string line = server.ReadLine();
    const size_t at = line.find("http://");
    EXPECT_NE(at, std::string::npos) << line;
    return line.substr(at);
  }

  template <class Do>
  static void ExpectError(const std::string& code, int status, const Do& act) {
    try {
      act();
      ADD_FAILURE() << "expected " << code;
    } catch (const ClientError& error) {
      EXPECT_EQ(error.code(), code) << error.what();
      EXPECT_EQ(error.status(), status) << error.what();
      EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos);
    }
  }

  static std::vector<std::string> Lines(const std::string& text) {
    std::istringstream in(text);
    std::vector<std::string> lines;
    for (std::string line; std::getline(in, line);) lines.push_back(line);
    return lines;
  }

  static inline fs::path folder_;
  static inline std::unique_ptr<ChildProcess> open_;
  static inline std::unique_ptr<ChildProcess> guarded_;
  static inline std::string url_;
  static inline std::string guarded_url_;
};

TEST_F(CppClient, AsksOneMapAndAll) {
  const Client client(url_ + "/");
  const Json one = client.Localize(TheMap().inside.string(), "room", {{"debug", true}});
  EXPECT_EQ(one["verdict"], "localized");
  EXPECT_EQ(one["image"], TheMap().inside.string());
  EXPECT_FALSE(one["explanation"]["candidates"].empty());
  EXPECT_EQ(client.Localize(TheMap().inside.string())["maps"][0]["map"], "room");
  const Json two = client.Localize(std::vector<Photo>{Client::Read(TheMap().elsewhere.string()),
                                                      {"a\"b\\c\n", ReadFile(TheMap().inside)}},
                                   "room");
  EXPECT_EQ(two["image"], "a\"b\\c_");
  EXPECT_EQ(two["images"][0]["verdict"], "not_in_map");
}

TEST_F(CppClient, LooksAtMaps) {
  const Client client(guarded_url_, {.token = kToken});
  EXPECT_EQ(client.Rows("/v1/maps", "maps").at(0)["name"], "room");
  const Json map = client.Get(Client::MapPath("room"));
  EXPECT_EQ(client.Rows(Client::MapPath("room") + "/keyframes", "keyframes").size(),
            map["keyframes"].get<size_t>());
  EXPECT_EQ(Client::MapPath("a b/ü"), "/v1/maps/a%20b%2F%C3%BC");
  EXPECT_EQ(client.GetText("/healthz"), "ok\n");
}

TEST_F(CppClient, ProblemsAreOneException) {
  const Client client(url_);
  ExpectError("not_found", 404, [&] { client.Localize(TheMap().inside.string(), "attic"); });
  ExpectError("bad_request", 400, [&] {
    client.Localize(TheMap().inside.string(), "room", {{"top_k", 0}});
  });
  ExpectError("unreadable_photo", 0, [&] { client.Localize(std::string("/none.jpg")); });
  ExpectError("unauthorized", 401, [&] { Client(guarded_url_).Get("/v1/maps"); });
  ExpectError("unreachable", 0, [&] { Client("http://127.0.0.1:1").Get("/v1/maps"); });
  ExpectError("unreachable", 0, [&] { Client("127.0.0.1"); });
  ExpectError("bad_answer", 200, [&] { client.Get("/plain"); });
}

// A server of the test's own, for what one of Waystone can't be brought to do at will.
class OtherServer {
 public:
  ~OtherServer() {
    server_.stop();
    if (thread_.joinable()) thread_.join();
  }

  httplib::Server& server() { return server_; }

  // Returns its address.
  std::string Start() {
    const int port = server_.bind_to_any_port("127.0.0.1");
    thread_ = std::thread([this] { server_.listen_after_bind(); });
    return "http://127.0.0.1:" + std::to_string(port);
  }

 private:
  httplib::Server server_;
  std::thread thread_;
};

TEST_F(CppClient, BusyIsAskedAgain) {
  OtherServer other;
  int asked = 0;
  std::string wait = "0";
  other.server().Get("/here/v1/maps", [&](const httplib::Request&, httplib::Response& response) {
    response.status = ++asked % 3 == 0 ? 200 : 429;
    response.set_header("Retry-After", wait);
    response.set_content("{}", "application/json");
  });
  const std::string url = other.Start() + "/here/";
  EXPECT_EQ(Client(url).Get("/v1/maps"), Client::Json::object());
  EXPECT_EQ(asked, 3);
  ExpectError("bad_answer", 429, [&] { Client(url, {.retries = 1}).Get("/v1/maps"); });
  asked = 0;
  wait = "3600";
  ExpectError("bad_answer", 429, [&] { Client(url).Get("/v1/maps"); });
  EXPECT_EQ(asked, 1) << "an hour is not waited for";
  asked = 0;
  wait = "2";
  ExpectError("bad_answer", 429, [&] { Client(url, {.total_s = 1}).Get("/v1/maps"); });
  EXPECT_EQ(asked, 1) << "the wait doesn't fit into the call";
}

// Each piece comes in time, but the whole would never.
TEST_F(CppClient, ATrickleEndsWithTheTimeOfACall) {
  OtherServer other;
  other.server().Post("/.*", [](const httplib::Request&, httplib::Response& response) {
    response.set_chunked_content_provider("application/json", [](size_t, httplib::DataSink& sink) {
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
      return sink.write(" ", 1);
    });
  });
  const Client client(other.Start(), {.total_s = 1});
  const auto start = std::chrono::steady_clock::now();
  ExpectError("timeout", 0, [&] { client.Localize(Photo{"a.jpg", "x"}); });
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(5));
}

TEST_F(CppClient, WhatIsNoAnswerIsRefused) {
  OtherServer other;
  std::string body;
  other.server().Post("/.*", [&](const httplib::Request&, httplib::Response& response) {
    response.set_content(body, "application/json");
  });
  const std::string url = other.Start();
  const auto run = [&](const std::string& answer) {
    body = answer;
    return RunWaystone({"localize", "-", TheMap().inside, "--server", url});
  };
  for (const char* answer :
       {R"({"verdict":"localized"})", "[]", "7", R"({"verdict":1})",
        R"({"verdict":"not_in_map","image":"q"})",
        R"({"verdict":"localized","image":"q","timing_ms":{"total":1},"place":null})"}) {
    const RunResult result = run(answer);
    EXPECT_EQ(result.code, 3) << answer;
    EXPECT_EQ(result.out, "") << answer;
    EXPECT_NE(result.err.find("is no answer"), std::string::npos) << result.err;
  }
  for (const char* answer : {"[]", "{}", R"({"verdict":1})"}) {
    body = answer;
    ExpectError("bad_answer", 200, [&] { Client(url).Localize(Photo{"a.jpg", "x"}); });
  }
  const RunResult whole = run(R"({"verdict":"not_in_map","image":"q","timing_ms":{"total":1}})");
  EXPECT_EQ(whole.code, 0) << whole.err;
}

TEST_F(CppClient, PhotosKeepTheirNames) {
  const fs::path photo = folder_ / "\xd1\x84 \"q\" \\.jpg";
  fs::copy_file(TheMap().inside, photo);
  const fs::path deep = folder_ / std::string(120, 'd') / std::string(120, 'e');
  fs::create_directories(deep);
  fs::copy_file(TheMap().inside, deep / "q.jpg");
  for (const fs::path& path : {photo, deep / "q.jpg"}) {
    const RunResult local = RunWaystone({"localize", TheMap().map, path, "--json"});
    const RunResult served = RunWaystone({"localize", "room", path, "--json", "--server", url_});
    EXPECT_EQ(served.code, 0) << served.err;
    EXPECT_EQ(Json::parse(served.out)["image"], path.string());
    EXPECT_EQ(Json::parse(served.out)["image"], Json::parse(local.out)["image"]);
  }
}

TEST_F(CppClient, LocalizeByAServer) {
  const RunResult local =
      RunWaystone({"localize", TheMap().map, TheMap().inside, TheMap().elsewhere, "--json"});
  const RunResult served = RunWaystone(
      {"localize", "room", TheMap().inside, TheMap().elsewhere, "--json", "--server", url_});
  EXPECT_EQ(served.code, 0) << served.err;
  const std::vector<std::string> here = Lines(local.out);
  const std::vector<std::string> there = Lines(served.out);
  ASSERT_EQ(here.size(), 2u);
  ASSERT_EQ(there.size(), 2u);
  for (size_t i = 0; i < 2; ++i) {
    Json a = Json::parse(here[i]);
    Json b = Json::parse(there[i]);
    a.erase("timing_ms");
    b.erase("timing_ms");
    EXPECT_EQ(a.dump(), b.dump());
  }
  const RunResult refused =
      RunWaystone({"localize", "-", TheMap().inside, "--server", guarded_url_});
  EXPECT_EQ(refused.code, 3);
  EXPECT_NE(refused.err.find("Bearer TOKEN"), std::string::npos) << refused.err;
  const RunResult line = RunWaystone({"localize", "-", TheMap().inside, "--server", guarded_url_,
                                      "--token-file", folder_ / "tokens"});
  EXPECT_EQ(line.code, 0) << line.err;
  EXPECT_NE(line.out.find("inside.jpg: localized near "), std::string::npos) << line.out;
  // As the server's own reader takes them.
  WriteFile(folder_ / "windows", "\r\n# ours\r\n" + std::string(kToken) + "\r\n");
  const RunResult windows = RunWaystone({"localize", "-", TheMap().inside, "--server", guarded_url_,
                                         "--token-file", folder_ / "windows"});
  EXPECT_EQ(windows.code, 0) << windows.err;
}

TEST_F(CppClient, WatchAnswersAVideo) {
  const fs::path video = folder_ / "walk.avi";
  {
    cv::VideoWriter writer(video.string(), cv::VideoWriter::fourcc('M', 'J', 'P', 'G'), 10,
                           {640, 480}, false);
    ASSERT_TRUE(writer.isOpened());
    for (int i = 18; i < 23; ++i) {
      writer.write(cv::imread((TheMap().images / (std::to_string(i) + ".jpg")).string(),
                              cv::IMREAD_GRAYSCALE));
    }
  }
  const RunResult local = RunWaystone({"watch", TheMap().map, video, "--every", "0.2", "--json"});
  ASSERT_EQ(local.code, 0) << local.err;
  const std::vector<std::string> lines = Lines(local.out);
  ASSERT_EQ(lines.size(), 3u) << local.out;
  const char* const names[] = {"0.000 s", "0.200 s", "0.400 s"};
  for (size_t i = 0; i < 3; ++i) {
    const Json answer = Json::parse(lines[i]);
    EXPECT_EQ(answer["image"], names[i]);
    EXPECT_EQ(answer["map"], "room");
    EXPECT_EQ(answer["verdict"], "localized") << lines[i];
  }
  const RunResult served =
      RunWaystone({"watch", "room", video, "--every", "0", "--count", "2", "--server", url_});
  ASSERT_EQ(served.code, 0) << served.err;
  ASSERT_EQ(Lines(served.out).size(), 2u);
  EXPECT_TRUE(Lines(served.out)[1].starts_with("0.100 s: localized near ")) << served.out;
  for (const char* source : {"nowhere.avi", "9876", "99999999999"}) {
    const RunResult bad = RunWaystone({"watch", TheMap().map, source});
    EXPECT_EQ(bad.code, 3) << source;
    EXPECT_NE(bad.err.find("camera index"), std::string::npos) << bad.err;
  }
  std::string bytes = ReadFile(video);
  const size_t second = bytes.find("00dc", bytes.find("00dc", bytes.find("movi")) + 1);
  ASSERT_LT(second + 2000, bytes.size());
  bytes.replace(second + 8, 2000, 2000, '\0');
  WriteFile(folder_ / "damaged.avi", bytes);
  const RunResult damaged =
      RunWaystone({"watch", TheMap().map, folder_ / "damaged.avi", "--every", "0"});
  EXPECT_EQ(damaged.code, 0) << damaged.err;
  EXPECT_EQ(Lines(damaged.out).size(), 4u) << damaged.out;
  EXPECT_TRUE(damaged.out.starts_with("0.000 s: ")) << damaged.out;
  EXPECT_NE(damaged.out.find("\n0.200 s: "), std::string::npos) << damaged.out;
  EXPECT_EQ(damaged.err, "");
}

}  // namespace
}  // namespace waystone
