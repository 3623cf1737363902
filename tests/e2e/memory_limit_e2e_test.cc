// SPDX-License-Identifier: Apache-2.0
// The real server with hardly more address space than it has taken.
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <list>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <optional>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "tests/core/base/address_space.h"
#include "tests/e2e/served_map.h"
#include "tests/e2e/shared_map.h"
#include "tests/server/http/raw_client.h"

namespace waystone {
namespace {

namespace fs = std::filesystem;

constexpr rlim_t kSpareBytes = 24'000'000;

void SetAddressSpace(Served& served, std::optional<rlim_t> spare_bytes) {
  ASSERT_TRUE(LimitAddressSpace(served.process().pid(), spare_bytes));
}

class LimitedServer : public testing::Test {
 protected:
  LimitedServer() {
    fs::copy_file(TheMap().map, map_);
    served_.emplace(std::vector<std::string>{"--watch", "0.2"}, map_);
  }
  ~LimitedServer() override { fs::remove_all(folder_); }

  // The status of an answer; 0 for a connection that was closed.
  int Ask(const std::string& image) {
    const auto result = served_->NewClient().Post("/v1/maps/room/localize", image, "image/jpeg");
    return result ? result->status : 0;
  }

  std::string Get(const std::string& path) {
    const auto result = served_->NewClient().Get(path);
    return result && result->status == 200 ? result->body : "";
  }

  void Limit(rlim_t spare_bytes) { SetAddressSpace(*served_, spare_bytes); }
  void Unlimit() { SetAddressSpace(*served_, std::nullopt); }

