// SPDX-License-Identifier: Apache-2.0
// Maps that workers of the real program build for a registry, some of them killed or paused.
#include <gtest/gtest.h>

#include <cctype>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "api/json.h"
#include "cli/system/child_process.h"
#include "schema/file/sha256.h"
#include "tests/e2e/registry_server.h"
#include "tests/e2e/served_map.h"
#include "tests/e2e/shared_map.h"
#include "tests/registry/postgres_server.h"

namespace waystone {
namespace {

namespace fs = std::filesystem;

// A stretch of the walk around the photo, in one part and in three.
const std::vector<std::string> kShort = {"--from", "14", "--to", "26"};
const std::vector<std::string> kCut = {"--from", "8", "--to", "47", "--part-frames", "24"};

class JobsE2e : public testing::Test {
 protected:
  static void TearDownTestSuite() { postgres_.reset(); }

  void SetUp() override {
    if (!PostgresServer::Programs()) {
      GTEST_SKIP() << "PostgreSQL isn't installed (apt-get install postgresql)";
    }
    if (!postgres_) postgres_ = std::make_unique<PostgresServer>();
    postgres_->Psql("DROP SCHEMA IF EXISTS waystone CASCADE");
  }
  ~JobsE2e() override { fs::remove_all(folder_); }

  static std::string Url() { return postgres_->url(); }

  std::vector<std::string> Enqueuing(const std::vector<std::string>& flags,
                                     const std::string& source = TheMap().images) const {
    std::vector<std::string> arguments = {"enqueue",    source, "--name",  "lab",
                                          "--registry", Url(),  "--store", folder_ / "store"};
    arguments.insert(arguments.end(), flags.begin(), flags.end());
    return arguments;
  }
  // Returns the job.
  int64_t Enqueue(const std::vector<std::string>& flags,
                  const std::string& source = TheMap().images) const {
    std::vector<std::string> arguments = Enqueuing(flags, source);
    arguments.emplace_back("--json");
    const RunResult result = RunWaystone(arguments);
    EXPECT_EQ(result.code, 0) << result.err;
    return Json::parse(result.out)["id"];
  }
  // A short lease is that of a worker which shall lose it.
  static std::vector<std::string> Working(const std::vector<std::string>& flags,
                                          const std::string& lease_s = "60") {
    std::vector<std::string> arguments = {"work",  "--registry",    Url(), "--lease",
                                          lease_s, "--retry-after", "0.1"};
    arguments.insert(arguments.end(), flags.begin(), flags.end());
    return arguments;
  }
  static std::unique_ptr<ChildProcess> StartWorker(const std::vector<std::string>& flags = {},
                                                   const std::string& lease_s = "60") {
    std::vector<std::string> arguments = Working(flags, lease_s);
    arguments.insert(arguments.begin(), WAYSTONE_PROGRAM);
    return std::make_unique<ChildProcess>(arguments, true);
  }
  static void WorkUntilEmpty() {
    const RunResult result = RunWaystone(Working({"--until-empty"}));
    EXPECT_EQ(result.code, 0) << result.err;
  }
  static Json Job(int64_t job) {
    const RunResult result = RunWaystone({"jobs", Url(), "--job", std::to_string(job), "--json"});
    EXPECT_EQ(result.code, 0) << result.err;
    return Json::parse(result.out);
  }
  // The first cell of a query's answer.
  static std::string Ask(const std::string& sql) {
    const fs::path psql = *PostgresServer::Programs() / "psql";
    const std::string command = psql.string() + " '" + Url() + "' -qtA -c \"" + sql + "\"";
    FILE* out = popen(command.c_str(), "r");  // NOLINT(cert-env33-c): made of our own words
    std::string text;
    for (int c = std::fgetc(out); c != EOF; c = std::fgetc(out)) text += static_cast<char>(c);
    pclose(out);
    return text.substr(0, text.find('\n'));
  }
  // A transaction that holds a lock until it is ended.
  static std::unique_ptr<ChildProcess> Hold(const std::string& sql) {
    const fs::path psql = *PostgresServer::Programs() / "psql";
    auto held = std::make_unique<ChildProcess>(
        std::vector<std::string>{psql, Url(), "-qtA", "-c",
                                 "BEGIN; " + sql + "; SELECT pg_sleep(300)"},
        true);
    EXPECT_TRUE(Until([] {
      return Ask("SELECT count(*) FROM pg_stat_activity WHERE query LIKE '%pg_sleep(300)%' AND "
                 "wait_event = 'PgSleep'") == "1";
    }));
    return held;
  }
  static void LetGo(std::unique_ptr<ChildProcess> held) {
    held.reset();
    Ask("SELECT pg_terminate_backend(pid) FROM pg_stat_activity WHERE wait_event = 'PgSleep'");
  }
  static bool Leased(const std::string& kind) {
    return Ask("SELECT count(*) FROM waystone.job_steps WHERE state = 'leased' AND kind = '" +
               kind + "'") != "0";
  }
  // What everything ends with: a map that answers, published once.
  void ExpectPublishedOnce(int64_t job) const {
    const Json done = Job(job);
    EXPECT_EQ(done["state"], "done") << done;
    EXPECT_EQ(done["version"], 1);
    EXPECT_EQ(done["frames_done"], done["frames"]);
    EXPECT_EQ(Ask("SELECT count(*) FROM waystone.versions"), "1");
    const std::string sha256 = done["steps"].back()["sha256"];
    const std::string digits = sha256.substr(sha256.find(':') + 1);
    const fs::path map = folder_ / "store" / digits.substr(0, 2) / (digits + ".db");
    EXPECT_EQ(Sha256OfFile(map), sha256);
    const Json answer = Json::parse(RunWaystone({"localize", map, TheMap().inside, "--json"}).out);
    EXPECT_EQ(answer["verdict"], "localized") << answer;
  }
  static int CountOutcomes(const Json& job, const std::string& outcome) {
    int count = 0;
    for (const Json& attempt : job["history"]) count += attempt["outcome"] == outcome;
    return count;
  }

