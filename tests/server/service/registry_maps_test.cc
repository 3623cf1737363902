// SPDX-License-Identifier: Apache-2.0
// Maps of a registry as a server holds them.
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
#include "server/service/application.h"
#include "tests/server/service/made_picture.h"
#include "tests/server/service/registry_maps_fixture.h"

namespace waystone {
namespace {

namespace fs = std::filesystem;

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
  // The log has its line after the count.
  EXPECT_TRUE(Until([&] { return HasLogged("map lab: version 2: "); })) << log();
  EXPECT_GT(Held().refused, 0);
  EXPECT_EQ(Planes("lab"), 3U);
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