  bool WaitForReloads(const std::string& result, int count) {
    const std::string line = "waystone_reloads_total{result=\"" + result + "\"} ";
    for (int i = 0; i < 300; ++i) {
      const std::string metrics = Get("/metrics");
      const size_t at = metrics.find(line);
      if (at != std::string::npos && std::stoi(metrics.substr(at + line.size())) >= count) {
        return true;
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
    }
    return false;
  }

  const fs::path folder_ = FreshFolder();
  const fs::path map_ = folder_ / "room.db";
  std::optional<Served> served_;
};

// Of 12 megapixels, noisy: it takes more memory than is left.
std::string LargeImage() {
  cv::Mat image(3000, 4000, CV_8UC1);
  cv::RNG random(1);
  random.fill(image, cv::RNG::UNIFORM, 0, 255);
  std::vector<uint8_t> jpeg;
  cv::imencode(".jpg", image, jpeg);
  return {jpeg.begin(), jpeg.end()};
}

TEST_F(LimitedServer, RefusesWhatDoesNotFitAndLivesOn) {
  const std::string large = LargeImage();
  const std::string photo = ReadFile(TheMap().inside);
  ASSERT_EQ(Ask(photo), 200);
  Limit(kSpareBytes);
  for (int i = 0; i < 3; ++i) {
    const int status = Ask(large);
    EXPECT_TRUE(status == 503 || status == 0) << status;
    EXPECT_NE(Get("/healthz"), "");
  }
  Unlimit();
  EXPECT_EQ(Ask(large), 200);
  EXPECT_EQ(Ask(photo), 200);
}

// A library that a first image sets up, or one that detects features, must not end the server. Each
// amount needs a server of its own: the memory of a query is kept for the next one.
TEST(LimitedServers, OutliveTheirFirstQuery) {
  const std::string photo = ReadFile(TheMap().inside);
  for (int i = 0; i < 15; ++i) {
    const double spare_mb = i < 10 ? 2 + 1.4 * i : 60 + 6 * (i - 10);
    Served served;
    SetAddressSpace(served, static_cast<rlim_t>(spare_mb * 1e6));
    const auto result = served.NewClient().Post("/v1/maps/room/localize", photo, "image/jpeg");
    SetAddressSpace(served, std::nullopt);
    ASSERT_TRUE(result) << "with " << spare_mb << " MB left";
    EXPECT_TRUE(result->status == 503 || result->status == 200) << result->status;
    EXPECT_EQ(Checked(served.NewClient().Get("/healthz"))->status, 200)
        << "with " << spare_mb << " MB left";
  }
}

TEST_F(LimitedServer, KeepsItsMapWhereTheNewOneDoesNotFit) {
  const std::string photo = ReadFile(TheMap().inside);
  ASSERT_EQ(Ask(photo), 200);
  const std::string map = ReadFile(map_);
  Limit(kSpareBytes);
  fs::resize_file(map_, 400'000'000);  // takes no place on the disk
  EXPECT_TRUE(WaitForReloads("refused", 2)) << "it doesn't try again";
  Unlimit();
  EXPECT_EQ(Ask(photo), 200);
  WriteFile(map_, map);
  EXPECT_TRUE(WaitForReloads("swapped", 1));
  EXPECT_EQ(Ask(photo), 200);
}

// A line of the server's /proc/PID/status, in MB.
int StatusMegabytes(Served& served, const std::string& field) {
  std::ifstream status("/proc/" + std::to_string(served.process().pid()) + "/status");
  for (std::string line; std::getline(status, line);) {
    if (line.starts_with(field + ":"))
      return std::stoi(line.substr(field.size() + 1)) / 1000 * 1024 / 1000;
  }
  return 0;
}

// How much more than before a server takes while 30 of these bodies, which it gets at once, are
// answered, each with one of the `statuses`.
int MegabytesForBodies(const std::string& body, const std::set<std::string>& statuses) {
  Served served({"--threads", "2"});
  EXPECT_EQ(
      Checked(served.NewClient().Post("/v1/localize", ReadFile(TheMap().inside), "image/jpeg"))
          ->status,
      200);
  const int before = StatusMegabytes(served, "VmRSS");
  const int port = std::stoi(served.url().substr(served.url().rfind(':') + 1));
  std::list<RawClient> clients;
  for (int i = 0; i < 30; ++i) {
    // Whole but for the last byte; the server refuses what is too much.
    clients.emplace_back(port).Send(
        "POST /v1/localize HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\n"
        "Content-Length: " +
        std::to_string(body.size()) + "\r\n\r\n" + body.substr(0, body.size() - 1));
  }
  for (RawClient& client : clients) client.Send(body.substr(body.size() - 1));
  for (RawClient& client : clients) {
    const std::string status = client.Receive("\r\n").substr(0, 12);
    EXPECT_TRUE(statuses.contains(status)) << status;
  }
  EXPECT_EQ(Checked(served.NewClient().Get("/healthz"))->status, 200);
  return StatusMegabytes(served, "VmHWM") - before;
}

// 450 MB for bodies, 120 MB for parsing one of them, and the decoded 15 MB of the image that each
// of the two query threads has in work: docs/operating.md. Usually 505 MB.
TEST(ServerMemory, HasABoundHoweverManyBodiesWait) {
  const std::string image = R"({"images":[{"data":")" + std::string(19'900'000, 'A') + R"("}]})";
  std::string values = R"({"images":[[])";
  while (values.size() < 19'900'000) values += ",[]";
  values += "]}";
  const int images_mb = MegabytesForBodies(image, {"HTTP/1.1 200", "HTTP/1.1 429", ""});
  const int values_mb = MegabytesForBodies(values, {"HTTP/1.1 400", "HTTP/1.1 429", ""});
  std::cout << "bodies of one image " << images_mb << " MB, of many values " << values_mb
            << " MB\n";
  EXPECT_LT(images_mb, 620);
  EXPECT_LT(values_mb, 500);
}

// As a user of its own, for root has no limit.
TEST(ThreadLimit, IsSaid) {
  const fs::path folder = FreshFolder();
  fs::permissions(folder, fs::perms::owner_all | fs::perms::others_read | fs::perms::others_exec);
  for (const fs::path& file : {fs::path(WAYSTONE_PROGRAM), TheMap().map, TheMap().inside}) {
    fs::copy_file(file, folder / file.filename());
    fs::permissions(folder / file.filename(), fs::perms::others_read | fs::perms::others_exec,
                    fs::perm_options::add);
  }
  const std::string user =
      geteuid() == 0 ? "setpriv --reuid=61234 --regid=61234 --clear-groups " : "";
  const std::string limited =
      "limited() { shift; cd '" + folder.string() + "'; " + user + "prlimit --nproc=1 ./" +
      fs::path(WAYSTONE_PROGRAM).filename().string() + " \"$@\"; }; limited";
  for (const std::vector<std::string>& arguments :
       {std::vector<std::string>{"serve", "room.db", "--port", "0"}, {"audit", "room.db"}}) {
    const RunResult result = RunWaystone(arguments, limited);
    EXPECT_EQ(result.code, 3);
    EXPECT_TRUE(result.err.starts_with("waystone: cannot start a thread (")) << result.err;
    EXPECT_EQ(std::ranges::count(result.err, '\n'), 1) << result.err;
  }
  const RunResult localized =
      RunWaystone({"localize", "room.db", TheMap().inside.filename().string()}, limited);
  EXPECT_EQ(localized.code, 0) << "one photo needs one thread: " << localized.err;
  fs::remove_all(folder);
}

}  // namespace
}  // namespace waystone
