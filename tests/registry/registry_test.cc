// SPDX-License-Identifier: Apache-2.0
// What holds of every kind of registry.
#include "registry/registry.h"

#include <gtest/gtest.h>
#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <functional>
#include <map>
#include <set>
#include <thread>

#include "api/json.h"
#include "core/base/error.h"
#include "tests/registry/postgres_server.h"
#include "tests/registry/test_folder.h"

namespace waystone {
namespace {

namespace fs = std::filesystem;

// A version of a map with a hash of its own.
MapVersion Made(const std::string& name, char digit, const std::string& tag = "") {
  const Json tags = tag.empty() ? Json::array() : Json::array({tag});
  const Json details = {{"layers", Json::array({"planes"})},
                        {"tags", tags},
                        {"summary", {{"name", name}, {"planes", 3}}}};
  return {name, 0, "sha256:" + std::string(64, digit), 1000, Dump(details)};
}

// The same with tags as an earlier program may have written them.
MapVersion Tagged(const std::vector<std::string>& tags) {
  MapVersion version = Made("lab", 'a');
  Json details = Json::parse(version.details);
  details["tags"] = tags;
  version.details = Dump(details);
  return version;
}

// By name: number of the current version, 0 for retired.
std::map<std::string, int> Current(const RegistryNews& news) {
  std::map<std::string, int> current;
  for (const MapState& state : news.changed) {
    current[state.version.name] = state.retired ? 0 : state.version.number;
  }
  return current;
}

// The next news, which come a moment after the change.
RegistryNews NextNews(Registry& registry) {
  RegistryNews news;
  for (int i = 0; i < 1000 && news.changed.empty(); ++i) {
    news = registry.Refresh();
    if (news.changed.empty()) std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  return news;
}

enum class Kind { kFolder, kPostgres };

class RegistryTest : public testing::TestWithParam<Kind> {
 protected:
  static void TearDownTestSuite() { postgres_.reset(); }

  void SetUp() override {
    if (GetParam() == Kind::kFolder) return;
    if (!PostgresServer::Programs()) {
      GTEST_SKIP() << "PostgreSQL isn't installed (apt-get install postgresql)";
    }
    if (!postgres_) postgres_ = std::make_unique<PostgresServer>();
    postgres_->Psql("DROP SCHEMA IF EXISTS waystone CASCADE");
  }
  std::string url() const {
    return GetParam() == Kind::kFolder ? (folder_ / "registry").string() : postgres_->url();
  }
  std::unique_ptr<Registry> Create() const { return OpenRegistry(url(), NewRegistry{"/a store"}); }
  std::unique_ptr<Registry> Open() const { return OpenRegistry(url()); }

  static inline std::unique_ptr<PostgresServer> postgres_;
  TestFolder folder_;
};

INSTANTIATE_TEST_SUITE_P(Kinds, RegistryTest, testing::Values(Kind::kFolder, Kind::kPostgres),
                         [](const auto& kind) {
                           return kind.param == Kind::kFolder ? "Folder" : "Postgres";
                         });

TEST_P(RegistryTest, VersionsAreNumberedAndTheLastOneIsCurrent) {
  const auto registry = Create();
  EXPECT_EQ(registry->store(), "/a store");
  EXPECT_EQ(registry->Publish(Made("lab", 'a')).number, 1);
  EXPECT_EQ(registry->Publish(Made("hall", 'b')).number, 1);
  EXPECT_EQ(registry->Publish(Made("lab", 'c')).number, 2);
  EXPECT_EQ(registry->Publish(Made("lab", 'a')).number, 3) << "an earlier file is a version too";
  const auto versions = Open()->Versions("lab");
  ASSERT_EQ(versions.size(), 3U);
  for (int i = 0; i < 3; ++i) EXPECT_EQ(versions[i].number, i + 1);
  EXPECT_EQ(versions[1].sha256, Made("lab", 'c').sha256);
  EXPECT_EQ(versions[1].details, Made("lab", 'c').details);
  const RegistryNews news = Open()->Refresh();
  EXPECT_TRUE(news.complete);
  EXPECT_TRUE(news.problems.empty());
  EXPECT_EQ(Current(news), (std::map<std::string, int>{{"hall", 1}, {"lab", 3}}));
}

TEST_P(RegistryTest, PublishingTheCurrentVersionAgainDoesNothing) {
  const auto registry = Create();
  EXPECT_EQ(registry->Publish(Made("lab", 'a')).number, 1);
  EXPECT_EQ(registry->Publish(Made("lab", 'a')).number, 1);
  EXPECT_EQ(registry->Publish(Made("lab", 'a', "tagged")).number, 2);
  registry->Retire("lab");
  EXPECT_EQ(registry->Publish(Made("lab", 'a', "tagged")).number, 3) << "serves it again";
}

TEST_P(RegistryTest, TheOrderOfTagsAndRepetitionsMakeNoVersion) {
  const auto registry = Create();
  EXPECT_EQ(registry->Publish(Tagged({"b", "a", "a"})).number, 1);
  EXPECT_EQ(registry->Publish(Tagged({"a", "b"})).number, 1);
  EXPECT_EQ(registry->Publish(Tagged({"a"})).number, 2);
}

TEST_P(RegistryTest, RollsBackAndRetires) {
  const auto registry = Create();
  for (const char digit : {'a', 'b', 'c'}) registry->Publish(Made("lab", digit));
  EXPECT_EQ(registry->Rollback("lab", std::nullopt).number, 2);
  EXPECT_EQ(registry->Rollback("lab", std::nullopt).number, 1);
  EXPECT_THROW(registry->Rollback("lab", std::nullopt), MapError);
  EXPECT_EQ(registry->Rollback("lab", 3).number, 3);
  EXPECT_THROW(registry->Rollback("lab", 4), MapError);
  EXPECT_THROW(registry->Rollback("hall", 1), MapError);
  EXPECT_THROW(registry->Retire("hall"), MapError);
  EXPECT_THROW(registry->Versions("hall"), MapError);
  registry->Retire("lab");
  EXPECT_EQ(Current(Open()->Refresh()), (std::map<std::string, int>{{"lab", 0}}));
  EXPECT_EQ(registry->Rollback("lab", std::nullopt).number, 3) << "what was current";
  EXPECT_EQ(registry->Publish(Made("lab", 'd')).number, 4);
  EXPECT_EQ(registry->Versions("lab").size(), 4U);
}

TEST_P(RegistryTest, NewsAreToldOnce) {
  const auto publisher = Create();
  const auto server = Open();
  EXPECT_TRUE(server->Refresh().changed.empty());
  publisher->Publish(Made("lab", 'a'));
  EXPECT_EQ(Current(NextNews(*server)), (std::map<std::string, int>{{"lab", 1}}));
  for (int i = 0; i < 3; ++i) EXPECT_TRUE(server->Refresh().changed.empty());
  publisher->Publish(Made("hall", 'a'));
  publisher->Publish(Made("lab", 'b'));
  std::map<std::string, int> seen;
  while (seen.size() < 2) {
    const RegistryNews news = NextNews(*server);
    ASSERT_FALSE(news.changed.empty());
    EXPECT_FALSE(news.complete);
    seen.merge(Current(news));
  }
  EXPECT_EQ(seen, (std::map<std::string, int>{{"hall", 1}, {"lab", 2}}));
  publisher->Retire("hall");
  EXPECT_EQ(Current(NextNews(*server)), (std::map<std::string, int>{{"hall", 0}}));
}

// Every change comes through, however short the time between a look and a change.
TEST_P(RegistryTest, NoChangeIsMissed) {
  const auto publisher = Create();
  const auto server = Open();
  for (int i = 0; i < 50; ++i) {
    publisher->Publish(Made("lab", "abcdef"[i % 6]));
    server->Refresh();
    publisher->Publish(Made("hall", "abcdef"[i % 6]));
    std::map<std::string, int> seen;
    for (int look = 0; look < 3 && !seen.contains("hall"); ++look) {
      seen.merge(Current(NextNews(*server)));
    }
    ASSERT_EQ(seen["hall"], i + 1);
  }
}

TEST_P(RegistryTest, PublishersAtTheSameTimeComeOneAfterTheOther) {
  constexpr int kPublishers = 4;
  constexpr int kEach = 10;
  std::atomic<int> failures = 0;
  std::vector<std::vector<int>> numbers(kPublishers);
  std::vector<std::thread> threads;
  for (int p = 0; p < kPublishers; ++p) {
    threads.emplace_back([&, p] {
      try {
        const auto registry = Create();  // one of them makes it
        for (int i = 0; i < kEach; ++i) {
          numbers[p].push_back(
              registry->Publish(Made("lab", 'a', std::to_string(p) + " " + std::to_string(i)))
                  .number);
        }
      } catch (const std::exception& error) {
        ADD_FAILURE() << error.what();
        ++failures;
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  ASSERT_EQ(failures, 0);
  std::set<int> all;
  for (const std::vector<int>& own : numbers) {
    EXPECT_TRUE(std::ranges::is_sorted(own));
    all.insert(own.begin(), own.end());
  }
  EXPECT_EQ(all.size(), static_cast<size_t>(kPublishers * kEach));
  EXPECT_EQ(*all.rbegin(), kPublishers * kEach);
  const auto versions = Open()->Versions("lab");
  EXPECT_EQ(versions.size(), all.size());
  EXPECT_EQ(Open()->Refresh().changed.at(0).version.number, kPublishers * kEach);
}

TEST_P(RegistryTest, TheIdStays) {
  const std::string id = Create()->id();
  EXPECT_EQ(id.size(), 32U);
  EXPECT_EQ(Open()->id(), id);
  EXPECT_EQ(OpenRegistry(url(), NewRegistry{"/other"})->id(), id);
  EXPECT_EQ(Open()->store(), "/a store") << "made once";
}

// ---- of folders

std::string ErrorOf(const std::function<void()>& call,
                    ErrorCode code = ErrorCode::kFileUnreadable) {
  try {
    call();
  } catch (const MapError& error) {
    EXPECT_EQ(error.code(), code) << error.what();
    return error.what();
  }
  return "";
}

class FolderRegistryTest : public testing::Test {
 protected:
  std::unique_ptr<Registry> Create() const {
    return OpenRegistry((folder_ / "registry").string(), NewRegistry{"/a store"});
  }
  std::unique_ptr<Registry> Open() const { return OpenRegistry((folder_ / "registry").string()); }

  TestFolder folder_;
};

TEST_F(FolderRegistryTest, AFolderOfAnotherFormatIsRefused) {
  Create();
  const fs::path head = folder_ / "registry" / "registry.json";
  const std::string text = ReadAll(head);
  std::string other = text;
  other.replace(other.find("\"version\":1"), 11, "\"version\":2");
  WriteBytes(head, other);
  for (const bool create : {false, true}) {
    const std::string error = ErrorOf([&] { create ? Create() : Open(); });
    EXPECT_NE(error.find("is a registry of format 2, this program knows format 1"),
              std::string::npos)
        << error;
  }
  WriteBytes(head, "{}");
  EXPECT_NE(ErrorOf([&] { Open(); }).find("is not the head of a registry"), std::string::npos);
}

TEST_F(FolderRegistryTest, AFileWhoseNumberIsNoVersionIsIgnored) {
  const std::unique_ptr<Registry> registry = Create();
  registry->Publish(Made("lab", 'a'));
  const fs::path file = folder_ / "registry" / "versions" / "lab" / "9999999999.json";
  ASSERT_TRUE(fs::exists(file.parent_path()));
  WriteBytes(file, "{}");
  EXPECT_EQ(registry->Versions("lab").size(), 1U);
  EXPECT_EQ(registry->Publish(Made("lab", 'b')).number, 2);
}

TEST_F(FolderRegistryTest, AFolderThatIsNoRegistryIsLeftAlone) {
  EXPECT_NE(ErrorOf([&] { Open(); }).find("No such file"), std::string::npos);
  fs::create_directory(folder_ / "registry");
  WriteBytes(folder_ / "registry" / "photo.jpg", "x");
  EXPECT_NE(ErrorOf([&] { Create(); }).find("has no registry.json, but other files"),
            std::string::npos);
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_ / "registry"), {}), 1) << "and no lock";
  EXPECT_NE(ErrorOf([] { OpenRegistry("ftp://x/y"); }, ErrorCode::kUsage).find("is not a registry"),
            std::string::npos);
}

// A folder that isn't mounted is no registry without maps.
TEST_F(FolderRegistryTest, AFolderThatIsGoneIsSaid) {
  const auto publisher = Create();
  publisher->Publish(Made("lab", 'a'));
  const auto server = Open();
  EXPECT_EQ(server->Refresh().changed.size(), 1U);
  fs::rename(folder_ / "registry", folder_ / "away");
  EXPECT_THROW(server->Refresh(), MapError);
  fs::create_directory(folder_ / "registry");
  EXPECT_THROW(server->Refresh(), MapError);
  fs::remove(folder_ / "registry");
  fs::rename(folder_ / "away", folder_ / "registry");
  EXPECT_TRUE(server->Refresh().changed.empty());
}

TEST_F(FolderRegistryTest, ADamagedManifestIsNamedAndTheOthersAreRead) {
  const auto publisher = Create();
  publisher->Publish(Made("lab", 'a'));
  publisher->Publish(Made("hall", 'b'));
  WriteBytes(folder_ / "registry" / "current" / "lab.json", "{\"retired\":");
  fs::copy_file(folder_ / "registry" / "current" / "hall.json",
                folder_ / "registry" / "current" / "copy.json");
  const RegistryNews news = Open()->Refresh();
  EXPECT_EQ(Current(news), (std::map<std::string, int>{{"hall", 1}}));
  ASSERT_EQ(news.problems.size(), 2U);
  EXPECT_EQ(news.problems[0].name, "copy");
  EXPECT_NE(news.problems[0].message.find("is of another map"), std::string::npos);
  EXPECT_EQ(news.problems[1].name, "lab");
}

TEST_F(FolderRegistryTest, ADamagedStateIsReplaced) {
  const auto publisher = Create();
  publisher->Publish(Made("hall", 'b'));
  const fs::path current = folder_ / "registry" / "current";
  const fs::path state = current / "lab.json";
  int number = 0;
  for (const std::string& damage :
       {std::string(), std::string("{\"retired\":"),
        std::string("{\"retired\":false,\"version\":{}}"), ReadAll(current / "hall.json")}) {
    EXPECT_EQ(publisher->Publish(Made("lab", 'a')).number, ++number);
    EXPECT_EQ(publisher->Publish(Made("lab", 'c')).number, ++number);
    WriteBytes(state, damage);
    for (const std::string& error : {ErrorOf([&] { publisher->Rollback("lab", std::nullopt); }),
                                     ErrorOf([&] { publisher->Retire("lab"); })}) {
      EXPECT_NE(error.find("; publish the map again, or make one of its versions current "
                           "(waystone rollback --version)"),
                std::string::npos)
          << error;
    }
    EXPECT_EQ(Current(Open()->Refresh()), (std::map<std::string, int>{{"hall", 1}}));
    EXPECT_EQ(publisher->Publish(Made("lab", 'c')).number, ++number) << "it isn't known as current";
    EXPECT_EQ(Current(Open()->Refresh()),
              (std::map<std::string, int>{{"hall", 1}, {"lab", number}}));
    WriteBytes(state, damage);
    EXPECT_NE(ErrorOf([&] { publisher->Rollback("lab", 99); }, ErrorCode::kNotFound)
                  .find("has no version 99"),
              std::string::npos);
    EXPECT_EQ(publisher->Rollback("lab", 2).number, 2);
    EXPECT_EQ(Current(Open()->Refresh()), (std::map<std::string, int>{{"hall", 1}, {"lab", 2}}));
  }
  EXPECT_EQ(publisher->Versions("lab").size(), static_cast<size_t>(number));
}

// Permissions, or a network that failed for a moment, leave no trace in a file's stamp.
TEST_F(FolderRegistryTest, AStateThatCouldntBeReadIsReadLater) {
  const auto publisher = Create();
  publisher->Publish(Made("lab", 'a'));
  const fs::path current = folder_ / "registry/current";
  for (const fs::path& folder : {fs::path(folder_ / "."), folder_ / "registry", current}) {
    fs::permissions(folder, fs::perms::all);
  }
  fs::permissions(current / "lab.json", fs::perms::none);
  const auto server = Open();
  constexpr uid_t kNobody = 65534;
  const bool root = geteuid() == 0;  // who may read it all the same
  if (root) {
    ASSERT_EQ(seteuid(kNobody), 0);
  }
  std::vector<RegistryNews> news;
  for (int i = 0; i < 3; ++i) news.push_back(server->Refresh());
  if (root) {
    ASSERT_EQ(seteuid(0), 0);
  }
  ASSERT_EQ(news[0].problems.size(), 1U);
  EXPECT_NE(news[0].problems[0].message.find("Permission denied"), std::string::npos);
  EXPECT_TRUE(news[1].problems.empty() && news[2].problems.empty()) << "said once";
  fs::permissions(current / "lab.json", fs::perms::owner_all);
  EXPECT_EQ(Current(server->Refresh()), (std::map<std::string, int>{{"lab", 1}}));
  EXPECT_TRUE(server->Refresh().changed.empty());
}

// What a publisher that was killed left behind.
TEST_F(FolderRegistryTest, AVersionThatNeverBecameCurrentIsCounted) {
  const auto publisher = Create();
  publisher->Publish(Made("lab", 'a'));
  const fs::path versions = folder_ / "registry" / "versions" / "lab";
  std::string text = ReadAll(versions / "1.json");
  text.replace(text.find("\"version\":1"), 11, "\"version\":2");
  WriteBytes(versions / "2.json", text);
  WriteBytes(versions / ".3.json.tmp-1-0", "{");
  EXPECT_EQ(Current(Open()->Refresh()), (std::map<std::string, int>{{"lab", 1}}));
  EXPECT_EQ(publisher->Publish(Made("lab", 'b')).number, 3);
}

// ---- of databases

class PostgresRegistryTest : public testing::Test {
 protected:
  void SetUp() override {
    if (!PostgresServer::Programs()) {
      GTEST_SKIP() << "PostgreSQL isn't installed (apt-get install postgresql)";
    }
    postgres_ = std::make_unique<PostgresServer>();
  }
  std::unique_ptr<Registry> Create() const {
    return OpenRegistry(postgres_->url(), NewRegistry{"/a store"});
  }

  std::unique_ptr<PostgresServer> postgres_;
};

TEST_F(PostgresRegistryTest, WhatIsNoRegistryIsSaid) {
  const auto open = [&] { OpenRegistry(postgres_->url()); };
  EXPECT_NE(ErrorOf(open).find("the database has no registry; publish a map to it first"),
            std::string::npos);
  const auto create = [&] { OpenRegistry(postgres_->url(), NewRegistry{}); };
  EXPECT_NE(ErrorOf(create, ErrorCode::kUsage).find("--store"), std::string::npos);
  Create();
  postgres_->Psql("UPDATE waystone.registry SET format = 2");
  EXPECT_NE(ErrorOf(open).find("is a registry of format 2, this program knows format 1"),
            std::string::npos);
  postgres_->Psql("DELETE FROM waystone.registry");
  EXPECT_NE(ErrorOf(open).find("must have one row"), std::string::npos);
  postgres_->Stop();
  const std::string error = ErrorOf(open, ErrorCode::kRegistryUnavailable);
  EXPECT_NE(error.find("the registry's database: "), std::string::npos) << error;
  EXPECT_EQ(error.find('\n'), std::string::npos);
}

TEST_F(PostgresRegistryTest, ServersAreNotified) {
  const auto publisher = Create();
  const auto server = OpenRegistry(postgres_->url());
  server->Refresh();
  const auto readable = [&](int ms) {
    pollfd watched{server->news_fd(), POLLIN, 0};
    return poll(&watched, 1, ms) == 1;
  };
  EXPECT_FALSE(readable(50));
  publisher->Publish(Made("lab", 'a'));
  EXPECT_TRUE(readable(10'000));
  EXPECT_EQ(server->Refresh().changed.size(), 1U);
  EXPECT_FALSE(readable(50));
  postgres_->Stop();
  EXPECT_TRUE(readable(10'000));
  const auto refresh = [&] { server->Refresh(); };
  std::string error;  // what the server said last comes first
  for (int i = 0; i < 3 && error.empty(); ++i) {
    error = ErrorOf(refresh, ErrorCode::kRegistryUnavailable);
  }
  EXPECT_NE(error.find("the registry's database: "), std::string::npos) << error;
}

TEST_F(PostgresRegistryTest, AServerMayOnlyRead) {
  Create()->Publish(Made("lab", 'a'));
  postgres_->Psql("CREATE ROLE reader LOGIN");
  postgres_->Psql(
      "GRANT USAGE ON SCHEMA waystone TO reader; GRANT SELECT ON ALL TABLES IN SCHEMA waystone "
      "TO reader");
  std::string url = postgres_->url();
  url.replace(url.find("user=waystone"), 13, "user=reader");
  const auto server = OpenRegistry(url);
  EXPECT_EQ(server->Refresh().changed.size(), 1U);
  EXPECT_NE(ErrorOf([&] { server->Retire("lab"); }).find("permission denied"), std::string::npos);
  EXPECT_EQ(server->Versions("lab").size(), 1U) << "the connection stays good";
}

TEST_F(PostgresRegistryTest, ARowThatIsNoVersionIsNamedAndTheOthersAreRead) {
  const auto publisher = Create();
  publisher->Publish(Made("lab", 'a'));
  publisher->Publish(Made("hall", 'b'));
  postgres_->Psql("UPDATE waystone.versions SET sha256 = 'sha256:../..' WHERE name = 'lab'");
  const RegistryNews news = OpenRegistry(postgres_->url())->Refresh();
  EXPECT_EQ(Current(news), (std::map<std::string, int>{{"hall", 1}}));
  ASSERT_EQ(news.problems.size(), 1U);
  EXPECT_EQ(news.problems[0].name, "lab");
}

}  // namespace
}  // namespace waystone
