// SPDX-License-Identifier: Apache-2.0
// Workers without threads, and without a database when they are told to end.
#include "cli/commands/job_worker.h"

#include <gtest/gtest.h>
#include <signal.h>
#include <unistd.h>

#include <filesystem>
#include <iostream>
#include <stdexcept>
#include <string>
#include <thread>

#include "api/json.h"
#include "cli/commands/lease_keeper.h"
#include "cli/system/signals.h"
#include "core/base/error.h"
#include "registry/registry.h"
#include "schema/file/map_store.h"
#include "schema/file/sha256.h"
#include "tests/registry/postgres_server.h"
#include "tests/registry/test_folder.h"
#include "tests/server/http/no_threads.h"
#include "tests/server/service/made_map.h"

namespace waystone {
namespace {

namespace fs = std::filesystem;

constexpr double kLongLeaseS = 600;

JobSpec SpecOfLab() {
  JobSpec spec;
  spec.name = "lab";
  spec.sources = {"/data/walk"};
  spec.max_attempts = 1;
  return spec;
}

WorkerOptions OptionsIn(const fs::path& folder, const std::string& registry) {
  WorkerOptions options;
  options.registry = registry;
  options.work = folder / "work";
  return options;
}

// SQL that waits for a session like that.
std::string UntilASession(const std::string& condition) {
  return "DO $$ BEGIN WHILE NOT EXISTS (SELECT FROM pg_stat_activity WHERE " + condition +
         ") LOOP PERFORM pg_sleep(0.02); PERFORM pg_stat_clear_snapshot(); END LOOP; END $$";
}

class JobWorkerDeathTest : public testing::Test {
 protected:
  void SetUp() override {
    if (!PostgresServer::Programs()) {
      GTEST_SKIP() << "PostgreSQL isn't installed (apt-get install postgresql)";
    }
  }

  // A job whose only part is built, for a worker that gets SIGTERM while it publishes and whose
  // database is away from then on. Ends the process with the worker's status.
  [[noreturn]] static void PublishWithoutDatabase(const fs::path& folder) {
    NoteInterrupts();
    int status = -1;
    {
      PostgresServer postgres;
      EnqueueBuilt(postgres.url(), folder);
      std::thread holder([&postgres] {
        try {
          postgres.Psql("BEGIN; SELECT * FROM waystone.registry FOR UPDATE; SELECT pg_sleep(600)");
        } catch (const std::runtime_error&) {  // the database was stopped
        }
      });
      postgres.Psql(UntilASession("wait_event = 'PgSleep' AND query LIKE 'BEGIN; SELECT%'"));
      std::thread interrupter([&postgres] {
        postgres.Psql(
            UntilASession("wait_event_type = 'Lock' AND query LIKE 'UPDATE waystone.registry%'"));
        kill(getpid(), SIGTERM);
        postgres.Stop();
      });
      JobWorker worker(OptionsIn(folder, postgres.url()),
                       [](const std::string& line) { std::cerr << line + "\n"; });
      status = worker.Run();
      interrupter.join();
      holder.join();
    }
    _exit(status);
  }

  static void EnqueueBuilt(const std::string& registry, const fs::path& folder) {
    const fs::path map = folder / "map.db";
    const std::string store = (folder / "store").string();
    OpenRegistry(registry, NewRegistry{store});
    JobQueue queue(registry, true);
    queue.Enqueue(SpecOfLab());
    queue.FinishPlan(queue.Claim("a:1", kLongLeaseS).value(), {JobPart{.frames = 100}});
    const std::string sha256 = Sha256OfFile(map);
    const auto bytes = static_cast<int64_t>(fs::file_size(map));
    OpenStore(store)->Put(map, sha256, bytes);
    queue.FinishPart(queue.Claim("a:1", kLongLeaseS).value(), sha256, bytes);
  }

  TestFolder folder_;
};

TEST_F(JobWorkerDeathTest, AnInterruptWithoutTheDatabaseKeepsWhatIsBuilt) {
  MapData map = MadeMap(3);
  map.edges.clear();  // their homologies are made up
  WriteMap(map, folder_ / "map.db", {.overwrite = true});
  EXPECT_EXIT(PublishWithoutDatabase(folder_.path()), testing::ExitedWithCode(0),
              "join: not given back, as the database is away");
  const std::string digits = Sha256OfFile(folder_ / "map.db").substr(std::string("sha256:").size());
  EXPECT_TRUE(fs::exists(folder_.path() / "work/parts" / (digits + ".db")));
}

TEST_F(JobWorkerDeathTest, AThreadThatCannotBeStartedEndsTheAttempt) {
  const PostgresServer postgres;
  OpenRegistry(postgres.url(), NewRegistry{(folder_ / "store").string()});
  JobQueue queue(postgres.url(), true);
  const int64_t job = queue.Enqueue(SpecOfLab());
  WorkerOptions options = OptionsIn(folder_.path(), postgres.url());
  options.one_job = true;
  JobWorker worker(options, [](const std::string&) {});
  {
    const NoThreads none;
    EXPECT_EQ(worker.Run(), 4) << "no map";
  }
  EXPECT_EQ(queue.StateOf(job), "failed");
  EXPECT_NE(Dump(queue.Describe(job)).find("cannot start a thread ("), std::string::npos);
}

TEST(LeaseKeepers, AThreadThatCannotBeStartedIsSaid) {
  LeaseKeeper keeper("postgresql:///none", {}, kLongLeaseS, [](const std::string&) {});
  const NoThreads none;
  try {
    keeper.Start();
    FAIL() << "started";
  } catch (const MapError& error) {
    EXPECT_EQ(error.code(), ErrorCode::kOutOfMemory);
    EXPECT_TRUE(std::string(error.what()).starts_with("cannot start a thread (")) << error.what();
  }
}

}  // namespace
}  // namespace waystone
