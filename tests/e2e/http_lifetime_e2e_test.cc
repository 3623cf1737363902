// SPDX-License-Identifier: Apache-2.0
// How the real server starts, changes its maps, turns clients away and ends.
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include "api/json.h"
#include "cli/system/child_process.h"
#include "tests/e2e/calibrated_maps.h"
#include "tests/e2e/served_map.h"
#include "tests/e2e/shared_map.h"
#include "tests/server/http/raw_client.h"

namespace waystone {
namespace {

constexpr int kPatienceS = 30;

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

TEST(HttpLimits, AreThoseOfTheFlags) {
  const std::filesystem::path folder = FreshFolder();
  const Served served({"--host", "0.0.0.0", "--insecure", "--max-body", "1", "--max-images", "1",
                       "--max-pixels", "100000", "--connections", "1", "--query-log",
                       folder / "log", "--query-log-max", "1"});
  const auto post = [&](const std::string& body, const std::string& type) {
    return Checked(served.NewClient().Post("/v1/maps/room/localize", body, type));
  };
  EXPECT_EQ(post(std::string(1'000'001, 'x'), "image/jpeg")->status, 413);
  const std::string image = R"({"data":"eA=="})";
  const std::string two = R"({"images":[)" + image + "," + image + "]}";
  EXPECT_EQ(post(two, "application/json")->status, 400);
  const auto large = post(ReadFile(TheMap().inside), "image/jpeg");
  EXPECT_NE(large->body.find("\"bad_image\""), std::string::npos) << large->body;
  // The one that fills the log is its last.
  for (int i = 0; i < 3; ++i) post(std::string(700'000, static_cast<char>('a' + i)), "image/jpeg");
  int logged = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder / "log")) {
    logged += entry.file_size() == 700'000 ? 1 : 0;
  }
  EXPECT_EQ(logged, 2);
  const std::string health = "GET /healthz HTTP/1.1\r\nHost: localhost\r\n\r\n";
  RawClient idle(std::stoi(served.url().substr(served.url().rfind(':') + 1)));
  idle.Send(health);
  EXPECT_NE(idle.Receive("\r\n\r\n").find("200 OK"), std::string::npos);
  EXPECT_TRUE(served.NewClient().Get("/healthz"));
  idle.Send(health);
  EXPECT_EQ(idle.Receive("\r\n\r\n"), "") << "it made room";
  std::filesystem::remove_all(folder);
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

// A load balancer that asks now and then learns of the end before it comes.
TEST(HttpLifetime, DrainsForTheStatedTime) {
  constexpr double kDrainS = 3;
  Served served({"--drain", std::to_string(kDrainS)});
  ASSERT_EQ(Checked(served.NewClient().Get("/readyz"))->status, 200);
  const auto start = std::chrono::steady_clock::now();
  const auto seconds = [start] {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  };
  served.process().Send(SIGTERM);
  int ready = 200;
  while (ready == 200 && seconds() < kDrainS)
    ready = Checked(served.NewClient().Get("/readyz"))->status;
  EXPECT_EQ(ready, 503);
  const auto answer =
      served.NewClient().Post("/v1/maps/room/localize", ReadFile(TheMap().inside), "image/jpeg");
  EXPECT_EQ(answer->status, 200);
  EXPECT_EQ(answer->get_header_value("Connection"), "close");
  EXPECT_EQ(served.process().Wait(), 0);
  EXPECT_GE(seconds(), kDrainS);
  EXPECT_LT(seconds(), kDrainS + 5);
}

// What the server does before it reads maps.
bool HoldsSignalsBack(pid_t pid) {
  const std::string status = ReadFile("/proc/" + std::to_string(pid) + "/status");
  const std::string key = "\nSigBlk:\t";
  const size_t at = status.find(key);
  if (at == std::string::npos) return false;
  const uint64_t mask = std::stoull(status.substr(at + key.size(), 16), nullptr, 16);
  return (mask & (uint64_t{1} << (SIGTERM - 1))) != 0;
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
    for (int i = 0; i < 1000 * kPatienceS && !HoldsSignalsBack(server.pid()); ++i) {
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    ASSERT_TRUE(HoldsSignalsBack(server.pid()));
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
  const auto metrics = [&] { return Checked(served.NewClient().Get("/metrics"))->body; };
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
  const std::string none_refused = "waystone_reloads_total{result=\"refused\"} 0";
  until([&] { return metrics().find(none_refused) == std::string::npos; });
  EXPECT_EQ(metrics().find(none_refused), std::string::npos);
  answered();
  stop = true;
  for (std::thread& client : clients) client.join();
  EXPECT_EQ(failures, 0);
  EXPECT_GE(answers, 3 * 7);
  EXPECT_GE(swaps(), 6);
  // A new file is served, and one that goes isn't.
  fs::copy_file(TheMap().map, folder / "hall.db");
  fs::remove(folder / "room.db");
  until([&] { return Checked(served.NewClient().Get("/v1/maps/room"))->status == 404; });
  EXPECT_EQ(Checked(served.NewClient().Get("/v1/maps/hall"))->status, 200);
  EXPECT_EQ(Checked(served.NewClient().Get("/v1/maps/room"))->status, 404);
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
  EXPECT_EQ(Checked(served.NewClient().Get("/v1/maps"))->status, 401);
  EXPECT_EQ(
      Checked(served.NewClient().Get("/v1/maps", {{"Authorization", "Bearer 0123456789abcdef"}}))
          ->status,
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
