// SPDX-License-Identifier: Apache-2.0
// The coarse index of a registry as a server holds it.
#include "server/service/coarse_maps.h"

#include <gtest/gtest.h>

#include <chrono>
#include <fstream>
#include <mutex>

#include "api/json.h"
#include "core/base/error.h"
#include "registry/coarse_file.h"
#include "registry/registry.h"
#include "schema/file/map_store.h"
#include "schema/file/sha256.h"
#include "server/service/registry_maps.h"
#include "tests/registry/test_folder.h"
#include "tests/server/service/made_map.h"

namespace waystone {
namespace {

namespace fs = std::filesystem;

constexpr int kCoarsePatienceS = 20;

class CoarseMapsTest : public testing::Test {
 protected:
  CoarseMapsTest() {
    options_.registry = (folder_ / "registry").string();
    options_.cache = folder_ / "cache";
    options_.poll_s = 0.05;
    registry_ = OpenRegistry(options_.registry, NewRegistry{(folder_ / "store").string()});
  }

  MapVersion Publish(const std::string& name, int planes, bool with_entry = true,
                     const std::vector<std::string>& tags = {}) {
    MapData map = MadeMap(planes);
    map.edges.clear();  // their homologies are made up
    if (planes >= 2) AddMadePoses(map);
    const fs::path file = folder_ / "made.db";
    WriteMap(map, file, {.overwrite = true});
    const auto index = MapIndex::Build(ReadMap(file));
    const std::unique_ptr<Store> store = OpenStore(registry_->store());
    const auto bytes = static_cast<int64_t>(fs::file_size(file));
    const std::optional<CoarseFile> coarse =
        with_entry ? PutCoarseEntry(*store, *index) : std::nullopt;
    const MapVersion version = MakeVersion(name, *index, bytes, tags, coarse);
    store->Put(file, version.sha256, version.bytes);
    return registry_->Publish(version);
  }
  fs::path StoredEntry(const MapVersion& version) const {
    return folder_.path() / "store" / StorePath(TraitsOf(version).coarse->sha256);
  }

