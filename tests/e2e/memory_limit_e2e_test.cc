// SPDX-License-Identifier: Apache-2.0
// The real server with hardly more address space than it has taken.
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "tests/e2e/served_map.h"
#include "tests/e2e/shared_map.h"

namespace waystone {
namespace {

namespace fs = std::filesystem;

constexpr rlim_t kSpareBytes = 24'000'000;

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

  // Leaves the server this much more than it has.
  void Limit(rlim_t spare_bytes) {
    std::ifstream sizes("/proc/" + std::to_string(served_->process().pid()) + "/statm");
    rlim_t pages = 0;
    sizes >> pages;
    SetLimit(pages * static_cast<rlim_t>(getpagesize()) + spare_bytes);
  }
  void Unlimit() { SetLimit(RLIM_INFINITY); }

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

 private:
  void SetLimit(rlim_t bytes) {
    const rlimit limit{bytes, RLIM_INFINITY};
    ASSERT_EQ(prlimit(served_->process().pid(), RLIMIT_AS, &limit, nullptr), 0);
  }
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

TEST_F(LimitedServer, KeepsItsMapWhereTheNewOneDoesNotFit) {
  const std::string photo = ReadFile(TheMap().inside);
  ASSERT_EQ(Ask(photo), 200);
  const std::string map = ReadFile(map_);
  Limit(kSpareBytes);
  fs::resize_file(map_, 4'000'000'000);  // takes no place on the disk
  EXPECT_TRUE(WaitForReloads("refused", 2)) << "it doesn't try again";
  Unlimit();
  EXPECT_EQ(Ask(photo), 200);
  WriteFile(map_, map);
  EXPECT_TRUE(WaitForReloads("swapped", 1));
  EXPECT_EQ(Ask(photo), 200);
}

}  // namespace
}  // namespace waystone
