// SPDX-License-Identifier: Apache-2.0
// What a server keeps of a registry, and how it goes on with that alone.
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <regex>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "tests/registry/file_size_limit.h"
#include "tests/server/service/registry_maps_fixture.h"

namespace waystone {
namespace {

namespace fs = std::filesystem;

TEST_F(RegistryMapsTest, AFileThatWasDamagedInTheCacheIsFetchedAgain) {
  const MapVersion lab = Publish("lab", 3);
  Start();
  Planes("lab");
  maps_.reset();
  const fs::path cached = folder_.path() / "cache" / (lab.sha256.substr(7) + ".db");
  std::string bytes = ReadAll(cached);
  bytes[bytes.size() / 2] ^= 1;
  WriteBytes(cached, bytes);
  Start();
  EXPECT_NE(Failure("lab").find("the server's log says why"), std::string::npos);
  EXPECT_TRUE(Until([&] { return HasLogged("the file in the cache was damaged"); })) << log();
  EXPECT_TRUE(Until([&] {
    try {
      return Planes("lab") == 3;
    } catch (const MapError&) {
      return false;
    }
  }));
}

// As docs/scaling.md says of deleting a map.
TEST_F(RegistryMapsTest, AFileThatWasDeletedFromTheCacheIsFetchedAgain) {
  const MapVersion lab = Publish("lab", 3);
  options_.memory_bytes = 3 * Publish("hall", 4).bytes;  // for one of them
  Start();
  EXPECT_EQ(Planes("lab"), 3U);
  EXPECT_EQ(Planes("hall"), 4U);
  EXPECT_EQ(maps_->holdings().open, 1U);
  ASSERT_TRUE(fs::remove(options_.cache / (lab.sha256.substr(7) + ".db")));
  EXPECT_EQ(Planes("lab"), 3U);
  EXPECT_EQ(Held().fetched_files, 3);
  EXPECT_EQ(Held().refused, 0);
}

TEST_F(RegistryMapsTest, ACacheThatWasRemovedIsMadeAgain) {
  Publish("hall", 4);
  Publish("lab", 3);
  Start();
  EXPECT_EQ(Planes("hall"), 4U);
  fs::remove_all(options_.cache);
  EXPECT_EQ(Planes("hall"), 4U) << "open";
  EXPECT_EQ(Planes("lab"), 3U);
  maps_.reset();
  fs::rename(folder_ / "registry", folder_ / "registry.away");
  Start();
  EXPECT_NE(log().find("serving what the cache knows of (maps: 2)"), std::string::npos) << log();
  EXPECT_EQ(Planes("hall"), 4U);
}

// 503, whose cause with its path is in the log alone.
TEST_F(RegistryMapsTest, ACacheThatCantBeWrittenIsSaidWithoutItsPath) {
  const MapVersion lab = Publish("lab", 3);
  Start();
  {
    const FileSizeLimit limit(static_cast<rlim_t>(lab.bytes - 1));
    const std::string error = Failure("lab", ErrorCode::kNoRoom);
    EXPECT_NE(error.find("map 'lab': the map's file can't be written: File too large, "),
              std::string::npos)
        << error;
    EXPECT_EQ(error.find('/'), std::string::npos) << error;
    const std::string part = (options_.cache / (lab.sha256.substr(7) + ".part")).string();
    EXPECT_TRUE(Until([&] { return HasLogged(part + " can't be written: File too large"); }))
        << log();
    EXPECT_EQ(Failure("lab", ErrorCode::kNoRoom), error) << "also while it isn't tried again";
  }
  fs::remove_all(options_.cache);
  WriteBytes(options_.cache, "in its place");
  maps_->Refresh();
  EXPECT_EQ(Failure("lab"), "map 'lab': it can't be opened now; the server's log says why");
  EXPECT_EQ(InfoOf(ErrorCode::kNotReady).http_status, 503);
  EXPECT_TRUE(Until([&] {
    return HasLogged(options_.cache.string() + " can't be written: Not a directory");
  })) << log();
  fs::remove(options_.cache);
  maps_->Refresh();
  EXPECT_EQ(Planes("lab"), 3U);
}

TEST_F(RegistryMapsTest, GoesOnAndStartsWithoutRegistryAndStore) {
  Publish("lab", 3);
  Publish("hall", 4);
  Start();
  EXPECT_EQ(Planes("lab"), 3U);
  fs::rename(folder_ / "registry", folder_ / "registry.away");
  fs::rename(folder_ / "store", folder_ / "store.away");
  EXPECT_TRUE(Until([&] { return !Held().connected; }));
  EXPECT_NE(log().find("; serving what is known"), std::string::npos);
  EXPECT_EQ(Planes("lab"), 3U);
  EXPECT_EQ(Failure("hall", ErrorCode::kStoreUnavailable),
            "map 'hall': it can't be opened now; the server's log says why")
      << "whose paths are no concern of clients";
  EXPECT_TRUE(Until([&] { return HasLogged("check the store"); })) << log();
  Start();
  EXPECT_FALSE(Held().connected);
  EXPECT_NE(log().find("serving what the cache knows of (maps: 2)"), std::string::npos) << log();
  EXPECT_EQ(Planes("lab"), 3U);
  Failure("hall", ErrorCode::kStoreUnavailable);
  EXPECT_TRUE(Until([&] { return HasLogged("check the store"); })) << log();
  fs::rename(folder_ / "registry.away", folder_ / "registry");
  fs::rename(folder_ / "store.away", folder_ / "store");
  Publish("lab", 5);
  EXPECT_TRUE(Until([&] { return Planes("lab") == 5; }));
  EXPECT_TRUE(Held().connected);
  maps_->Refresh();
  EXPECT_EQ(Planes("hall"), 4U);
}

// A server that knows of a version that it can't get serves the one that it has.
TEST_F(RegistryMapsTest, StartsWithTheVersionThatItHas) {
  Publish("lab", 3);
  Start();
  Planes("lab");
  maps_.reset();
  const MapVersion second = Publish("lab", 5);
  fs::rename(folder_ / "store", folder_ / "store.away");
  Start();
  EXPECT_EQ(Planes("lab"), 3U);
  EXPECT_EQ(Planes("lab"), 3U);
  fs::rename(folder_ / "store.away", folder_ / "store");
  maps_->Refresh();
  EXPECT_TRUE(Until([&] { return Planes("lab") == 5; }));
}

TEST_F(RegistryMapsTest, ARegistryThatWasNeverSeenIsAnError) {
  options_.registry = (folder_ / "nowhere").string();
  EXPECT_THROW(Start(), MapError);
  options_.registry = (folder_ / "registry").string();
  Start();
  // Another registry in its place knows other maps.
  Publish("lab", 3);
  EXPECT_TRUE(Until([&] { return maps_->Names().size() == 1; }));
  maps_.reset();
  fs::remove_all(folder_ / "registry");
  registry_ = OpenRegistry(options_.registry, NewRegistry{(folder_ / "store").string()});
  Start();
  EXPECT_TRUE(maps_->Names().empty());
}

TEST_F(RegistryMapsTest, DamagedKnowledgeIsNotUsed) {
  Publish("lab", 3);
  Start();
  maps_.reset();
  const std::string known = ReadAll(folder_ / "cache" / "known.jsonl");
  for (const std::string& text :
       {known.substr(0, known.size() / 2), std::string("x\n"), known + "{\"current\":{}}\n"}) {
    WriteBytes(folder_ / "cache" / "known.jsonl", text);
    Start();
    EXPECT_EQ(Planes("lab"), 3U);
    maps_.reset();
    fs::rename(folder_ / "registry", folder_ / "away");
    WriteBytes(folder_ / "cache" / "known.jsonl", text);
    EXPECT_THROW(Start(), MapError);
    fs::rename(folder_ / "away", folder_ / "registry");
  }
}

}  // namespace
}  // namespace waystone