  void Start() {
    maps_.reset();
    maps_ = std::make_unique<RegistryMaps>(options_, [this](const std::string& line) {
      const std::lock_guard lock(mutex_);
      log_ += line + "\n";
    });
  }
  std::string log() {
    const std::lock_guard lock(mutex_);
    return log_;
  }
  CoarseHoldings Held() { return maps_->holdings().registry.value().coarse; }
  template <class Holds>
  bool Until(const Holds& holds) {
    for (int i = 0; i < 100 * kCoarsePatienceS && !holds(); ++i) {
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    return holds();
  }
  // What a query with those hints would ask, when not all maps can be asked at once.
  SearchScope Scope(const MapHints& hints = {}) { return maps_->ScopeOf(hints); }

  TestFolder folder_;
  RegistryMapsOptions options_;
  std::unique_ptr<Registry> registry_;
  std::mutex mutex_;
  std::string log_;
  std::unique_ptr<RegistryMaps> maps_;
};

TEST_F(CoarseMapsTest, EntriesAreHeldAndFollowTheVersions) {
  const MapVersion first = Publish("hall", 3);
  EXPECT_EQ(Publish("hall", 3).number, 1) << "the same map, tags and entry";
  options_.memory_bytes = 4 * Publish("lab", 5).bytes;  // too little for both
  Start();
  EXPECT_TRUE(Until([&] { return Held().maps == 2; }));
  EXPECT_EQ(Held().places, 4);
  EXPECT_GT(Held().bytes, 0);
  EXPECT_EQ(Held().waiting, 0);
  Publish("cellar", 4);
  EXPECT_TRUE(Until([&] { return Held().maps == 3; }));
  registry_->Retire("cellar");
  EXPECT_TRUE(Until([&] { return Held().maps == 2; }));
  EXPECT_EQ(Scope().coarse->maps().front().entry->map_version, first.sha256);
  const MapVersion second = Publish("hall", 7);
  EXPECT_TRUE(
      Until([&] { return Scope().coarse->maps().front().entry->map_version == second.sha256; }));
  EXPECT_EQ(maps_->holdings().open, 0U) << "no map is opened for it";
}

TEST_F(CoarseMapsTest, ManifestsWithoutAnEntryStayValid) {
  Publish("old", 3, false);
  Publish("new", 4);
  Start();
  EXPECT_TRUE(Until([&] { return Held().maps == 1; }));
  EXPECT_EQ(Held().without, 1);
  EXPECT_TRUE(Until([&] {
    return log().find("coarse index: maps without an entry: 1 (old)") != std::string::npos;
  }));
  EXPECT_EQ(maps_->Find("old", std::nullopt)->index().map().planes.size(), 3U);
  EXPECT_EQ(Publish("old", 3).number, 2) << "published again, it gets one";
  EXPECT_TRUE(Until([&] { return Held().maps == 2 && Held().without == 0; }));
}

TEST_F(CoarseMapsTest, DamagedAndLyingEntriesAreRefusedByName) {
  const MapVersion damaged = Publish("damaged", 3);
  Publish("good", 4);
  std::string bytes(static_cast<size_t>(fs::file_size(StoredEntry(damaged))), 'x');
  std::ofstream(StoredEntry(damaged), std::ios::binary) << bytes;
  // The right hash of wrong bytes, and the entry of another map.
  MapVersion lying = Publish("lying", 5);
  const std::string lies = "no entry at all";
  const fs::path file = folder_ / "lies";
  std::ofstream(file, std::ios::binary) << lies;
  const std::string hash =
      Sha256({reinterpret_cast<const unsigned char*>(lies.data()), lies.size()});
  const std::unique_ptr<Store> store = OpenStore(registry_->store());
  store->Put(file, hash, std::ssize(lies));
  const auto swap = [](MapVersion version, const CoarseFile& coarse) {
    Json details = Json::parse(version.details);
    details["coarse"] = {{"sha256", coarse.sha256}, {"bytes", coarse.bytes}};
    version.details = details.dump();
    return version;
  };
  registry_->Publish(swap(lying, {hash, std::ssize(lies)}));
  MapVersion foreign = Publish("foreign", 6);
  registry_->Publish(swap(foreign, *TraitsOf(lying).coarse));
  Start();
  EXPECT_TRUE(Until([&] { return Held().refused >= 3; }));
  EXPECT_TRUE(Until([&] { return Held().maps == 1; }));
  EXPECT_EQ(Held().waiting, 3);
  EXPECT_TRUE(Until([&] { return log().find("map foreign: coarse") != std::string::npos; }));
  EXPECT_NE(log().find("map damaged: coarse index: the store's file"), std::string::npos) << log();
  EXPECT_NE(log().find("SHA-256 differs"), std::string::npos) << log();
  EXPECT_NE(log().find("is not an entry of the coarse index: it doesn't begin as one"),
            std::string::npos)
      << log();
  EXPECT_NE(log().find("is the entry of another map"), std::string::npos) << log();
}

TEST_F(CoarseMapsTest, AnEntryThatWasDamagedInTheCacheIsFetchedAgain) {
  const MapVersion hall = Publish("hall", 3);
  Start();
  EXPECT_TRUE(Until([&] { return Held().maps == 1; }));
  maps_.reset();
  const CoarseFile entry = *TraitsOf(hall).coarse;
  std::ofstream(options_.cache / "coarse" / (entry.sha256.substr(7) + ".db"), std::ios::binary)
      << std::string(static_cast<size_t>(entry.bytes), 'x');
  Start();
  EXPECT_TRUE(Until([&] { return Held().maps == 1; })) << log();
  EXPECT_NE(log().find("the entry in the cache was damaged"), std::string::npos) << log();
}

TEST_F(CoarseMapsTest, EntriesBeyondTheMemoryAreLeftOut) {
  const MapVersion version = Publish("hall", 3);
  options_.memory_bytes = 4 * (4 * TraitsOf(version).coarse->bytes - 1);
  Start();
  EXPECT_TRUE(Until([&] { return Held().left_out == 1; }));
  EXPECT_EQ(Held().maps, 0);
}

TEST_F(CoarseMapsTest, FewMapsAreAllAskedAndManyAreProposed) {
  Publish("hall", 3, true, {"berlin"});
  const MapVersion lab = Publish("lab", 5, true, {"berlin", "new"});
  Publish("old", 4, false);
  Start();
  EXPECT_EQ(Scope().coarse, nullptr);
  EXPECT_EQ(Scope().names, (std::vector<std::string>{"hall", "lab", "old"}));
  options_.memory_bytes = 4 * lab.bytes;
  Start();
  EXPECT_TRUE(Until([&] { return Held().maps == 2; }));
  ASSERT_NE(Scope().coarse, nullptr);
  EXPECT_EQ(Scope().unindexed, 1);
  EXPECT_EQ(Scope().names.size(), 3U);
  MapHints hints;
  hints.tags = {"berlin"};
  EXPECT_EQ(Scope(hints).names, (std::vector<std::string>{"hall", "lab"}));
  hints.tags = {"berlin", "new"};
  EXPECT_EQ(Scope(hints).names, std::vector<std::string>{"lab"});
  EXPECT_EQ(Scope(hints).coarse, nullptr) << "one map can be asked";
  hints.previous_map = "old";
  EXPECT_EQ(Scope(hints).names, (std::vector<std::string>{"lab", "old"}));
  // Their keyframes are at (1, 2, 1.5) and (2, 2, 1.5) of the frame "hall".
  hints = {};
  hints.position = PositionHint{"hall", {1.5, 4}, 2.5};
  EXPECT_EQ(Scope(hints).names.size(), 3U);
  hints.position->radius = 1.5;
  EXPECT_THROW(Scope(hints), MapError);
  hints.position->radius = 2.5;
  hints.position->at = {1.5, 2, 9};
  EXPECT_THROW(Scope(hints), MapError) << "too far above";
  hints.position->at = {1.5, 2};
  hints.position->frame = "garden";
  EXPECT_THROW(Scope(hints), MapError);
}

TEST_F(CoarseMapsTest, LotsAreAsLargeAsTheMemory) {
  std::vector<std::string> names;
  int64_t largest = 0;
  for (int i = 0; i < 4; ++i) {
    names.push_back("map" + std::to_string(i));
    largest = std::max(largest, Publish(names.back(), 3 + i).bytes);
  }
  options_.memory_bytes = 7 * largest;
  Start();
  std::vector<FoundMap> found = maps_->FindLot(names, std::nullopt);
  EXPECT_EQ(found.size(), 2U);
  for (const FoundMap& one : found) EXPECT_EQ(one.finding, MapFinding::kFound) << one.error;
  found.clear();
  found = maps_->FindLot(std::vector<std::string>{"cellar", "map3"}, std::nullopt);
  ASSERT_EQ(found.size(), 2U);
  EXPECT_EQ(found[0].finding, MapFinding::kFailed);
  EXPECT_EQ(found[1].finding, MapFinding::kFound) << found[1].error;
  found.clear();
  options_.memory_bytes = largest;
  Start();
  found = maps_->FindLot(names, std::nullopt);
  ASSERT_EQ(found.size(), 4U);
  for (const FoundMap& one : found) {
    EXPECT_EQ(one.finding, MapFinding::kTooLarge);
    EXPECT_NE(one.error.find("of memory to open"), std::string::npos);
  }
}

}  // namespace
}  // namespace waystone
