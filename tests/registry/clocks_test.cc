// SPDX-License-Identifier: Apache-2.0
// Publishers and servers whose clocks are apart: what is current is decided by the order of changes
// alone.
#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "api/json.h"
#include "registry/map_cache.h"
#include "registry/registry.h"
#include "tests/registry/postgres_server.h"
#include "tests/registry/test_folder.h"

namespace waystone {
namespace {

namespace fs = std::filesystem;

MapVersion PublishedAt(char digit, const std::string& when) {
  const Json details = {{"layers", Json::array({"planes"})},
                        {"tags", Json::array()},
                        {"published_at", when},
                        {"summary", {{"name", "lab"}}}};
  return {"lab", 0, "sha256:" + std::string(64, digit), 1000, Dump(details)};
}

// The one version that a server would serve. News come a moment after the change.
MapVersion CurrentOf(Registry& server) {
  RegistryNews news = server.Refresh();
  for (int i = 0; i < 5000 && news.changed.empty(); ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
    news = server.Refresh();
  }
  EXPECT_EQ(news.changed.size(), 1U);
  return news.changed.empty() ? MapVersion{} : news.changed[0].version;
}

void ExpectTheLastChangeToCount(const std::string& url) {
  const auto publisher = OpenRegistry(url, NewRegistry{"/a store"});
  const auto server = OpenRegistry(url);
  EXPECT_EQ(publisher->Publish(PublishedAt('a', "2031-01-01T00:00:00Z")).number, 1);
  EXPECT_EQ(CurrentOf(*server).number, 1);
  EXPECT_EQ(publisher->Publish(PublishedAt('b', "1971-01-01T00:00:00Z")).number, 2);
  EXPECT_EQ(CurrentOf(*server).sha256, PublishedAt('b', "").sha256);
  EXPECT_EQ(publisher->Publish(PublishedAt('c', "2026-01-01T00:00:00Z")).number, 3);
  EXPECT_EQ(CurrentOf(*server).number, 3);
  EXPECT_EQ(publisher->Rollback("lab", std::nullopt).number, 2);
  EXPECT_EQ(CurrentOf(*server).number, 2);
}

TEST(Clocks, OfPublishersDecideNothing) {
  const TestFolder folder;
  ExpectTheLastChangeToCount((folder / "registry").string());
  if (!PostgresServer::Programs()) {
    GTEST_SKIP() << "PostgreSQL isn't installed (apt-get install postgresql)";
  }
  const PostgresServer postgres;
  ExpectTheLastChangeToCount(postgres.url());
}

// A file server whose clock is years ahead or behind, or is set back, stamps what is written.
TEST(Clocks, OfAFileServerHideNoChange) {
  const TestFolder folder;
  const fs::path current = folder / "registry" / "current";
  const auto publisher = OpenRegistry((folder / "registry").string(), NewRegistry{"/a store"});
  const auto server = OpenRegistry((folder / "registry").string());
  const auto now = fs::file_time_type::clock::now();
  char digit = 'a';
  for (const int days : {4000, -4000, 1, 0, -1}) {
    const int number = publisher->Publish(PublishedAt(digit++, "")).number;
    const auto stamp = now + std::chrono::hours(24 * days);
    fs::last_write_time(current / "lab.json", stamp);
    fs::last_write_time(current, stamp);
    EXPECT_EQ(CurrentOf(*server).number, number) << days << " days";
    EXPECT_TRUE(server->Refresh().changed.empty());
  }
}

// A cache whose files come from the future, or were used before the clock was set back.
TEST(Clocks, OfACacheLoseNoFile) {
  const TestFolder folder;
  const auto now = fs::file_time_type::clock::now();
  const std::vector<std::string> digits = {std::string(64, 'a'), std::string(64, 'b')};
  for (int i = 0; i < 2; ++i) {
    const fs::path file = folder / (digits[i] + ".db");
    WriteBytes(file, std::string(1000, 'x'));
    fs::last_write_time(file, now + std::chrono::hours(i == 0 ? 90'000 : -90'000));
  }
  MapCache cache(folder.path(), 5000);
  EXPECT_EQ(cache.usage().files, 2);
  for (const std::string& hash : digits) EXPECT_TRUE(cache.Find("sha256:" + hash));
}

}  // namespace
}  // namespace waystone
