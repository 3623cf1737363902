// SPDX-License-Identifier: Apache-2.0
// Three servers of one registry behind HAProxy, with the configuration that is shipped.
#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <csignal>
#include <filesystem>
#include <iostream>
#include <memory>
#include <string>
#include <vector>

#include "api/json.h"
#include "cli/system/child_process.h"
#include "core/base/clock.h"
#include "tests/e2e/registry_server.h"
#include "tests/e2e/served_map.h"
#include "tests/e2e/shared_map.h"

namespace waystone {
namespace {

namespace fs = std::filesystem;

constexpr const char* kHaproxy = "/usr/sbin/haproxy";
constexpr int kServers = 3;
constexpr int kMaps = 12;

// A port that nobody has now.
int FreePort() {
  const int listener = socket(AF_INET, SOCK_STREAM, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t length = sizeof address;
  EXPECT_EQ(bind(listener, reinterpret_cast<sockaddr*>(&address), length), 0);
  getsockname(listener, reinterpret_cast<sockaddr*>(&address), &length);
  close(listener);
  return ntohs(address.sin_port);
}

std::string WithoutTimes(const std::string& body) {
  Json json = Json::parse(body);
  json.erase("timing_ms");
  return Dump(json);
}

double MedianOf(std::vector<double> values) {
  std::ranges::nth_element(values, values.begin() + std::ssize(values) / 2);
  return values[values.size() / 2];
}

class BalancingTest : public testing::Test {
 protected:
  ~BalancingTest() override {
    proxy_.reset();
    for (auto& server : servers_) server.reset();
    fs::remove_all(folder_);
  }

  void SetUp() override {
    if (!fs::exists(kHaproxy)) GTEST_SKIP() << "HAProxy isn't installed (apt-get install haproxy)";
    fs::create_directory(folder_ / "files");
    for (int i = 0; i < kMaps; ++i) {
      const fs::path file = folder_ / "files" / (NameOfMap(i) + ".db");
      fs::copy_file(TheMap().map, file);
      const RunResult published = RunWaystone({"publish", file, "--to", folder_ / "registry"});
      ASSERT_EQ(published.code, 0) << published.err;
    }
    address_ = "127.0.0.1:" + std::to_string(FreePort());
    for (int i = 0; i < kServers; ++i) StartServer(i);
    std::vector<std::string> command = {"/usr/bin/env", "WAYSTONE_BIND=" + address_};
    for (int i = 0; i < kServers; ++i) {
      command.push_back("WAYSTONE_SERVER_" + std::to_string(i + 1) + "=" + servers_[i]->address());
    }
    command.insert(command.end(), {kHaproxy, "-db", "-q", "-f",
                                   std::string(WAYSTONE_SOURCE_DIR) + "/deploy/haproxy.cfg"});
    proxy_ = std::make_unique<ChildProcess>(command, true);
    ASSERT_TRUE(Until([&] {
      const auto result = NewClient().Get("/readyz");
      return result && result->status == 200;
    }));
  }
  void StartServer(int i) {
    servers_[i] = std::make_unique<RegistryServer>(
        (folder_ / "registry").string(), folder_ / ("cache" + std::to_string(i)),
        std::vector<std::string>{"--public-name", address_, "--memory", "100M"});
  }

  static std::string NameOfMap(int i) { return "map" + std::to_string(i); }
  httplib::Client NewClient() const {
    httplib::Client client("http://" + address_);
    client.set_read_timeout(30);
    client.set_tcp_nodelay(true);
    client.set_keep_alive(true);
    return client;
  }
  // Answers each map's query through the proxy, tried again where none came; how often.
  int AskAll(const std::vector<std::string>& expected) const {
    const std::string photo = ReadFile(TheMap().inside);
    int retries = 0;
    for (int i = 0; i < kMaps; ++i) {
      std::string answer;
      for (int attempt = 0; attempt < 5 && answer.empty(); ++attempt) {
        const auto result =
            NewClient().Post("/v1/maps/" + NameOfMap(i) + "/localize", photo, "image/jpeg");
        if (result && result->status == 200) answer = WithoutTimes(result->body);
        retries += answer.empty() ? 1 : 0;
      }
      EXPECT_EQ(answer, expected[i]) << NameOfMap(i);
    }
    return retries;
  }

  const fs::path folder_ = FreshFolder();
  std::string address_;
  std::array<std::unique_ptr<RegistryServer>, kServers> servers_;
  std::unique_ptr<ChildProcess> proxy_;
};

TEST_F(BalancingTest, AnswersAreThoseOfOneServerWhoeverIsKilled) {
  std::vector<std::string> expected;
  std::vector<double> direct_ms;
  {
    const Served plain({}, folder_ / "files");
    for (int i = 0; i < kMaps; ++i) {
      const auto result = plain.NewClient().Post("/v1/maps/" + NameOfMap(i) + "/localize",
                                                 ReadFile(TheMap().inside), "image/jpeg");
      expected.push_back(WithoutTimes(result->body));
    }
  }
  EXPECT_EQ(AskAll(expected), 0);
  EXPECT_EQ(AskAll(expected), 0);
  // Each map was opened by one server, and no server had them all.
  double opened = 0;
  for (const auto& server : servers_) {
    opened += server->Metric("waystone_map_opens_total");
    EXPECT_LT(server->Metric("waystone_map_opens_total"), kMaps);
  }
  EXPECT_EQ(opened, kMaps);
  for (const char* path : {"/metrics", "/%6detrics", "/%6D%65trics?x"}) {
    EXPECT_EQ(Checked(NewClient().Get(path))->status, 404) << path << ": not for strangers";
  }
  // What the proxy adds.
  httplib::Client through = NewClient();
  httplib::Client straight("http://" + servers_[0]->address());
  straight.set_tcp_nodelay(true);
  straight.set_keep_alive(true);
  std::vector<double> proxied_ms;
  for (int i = 0; i < 200; ++i) {
    for (const bool proxied : {true, false}) {
      const Clock::time_point start = Clock::now();
      const auto result = (proxied ? through : straight).Get("/version");
      ASSERT_TRUE(result && result->status == 200);
      (proxied ? proxied_ms : direct_ms).push_back(MillisecondsSince(start));
    }
  }
  std::cout << "median of a request: " << MedianOf(direct_ms) << " ms, through HAProxy "
            << MedianOf(proxied_ms) << " ms\n";
  EXPECT_LT(MedianOf(proxied_ms) - MedianOf(direct_ms), 20) << "1 ms on an idle machine";
  // One server after the other is killed and comes back: everything is answered, some on retry.
  for (int i = 0; i < kServers; ++i) {
    servers_[i]->process().Send(SIGKILL);
    servers_[i]->process().Wait();
    const int retries = AskAll(expected);
    EXPECT_LT(retries, kMaps);
    const std::string port = servers_[i]->address().substr(servers_[i]->address().find(':') + 1);
    servers_[i] = std::make_unique<RegistryServer>(
        (folder_ / "registry").string(), folder_ / ("cache" + std::to_string(i)),
        std::vector<std::string>{"--public-name", address_}, "0.1", port);
    ASSERT_TRUE(Until([&] { return servers_[i]->Status("/readyz") == 200; }));
  }
  AskAll(expected);
}

}  // namespace
}  // namespace waystone
