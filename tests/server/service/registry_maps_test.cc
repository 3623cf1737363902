// SPDX-License-Identifier: Apache-2.0
// Maps of a registry as a server holds them.
#include "server/service/registry_maps.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <map>
#include <mutex>
#include <regex>
#include <set>
#include <thread>

#include "api/map_json.h"
#include "core/base/error.h"
#include "registry/store.h"
#include "schema/file/map_store.h"
#include "server/service/application.h"
#include "tests/registry/file_size_limit.h"
#include "tests/registry/test_folder.h"
#include "tests/server/service/made_map.h"
#include "tests/server/service/made_picture.h"

namespace waystone {
namespace {

namespace fs = std::filesystem;

constexpr double kPollS = 0.05;
constexpr int kPatienceS = 20;

class RegistryMapsTest : public testing::Test {
 protected:
  RegistryMapsTest() {
    options_.registry = (folder_ / "registry").string();
    options_.cache = folder_ / "cache";
    options_.poll_s = kPollS;
    registry_ = OpenRegistry(options_.registry, NewRegistry{(folder_ / "store").string()});
  }

  // Puts a map of that many planes into the store.
  MapVersion Prepare(const std::string& name, int planes) {
    MapData map = MadeMap(planes);
    map.edges.clear();  // their homologies are made up
    const fs::path file = folder_ / "made.db";
    WriteMap(map, file, {.overwrite = true});
    const auto index = MapIndex::Build(ReadMap(file));
    MapVersion version = MakeVersion(name, *index, static_cast<int64_t>(fs::file_size(file)), {});
    OpenStore(registry_->store())->Put(file, version.sha256, version.bytes);
    return version;
  }
  MapVersion Publish(const std::string& name, int planes) {
    return registry_->Publish(Prepare(name, planes));
  }
  fs::path Stored(const MapVersion& version) const {
    return folder_.path() / "store" / StorePath(version.sha256);
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
  size_t Planes(const std::string& name) {
    return maps_->Find(name, std::nullopt)->index().map().planes.size();
  }
  std::string Failure(const std::string& name, ErrorCode code = ErrorCode::kNotReady) {
    try {
      maps_->Find(name, std::nullopt);
    } catch (const MapError& error) {
      EXPECT_EQ(error.code(), code) << error.what();
      return error.what();
    }
    ADD_FAILURE() << name << " was found";
    return "";
  }
  RegistryHoldings Held() { return maps_->holdings().registry.value(); }

  bool HasLogged(const std::string& text) { return log().find(text) != std::string::npos; }
  template <class Holds>
  bool Until(const Holds& holds) {
    for (int i = 0; i < 100 * kPatienceS && !holds(); ++i) {
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    return holds();
  }

  TestFolder folder_;
  RegistryMapsOptions options_;
  std::unique_ptr<Registry> registry_;
  std::mutex mutex_;
  std::string log_;
  std::unique_ptr<RegistryMaps> maps_;
};

TEST_F(RegistryMapsTest, ARegistryThatIsNoneLeavesNoCache) {
  options_.registry = (folder_ / "nowhere").string();
  EXPECT_THROW(Start(), MapError);
  EXPECT_FALSE(fs::exists(options_.cache));
}

TEST_F(RegistryMapsTest, MapsAreOpenedWhenTheyAreAskedFor) {
  Publish("hall", 3);
  Publish("lab", 5);
  Start();
  EXPECT_EQ(maps_->Names(), (std::vector<std::string>{"hall", "lab"}));
  EXPECT_EQ(maps_->holdings().open, 0U);
  EXPECT_EQ(maps_->Summary("lab")["planes"], 5);
  EXPECT_EQ(maps_->holdings().open, 0U) << "lists open nothing";
  EXPECT_EQ(Planes("lab"), 5U);
  EXPECT_EQ(maps_->holdings().open, 1U);
  EXPECT_EQ(maps_->Summary("lab"), MapJson("lab", maps_->Find("lab", std::nullopt)->index()));
  EXPECT_EQ(Held().fetched_files, 1);
  EXPECT_EQ(maps_->FindLot(maps_->Names(), std::nullopt).size(), 2U);
  EXPECT_EQ(maps_->holdings().open, 2U);
  Failure("cellar", ErrorCode::kNotFound);
  EXPECT_THROW(maps_->CheckName("cellar"), MapError);
  EXPECT_THROW(maps_->Summary("cellar"), MapError);
}

TEST_F(RegistryMapsTest, NewVersionsTakeThePlaceOfOpenOnes) {
  const MapVersion first = Publish("lab", 3);
  Start();
  const MapSource::MapPtr under_way = maps_->Find("lab", std::nullopt);
  const MapVersion second = Publish("lab", 5);
  EXPECT_TRUE(Until([&] { return Planes("lab") == 5; }));
  EXPECT_EQ(maps_->Find("lab", std::nullopt)->version(), second.sha256);
  EXPECT_EQ(under_way->index().map().planes.size(), 3U);
  EXPECT_EQ(under_way->version(), first.sha256);
  registry_->Rollback("lab", std::nullopt);
  EXPECT_TRUE(Until([&] { return Planes("lab") == 3; }));
  EXPECT_EQ(Held().swapped, 2);
  Publish("new", 4);
  EXPECT_TRUE(Until([&] { return maps_->Names().size() == 2; }));
  EXPECT_EQ(Planes("new"), 4U);
  registry_->Retire("lab");
  EXPECT_TRUE(Until([&] { return maps_->Names().size() == 1; }));
  Failure("lab", ErrorCode::kNotFound);
  EXPECT_EQ(under_way->index().map().planes.size(), 3U) << "requests go on with what they found";
  EXPECT_NE(log().find("map lab: retired; no longer served"), std::string::npos);
}

TEST_F(RegistryMapsTest, TheLeastRecentlyUsedMapsMakeRoom) {
  std::vector<MapVersion> versions;
  for (int i = 0; i < 5; ++i) versions.push_back(Publish("map" + std::to_string(i), 3 + i));
  // Three open ones of twice their size, while one is opened with its file beside.
  const int64_t largest = versions.back().bytes;
  options_.memory_bytes = 7 * largest;
  Start();
  for (int round = 0; round < 3; ++round) {
    for (size_t i = 0; i < versions.size(); ++i) {
      EXPECT_EQ(Planes("map" + std::to_string(i)), 3 + i);
      EXPECT_LE(Held().memory_bytes, options_.memory_bytes);
      EXPECT_LE(maps_->holdings().open, 3U);
    }
  }
  EXPECT_GE(Held().closed, 10);
  EXPECT_EQ(Held().fetched_files, 5) << "the cache kept the files";
  try {
    maps_->ScopeOf({});
    ADD_FAILURE() << "more than the memory holds";
  } catch (const MapError& error) {
    EXPECT_EQ(error.code(), ErrorCode::kNotAvailable);
    EXPECT_NE(std::string(error.what()).find("name the map"), std::string::npos);
  }
}

// What requests in progress hold counts, too.
TEST_F(RegistryMapsTest, MapsInUseKeepTheirMemory) {
  const MapVersion lab = Publish("lab", 3);
  Publish("hall", 3);
  options_.memory_bytes = 3 * lab.bytes;
  Start();
  MapSource::MapPtr used = maps_->Find("lab", std::nullopt);
  const auto soon = Clock::now() + std::chrono::milliseconds(300);
  EXPECT_THROW(maps_->Find("hall", soon), MapError);
  EXPECT_EQ(Held().memory_bytes, 2 * lab.bytes);
  used = nullptr;
  EXPECT_EQ(Planes("hall"), 3U);
}

// Room is made by maps that no request uses: closing another gives nothing back yet.
TEST_F(RegistryMapsTest, MapsThatNobodyUsesMakeRoom) {
  const MapVersion lab = Publish("lab", 3);
  for (const std::string name : {"hall", "roof", "yard"}) Publish(name, 3);
  options_.memory_bytes = 7 * lab.bytes;  // two open, and one that is being opened
  Start();
  const MapSource::MapPtr used = maps_->Find("lab", std::nullopt);
  const std::shared_ptr<const MapIndex> used_too =
      maps_->Find("hall", std::nullopt)->shared_index();
  for (const std::string name : {"roof", "yard", "roof"}) {
    const auto soon = Clock::now() + std::chrono::seconds(kPatienceS / 2);
    EXPECT_TRUE(maps_->Find(name, soon)) << name;
  }
}

// What waits for memory may wait for that of a request, which then doesn't wait in turn.
TEST_F(RegistryMapsTest, ALotEndsWhereItsOwnMapsTakeTheRoom) {
  const MapVersion lab = Publish("lab", 3);
  for (const std::string name : {"hall", "roof", "yard"}) Publish(name, 3);
  options_.memory_bytes = 7 * lab.bytes;
  Start();
  std::vector<MapSource::MapPtr> used{maps_->Find("lab", std::nullopt),
                                      maps_->Find("hall", std::nullopt)};
  const std::vector<std::string> names{"roof", "yard"};
  const Clock::time_point start = Clock::now();
  std::vector<FoundMap> lot = maps_->FindLot(names, std::nullopt);
  EXPECT_LT(SecondsSince(start), kPatienceS / 2);
  ASSERT_EQ(lot.size(), 1U);
  EXPECT_TRUE(lot[0].map);
  lot.clear();
  EXPECT_TRUE(maps_->Find("yard", Clock::now() + std::chrono::seconds(kPatienceS / 2)));
}

TEST_F(RegistryMapsTest, AMapLargerThanTheMemoryIsSaidAndOthersAreServed) {
  const MapVersion small = Publish("small", 1);
  const MapVersion large = Publish("large", 100);
  options_.memory_bytes = 3 * small.bytes;
  ASSERT_GT(large.bytes, small.bytes);
  Start();
  const std::string error = Failure("large", ErrorCode::kNoRoom);
  EXPECT_NE(error.find("map 'large': takes"), std::string::npos) << error;
  EXPECT_NE(error.find("(--memory)"), std::string::npos) << error;
  EXPECT_EQ(Planes("small"), 1U);
}

TEST_F(RegistryMapsTest, WrongBytesAreRefusedAndTheVersionBeforeIsServed) {
  Publish("lab", 3);
  Publish("hall", 4);
  Start();
  EXPECT_EQ(Planes("lab"), 3U);
  const MapVersion bad = Prepare("lab", 5);
  const std::string good = ReadAll(Stored(bad));
  std::string bytes = good;
  bytes[bytes.size() / 2] ^= 1;
  WriteBytes(Stored(bad), bytes);
  registry_->Publish(bad);
  EXPECT_TRUE(Until([&] { return Held().refused > 0; }));
  EXPECT_EQ(Planes("lab"), 3U);
  EXPECT_NE(log().find("map lab: version 2: "), std::string::npos) << log();
  EXPECT_NE(log().find("; serving version 1, trying again"), std::string::npos) << log();
  EXPECT_EQ(Planes("hall"), 4U);
  WriteBytes(Stored(bad), good);
  maps_->Refresh();
  EXPECT_TRUE(Until([&] { return Planes("lab") == 5; })) << log();
}

TEST_F(RegistryMapsTest, AMapWhoseFileIsWrongIsRefusedAlone) {
  const MapVersion lab = Publish("lab", 3);
  Publish("hall", 4);
  const std::string good = ReadAll(Stored(lab));
  std::string bytes = good;
  bytes[bytes.size() / 2] ^= 1;
  WriteBytes(Stored(lab), bytes);
  Start();
  for (int i = 0; i < 3; ++i) {
    Failure("lab", ErrorCode::kStoreDamaged);
  }
  EXPECT_TRUE(Until([&] { return HasLogged("has other bytes than those that were published"); }))
      << log();
  EXPECT_EQ(Held().failed_fetches, 1) << "not tried again at once";
  EXPECT_EQ(Planes("hall"), 4U);
  WriteBytes(Stored(lab), good);
  maps_->Refresh();
  EXPECT_EQ(Planes("lab"), 3U);
}

// A version whose opening fails says nothing of one that was published meanwhile.
TEST_F(RegistryMapsTest, AVersionIsNotBlamedForTheOneBefore) {
  const MapVersion first = Publish("lab", 3);
  Start();
  // Whoever fetches from a pipe waits until somebody writes.
  fs::remove(Stored(first));
  ASSERT_EQ(mkfifo(Stored(first).c_str(), 0600), 0);
  std::thread waiting([&] { Failure("lab", ErrorCode::kStoreUnavailable); });
  const int pipe = open(Stored(first).c_str(), O_WRONLY);  // is there once the other side reads
  Publish("lab", 5);
  EXPECT_TRUE(Until([&] { return maps_->Summary("lab")["planes"] == 5; }));
  close(pipe);
  waiting.join();
  EXPECT_EQ(Planes("lab"), 5U) << "at once";
  EXPECT_FALSE(HasLogged("version 2: ")) << log();
}

// A store that hangs is waited for once, not once for each map.
TEST_F(RegistryMapsTest, MapsThatHangAreWaitedForTogether) {
  const std::vector<std::string> names = {"hall", "lab", "shop", "yard"};
  std::vector<fs::path> pipes;
  for (const std::string& name : names) {
    pipes.push_back(Stored(Publish(name, 3 + static_cast<int>(pipes.size()))));
    fs::remove(pipes.back());
    ASSERT_EQ(mkfifo(pipes.back().c_str(), 0600), 0);  // who opens it waits for a writer
  }
  options_.patience_s = 2;
  Start();
  const Clock::time_point start = Clock::now();
  const std::vector<FoundMap> found = maps_->FindLot(names, std::nullopt);
  EXPECT_LT(SecondsSince(start), 2 * options_.patience_s);
  ASSERT_EQ(found.size(), names.size());
  for (const FoundMap& one : found) EXPECT_EQ(one.finding, MapFinding::kLate) << one.name;
  for (const fs::path& pipe : pipes) {
    const int writer = open(pipe.c_str(), O_WRONLY);
    fs::remove(pipe);
    close(writer);
  }
}

// What is damaged or away takes the other maps from nobody who asks all.
TEST_F(RegistryMapsTest, AQueryOfAllMapsAsksThoseThatCanBeHad) {
  const MapVersion lab = Publish("lab", 3);
  const MapVersion hall = Publish("hall", 4);
  const std::string good = ReadAll(Stored(lab));
  std::string bytes = good;
  bytes[bytes.size() / 2] ^= 1;
  WriteBytes(Stored(lab), bytes);
  Start();
  Application application(std::shared_ptr<MapSource>(std::move(maps_)), {}, {});
  const std::vector<uint8_t> picture = MadePicture();
  const auto ask = [&] {
    HttpRequest request;
    request.method = "POST";
    request.path = "/v1/localize";
    request.header = [](const std::string&) { return std::nullopt; };
    request.read_body = [&] { return std::string(picture.begin(), picture.end()); };
    return application.Answer(request);
  };
  const HttpResponse response = ask();
  ASSERT_EQ(response.status, 200) << response.body;
  const Json answer = Json::parse(response.body);
  ASSERT_EQ(answer["searched"].size(), 2U);
  EXPECT_EQ(answer["searched"][0], Json({{"map", "hall"}, {"state", "asked"}, {"score", 0.0}}));
  EXPECT_EQ(answer["searched"][1]["map"], "lab");
  EXPECT_EQ(answer["searched"][1]["state"], "failed");
  EXPECT_NE(answer["searched"][1]["message"], "");
  EXPECT_EQ(answer["partial"], true);
  ASSERT_EQ(answer["maps"].size(), 1U);
  EXPECT_EQ(answer["maps"][0]["map"], "hall");
}

TEST_F(RegistryMapsTest, AQueryOfAllMapsFailsWhereNoneCanBeHad) {
  fs::remove(Stored(Publish("lab", 3)));
  fs::remove(Stored(Publish("hall", 4)));
  Start();
  Application application(std::shared_ptr<MapSource>(std::move(maps_)), {}, {});
  HttpRequest request;
  request.method = "POST";
  request.path = "/v1/localize";
  request.header = [](const std::string&) { return std::nullopt; };
  request.read_body = [] { return std::string("x"); };
  const HttpResponse response = application.Answer(request);
  EXPECT_EQ(response.status, 503);
  const Json problem = Json::parse(response.body);
  EXPECT_EQ(problem["code"], "store_unavailable");
  EXPECT_NE(problem["detail"].get<std::string>().find("no map can be had now (hall: "),
            std::string::npos)
      << problem;
}

// A registry that names another store, by mistake: nobody goes on with the one before unnoticed.
TEST_F(RegistryMapsTest, AStoreThatCantBeOpenedIsTriedAgain) {
  Publish("lab", 3);
  Start();
  const fs::path away = folder_ / "away";
  fs::rename(folder_ / "registry", away);
  EXPECT_TRUE(Until([&] { return !Held().connected; }));
  const fs::path head = away / "registry.json";
  const std::string good = ReadAll(head);
  std::string bad = good;
  const std::string store = (folder_ / "store").string();
  bad.replace(bad.find(store), store.size(), "ftp://elsewhere");
  WriteBytes(head, bad);
  fs::rename(away, folder_ / "registry");
  std::this_thread::sleep_for(std::chrono::milliseconds(500));  // several looks
  EXPECT_FALSE(Held().connected);
  EXPECT_FALSE(HasLogged("answers again"));
  WriteBytes(folder_ / "registry" / "registry.json", good);
  EXPECT_TRUE(Until([&] { return Held().connected; })) << log();
}

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

TEST_F(RegistryMapsTest, DeadlinesEndTheWait) {
  Publish("lab", 3);
  Start();
  try {
    maps_->Find("lab", Clock::now() - std::chrono::seconds(1));
    ADD_FAILURE() << "opened in no time";
  } catch (const MapError& error) {
    EXPECT_EQ(error.code(), ErrorCode::kNotReady);
    EXPECT_NE(std::string(error.what()).find("is being fetched and opened"), std::string::npos);
  }
  EXPECT_TRUE(Until([&] { return maps_->holdings().open == 1; })) << "it goes on";
  maps_->EndWaits();
  EXPECT_EQ(Planes("lab"), 3U);
}

// Every name that docs/http-api.md lists, and no other.
TEST_F(RegistryMapsTest, MetricsAreThoseOfTheDocumentation) {
  Publish("lab", 3);
  Start();
  Planes("lab");
  Application application(std::shared_ptr<MapSource>(std::move(maps_)), {}, {});
  HttpRequest request;
  request.method = "POST";
  request.path = "/v1/maps/lab/localize";
  request.header = [](const std::string&) { return std::nullopt; };
  const std::vector<uint8_t> picture = MadePicture();
  request.read_body = [&] { return std::string(picture.begin(), picture.end()); };
  EXPECT_EQ(application.Answer(request).status, 200);
  request.method = "GET";
  request.path = "/metrics";
  const std::string metrics = application.Answer(request).body;
  const auto names = [](const std::string& text, const std::string& pattern) {
    const std::regex regex(pattern);
    std::set<std::string> found;
    for (std::sregex_iterator it(text.begin(), text.end(), regex), end; it != end; ++it) {
      found.insert((*it)[1]);
    }
    return found;
  };
  const std::string documentation = ReadAll(WAYSTONE_SOURCE_DIR "/docs/http-api.md");
  const size_t row = documentation.find("| `/metrics` |");
  ASSERT_NE(row, std::string::npos);
  const std::set<std::string> listed =
      names(documentation.substr(row, documentation.find('\n', row) - row),
            "`((?:waystone|process)_[a-z_]+)[`{]");
  EXPECT_GT(listed.size(), 20u);
  EXPECT_EQ(names(metrics, "# TYPE ([a-z_]+) "), listed);
}

// Answers while everything changes: each from one whole version, none fails.
TEST_F(RegistryMapsTest, ManyRequestsWhileVersionsChange) {
  std::mutex mutex;
  std::map<std::string, size_t> planes_of;  // by sha256
  const auto publish = [&](int map, int planes) {
    const MapVersion version = Prepare("map" + std::to_string(map), planes);
    {
      const std::lock_guard lock(mutex);
      planes_of[version.sha256] = planes;
    }
    return registry_->Publish(version);
  };
  for (int i = 0; i < 4; ++i) options_.memory_bytes = 9 * publish(i, 3).bytes;  // not for all
  Start();
  std::atomic<bool> stop = false;
  std::atomic<int> answers = 0;
  std::vector<std::thread> clients;
  for (int c = 0; c < 3; ++c) {
    clients.emplace_back([&, c] {
      for (int i = 0; !stop; ++i) {
        try {
          const auto map = maps_->Find("map" + std::to_string((c + i) % 4), std::nullopt);
          const std::lock_guard lock(mutex);
          EXPECT_EQ(map->index().map().planes.size(), planes_of.at(map->version()));
          ++answers;
        } catch (const std::exception& error) {
          ADD_FAILURE() << error.what();
        }
      }
    });
  }
  for (int round = 0; round < 5; ++round) {
    for (int i = 0; i < 4; ++i) publish(i, 3 + (round + 1) % 2);
    const int before = answers;
    EXPECT_TRUE(Until([&] { return answers >= before + 20; }));
  }
  stop = true;
  for (std::thread& client : clients) client.join();
  EXPECT_LE(Held().memory_bytes, options_.memory_bytes);
  EXPECT_GT(Held().swapped, 0);
}

}  // namespace
}  // namespace waystone