  static inline std::unique_ptr<PostgresServer> postgres_;
  const fs::path folder_ = FreshFolder();
};

std::vector<std::string> HashesOf(const Json& job) {
  std::vector<std::string> hashes;
  for (const Json& step : job["steps"]) {
    hashes.push_back(step["sha256"].is_null() ? "" : step["sha256"].get<std::string>());
  }
  return hashes;
}

TEST_F(JobsE2e, AShortWalkGivesTheMapOfBuild) {
  const int64_t job = Enqueue(kShort);
  WorkUntilEmpty();
  ExpectPublishedOnce(job);
  std::vector<std::string> build = {"build", TheMap().images, "-o", folder_ / "lab.db", "--quiet"};
  build.insert(build.end(), kShort.begin(), kShort.end());
  EXPECT_EQ(RunWaystone(build).code, 0);
  EXPECT_EQ(HashesOf(Job(job)).back(), Sha256OfFile(folder_ / "lab.db"));
  EXPECT_EQ(Job(job)["parts"], 1);
}

TEST_F(JobsE2e, TwoWorkersBuildWhatOneBuilds) {
  const int64_t by_one = Enqueue(kCut);
  WorkUntilEmpty();
  ExpectPublishedOnce(by_one);
  EXPECT_EQ(Job(by_one)["parts"], 3);
  const int64_t by_two = Enqueue(kCut);
  const auto a = StartWorker({"--until-empty", "--threads", "1"});
  const auto b = StartWorker({"--until-empty", "--threads", "1"});
  EXPECT_EQ(a->Wait(), 0);
  EXPECT_EQ(b->Wait(), 0);
  ExpectPublishedOnce(by_two);
  EXPECT_EQ(HashesOf(Job(by_two)), HashesOf(Job(by_one)));
  EXPECT_EQ(CountOutcomes(Job(by_two), "done"), 5) << "nothing is built twice";
}

TEST_F(JobsE2e, AWorkerThatIsKilledWhileItBuildsLosesNothing) {
  const int64_t job = Enqueue(kShort);
  const auto killed = StartWorker({}, "1");
  ASSERT_TRUE(Until([] { return Leased("part"); }));
  killed->Send(SIGKILL);
  killed->Wait();
  WorkUntilEmpty();
  ExpectPublishedOnce(job);
  EXPECT_EQ(CountOutcomes(Job(job), "expired"), 1);
}

// It has put the part into the store, and the database doesn't know of that yet.
TEST_F(JobsE2e, AWorkerThatIsKilledAfterStoringLosesNothing) {
  const int64_t job = Enqueue(kShort);
  const auto killed = StartWorker({}, "1");
  ASSERT_TRUE(Until([] { return Leased("part"); }));
  auto held = Hold("SELECT id FROM waystone.jobs FOR UPDATE");
  EXPECT_TRUE(Until([] {
    return Ask("SELECT count(*) FROM pg_stat_activity WHERE wait_event_type = 'Lock' AND query "
               "LIKE 'SELECT state FROM waystone.jobs%'") == "1";
  }));
  EXPECT_FALSE(fs::is_empty(folder_ / "store"));
  killed->Send(SIGKILL);
  killed->Wait();
  LetGo(std::move(held));
  WorkUntilEmpty();
  ExpectPublishedOnce(job);
}

// It is in the middle of the transaction that publishes the map and ends the job.
TEST_F(JobsE2e, AWorkerThatIsKilledWhilePublishingPublishesOnce) {
  const int64_t job = Enqueue(kShort);
  auto held = Hold("SELECT id FROM waystone.registry FOR UPDATE");
  const auto killed = StartWorker({}, "1");
  EXPECT_TRUE(Until([] {
    return Ask("SELECT count(*) FROM pg_stat_activity WHERE wait_event_type = 'Lock' AND query "
               "LIKE 'UPDATE waystone.registry%'") == "1";
  }));
  killed->Send(SIGKILL);
  killed->Wait();
  LetGo(std::move(held));
  WorkUntilEmpty();
  ExpectPublishedOnce(job);
  EXPECT_EQ(CountOutcomes(Job(job), "expired"), 1);
}

TEST_F(JobsE2e, APausedWorkerDoesNotPublish) {
  const int64_t job = Enqueue(kShort);
  const auto paused = StartWorker({"--once"}, "1");
  ASSERT_TRUE(Until([] { return Leased("part"); }));
  paused->Send(SIGSTOP);
  WorkUntilEmpty();  // which waits until the lease has expired
  ExpectPublishedOnce(job);
  const Json before = Job(job);
  paused->Send(SIGCONT);
  EXPECT_EQ(paused->Wait(), 0) << "the job is done";
  EXPECT_EQ(Job(job), before);
  EXPECT_EQ(CountOutcomes(before, "expired"), 1);
}

TEST_F(JobsE2e, AStoppedWorkerGivesItsStepBack) {
  const int64_t job = Enqueue(kCut);
  const auto stopped = StartWorker();
  ASSERT_TRUE(Until([] { return Leased("part"); }));
  stopped->Send(SIGTERM);
  EXPECT_EQ(stopped->Wait(), 0);
  EXPECT_EQ(Job(job)["state"], "running");
  EXPECT_TRUE(Job(job)["workers"].empty());
  EXPECT_LE(CountOutcomes(Job(job), "released"), 1) << "it may have ended just then";
  EXPECT_EQ(CountOutcomes(Job(job), "expired"), 0);
  EXPECT_EQ(RunWaystone({"jobs", Url(), "--cancel", std::to_string(job)}).code, 0);
  EXPECT_EQ(RunWaystone(Working({"--until-empty"})).code, 0);
  EXPECT_EQ(Job(job)["state"], "cancelled");
}

TEST_F(JobsE2e, AWorkerGoesOnWithoutTheDatabase) {
  const int64_t job = Enqueue(kShort);
  const auto worker = StartWorker({"--once"});
  ASSERT_TRUE(Until([] { return Leased("part"); }));
  postgres_->Stop();
  // The map is built and stored meanwhile.
  EXPECT_TRUE(Until([&] { return fs::exists(folder_ / "store"); }));
  postgres_->Start();
  EXPECT_EQ(worker->Wait(), 0);
  ExpectPublishedOnce(job);
}

TEST_F(JobsE2e, BadSourcesFailAtOnceAndBadOptionsAreRefused) {
  const int64_t job = Enqueue({}, folder_ / "nowhere");
  EXPECT_EQ(RunWaystone(Working({"--once"})).code, 4);
  const Json failed = Job(job);
  EXPECT_EQ(failed["state"], "failed");
  EXPECT_EQ(failed["attempts"], 1);
  EXPECT_NE(failed["reason"].get<std::string>().find("does not exist; check the path"),
            std::string::npos);
  const std::string list = RunWaystone({"jobs", Url()}).out;
  EXPECT_NE(list.find("lab  failed"), std::string::npos) << list;
  EXPECT_NE(RunWaystone({"jobs", Url(), "--job", "1"}).out.find("plan failed: "),
            std::string::npos);
  EXPECT_EQ(RunWaystone({"jobs", Url(), "--retry", "1"}).code, 0);
  EXPECT_EQ(Job(job)["state"], "queued");
  const auto refused = [&](const std::vector<std::string>& arguments, int code,
                           const std::string& said) {
    const RunResult result = RunWaystone(arguments);
    EXPECT_EQ(result.code, code) << result.err;
    EXPECT_NE(result.err.find(said), std::string::npos) << result.err;
    EXPECT_EQ(result.err.find('\n'), result.err.size() - 1) << "one line: " << result.err;
  };
  refused(Enqueuing({"--set", "nonsense=1"}), 2, "there is no option 'nonsense'");
  refused(Enqueuing({"--features", "surf"}), 2, "surf");
  refused(Enqueuing({"--every", "0"}), 2, "every");
  refused(Enqueuing({"--part-frames", "3"}), 2, "--part-frames is 3");
  refused(Enqueuing({"--attempts", "0"}), 2, "--attempts is 0");
  refused({"enqueue", "walk", "--name", "lab", "--registry", folder_}, 2, "PostgreSQL");
  refused({"work", "--registry", folder_}, 2, "PostgreSQL");
  refused({"jobs", folder_}, 2, "PostgreSQL");
  refused({"jobs", Url(), "--job", "4711"}, 3, "no job 4711");
  postgres_->Psql("DROP SCHEMA waystone CASCADE");
  refused({"enqueue", "walk", "--name", "lab", "--registry", Url()}, 2, "needs a store");
}

TEST_F(JobsE2e, ServersTellOfJobs) {
  Enqueue(kShort);
  Enqueue({}, folder_ / "nowhere");
  WorkUntilEmpty();
  Enqueue(kCut);
  const RegistryServer served(Url(), folder_ / "cache");
  const Json jobs = served.Get("/v1/jobs")["jobs"];
  ASSERT_EQ(jobs.size(), 3u);
  EXPECT_EQ(jobs[0]["state"], "queued");
  EXPECT_EQ(jobs[1]["state"], "failed");
  EXPECT_EQ(jobs[2]["state"], "done");
  const Json first = served.Get("/v1/jobs?limit=1");
  Enqueue(kShort);
  EXPECT_TRUE(Until([&] { return served.Get("/v1/jobs")["jobs"].size() == 4; }));
  const Json second = served.Get("/v1/jobs?cursor=" + first["next"].get<std::string>());
  ASSERT_EQ(second["jobs"].size(), 2u) << "none twice, and not the new one";
  EXPECT_EQ(second["jobs"][0]["id"], jobs[1]["id"]);
  EXPECT_EQ(served.Status("/v1/jobs?cursor=r1"), 400);
  EXPECT_EQ(served.Status("/v1/jobs/99"), 404);
  EXPECT_EQ(served.Status("/v1/jobs/x"), 404);
  const std::string command = "/usr/bin/python3 " WAYSTONE_SOURCE_DIR
                              "/tests/e2e/jobs_contract.py http://" +
                              served.address() + " " WAYSTONE_SOURCE_DIR "/clients/openapi.yaml";
  EXPECT_EQ(std::system(command.c_str()), 0);  // NOLINT(cert-env33-c): made of our own words
  const Served plain;
  EXPECT_EQ(Json::parse(Checked(plain.NewClient().Get("/v1/jobs"))->body)["code"], "not_available");
}

}  // namespace
}  // namespace waystone
