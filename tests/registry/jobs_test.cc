// SPDX-License-Identifier: Apache-2.0
// Jobs: how walks are cut, and the queue in a real PostgreSQL.
#include <gtest/gtest.h>

#include <chrono>
#include <functional>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "core/base/error.h"
#include "registry/job_queue.h"
#include "registry/registry.h"
#include "tests/registry/postgres_server.h"
#include "tests/registry/test_folder.h"

namespace waystone {
namespace {

constexpr double kLongS = 600;  // a lease that doesn't end during a test

std::string MessageOf(ErrorCode code, const std::function<void()>& act) {
  try {
    act();
  } catch (const MapError& error) {
    EXPECT_EQ(error.code(), code) << error.what();
    return error.what();
  }
  return "";
}

JobSpec Spec(const std::string& name) {
  JobSpec spec;
  spec.name = name;
  spec.sources = {"/data/walk one", "/data/ü"};
  spec.options = {"--every=2"};
  spec.tags = {"berlin"};
  return spec;
}

TEST(JobParts, CoverAllFramesAndOverlap) {
  for (const int frames : {1, 20, 100, 101, 109, 110, 111, 190, 191, 999, 5432}) {
    for (const int part_frames : {20, 100, 3000}) {
      const int overlap = OverlapFrames(part_frames);
      const std::vector<JobPart> parts = CutIntoParts(3, frames, 7, 5, part_frames);
      ASSERT_FALSE(parts.empty());
      EXPECT_EQ(parts.size() == 1, frames <= part_frames);
      EXPECT_EQ(parts.front().from, 7);
      EXPECT_EQ(parts.back().to, -1) << "up to the end, whose number may be an estimate";
      for (size_t i = 0; i < parts.size(); ++i) {
        EXPECT_EQ(parts[i].source, 3);
        EXPECT_LE(parts[i].frames, part_frames);
        EXPECT_EQ((parts[i].from - 7) % 5, 0);
        const int last = i + 1 == parts.size() ? 7 + 5 * (frames - 1) : parts[i].to;
        EXPECT_EQ(last - parts[i].from, 5 * (parts[i].frames - 1));
        if (i == 0) continue;
        EXPECT_EQ(parts[i - 1].to - parts[i].from, 5 * (overlap - 1));
        EXPECT_GT(parts[i].frames, overlap) << "something new in each";
      }
    }
  }
}

TEST(JobSpecs, ComeBackAsTheyWereAndBadOnesAreRefused) {
  EXPECT_EQ(ReadJobSpec("lab", TextOf(Spec("lab"))), Spec("lab"));
  JobSpec tagged = Spec("lab");
  tagged.tags = {"b", "a", "b"};
  EXPECT_EQ(ReadJobSpec("lab", TextOf(tagged)).tags, (std::vector<std::string>{"a", "b"}));
  const auto refused = [](const std::function<void(JobSpec&)>& spoil) {
    JobSpec spec = Spec("lab");
    spoil(spec);
    return MessageOf(ErrorCode::kUsage, [&] { CheckJobSpec(spec); });
  };
  EXPECT_NE(refused([](JobSpec& spec) { spec.name = "a/b"; }), "");
  EXPECT_NE(refused([](JobSpec& spec) { spec.tags = {"a\nb"}; }), "");
  EXPECT_NE(refused([](JobSpec& spec) { spec.sources.clear(); }), "");
  EXPECT_NE(refused([](JobSpec& spec) { spec.sources = {"/data/\xff"}; }), "");
  EXPECT_EQ(refused([](JobSpec& spec) { spec.part_frames = 5; }),
            "--part-frames is 5; it must be between 20 and 1000000");
  EXPECT_NE(refused([](JobSpec& spec) { spec.max_attempts = 0; }), "");
  for (const char* text : {"", "[]", "{}", R"({"sources":[1]})"}) {
    EXPECT_NE(MessageOf(ErrorCode::kFileUnreadable, [&] { ReadJobSpec("lab", text); }), "");
  }
}

TEST(JobQueues, FoldersHaveNone) {
  EXPECT_EQ(MessageOf(ErrorCode::kUsage, [] { JobQueue("/srv/maps", true); }),
            "'/srv/maps' has no jobs; they need a registry in PostgreSQL (postgresql://...)");
}

class JobQueueTest : public testing::Test {
 protected:
  static void TearDownTestSuite() { postgres_.reset(); }

  void SetUp() override {
    if (!PostgresServer::Programs()) {
      GTEST_SKIP() << "PostgreSQL isn't installed (apt-get install postgresql)";
    }
    if (!postgres_) postgres_ = std::make_unique<PostgresServer>();
    postgres_->Psql("DROP SCHEMA IF EXISTS waystone CASCADE");
    OpenRegistry(postgres_->url(), NewRegistry{"/store"});
    queue_ = Open();
  }

  static std::unique_ptr<JobQueue> Open() {
    return std::make_unique<JobQueue>(postgres_->url(), true);
  }
  static MapVersion Version(const std::string& name) {
    return {name, 0, "sha256:" + std::string(64, 'a'), 10,
            R"({"schema_version":6,"feature_type":"sift","layers":[],"places":[],"bounds":null,)"
            R"("tags":[],"published_at":"","publisher":"","summary":{}})"};
  }
  // Planned with this number of parts, of 100 frames each.
  int64_t Planned(int parts) const {
    const int64_t job = queue_->Enqueue(Spec("lab"));
    const auto plan = queue_->Claim("a:1", kLongS, job);
    std::vector<JobPart> list;
    for (int i = 0; i < parts; ++i) list.push_back({0, 90 * i, 90 * i + 99, 100});
    EXPECT_TRUE(queue_->FinishPlan(plan.value(), list));
    return job;
  }
  // Ends the time of all leases.
  static void Expire() {
    postgres_->Psql("UPDATE waystone.job_steps SET lease_until = '-infinity'");
  }
  std::string State(int64_t job) const { return queue_->StateOf(job); }
  std::string Reason(int64_t job) const {
    const Json reason = queue_->Describe(job)["reason"];
    return reason.is_null() ? "" : reason.get<std::string>();
  }

  static inline std::unique_ptr<PostgresServer> postgres_;
  std::unique_ptr<JobQueue> queue_;
};

TEST_F(JobQueueTest, AJobGoesThroughItsStepsOnce) {
  const int64_t job = queue_->Enqueue(Spec("lab"));
  EXPECT_EQ(State(job), "queued");
  const auto plan = queue_->Claim("a:1", kLongS);
  ASSERT_TRUE(plan);
  EXPECT_EQ(plan->job, job);
  EXPECT_EQ(plan->kind, StepKind::kPlan);
  EXPECT_EQ(plan->spec, Spec("lab"));
  EXPECT_EQ(State(job), "running");
  EXPECT_FALSE(Open()->Claim("b:2", kLongS)) << "the one step is taken";
  const std::vector<JobPart> parts{{0, 0, 99, 100}, {0, 90, -1, 80}};
  EXPECT_TRUE(queue_->FinishPlan(*plan, parts));
  EXPECT_TRUE(queue_->FinishPlan(*plan, parts)) << "an answer may be lost";
  const auto one = queue_->Claim("a:1", kLongS);
  const auto two = Open()->Claim("b:2", kLongS);
  ASSERT_TRUE(one && two);
  EXPECT_EQ(one->part, parts[0]);
  EXPECT_EQ(two->part, parts[1]);
  EXPECT_EQ(two->parts, 2);
  EXPECT_TRUE(queue_->Renew(*one, kLongS, {"frames", 40, 100, 40}));
  EXPECT_TRUE(queue_->FinishPart(*two, "sha256:2", 22));
  EXPECT_FALSE(queue_->Claim("b:2", kLongS)) << "joining waits for both";
  EXPECT_EQ(queue_->List(10).at(0)["frames_done"], 120);
  EXPECT_EQ(queue_->List(10).at(0)["workers"][0]["stage"], "frames");
  EXPECT_TRUE(queue_->FinishPart(*one, "sha256:1", 11));
  EXPECT_TRUE(queue_->FinishPart(*one, "sha256:1", 11));
  const auto join = queue_->Claim("b:2", kLongS);
  ASSERT_TRUE(join);
  EXPECT_EQ(join->kind, StepKind::kJoin);
  const std::vector<BuiltPart> built = queue_->Parts(job);
  ASSERT_EQ(built.size(), 2u);
  EXPECT_EQ(built[1].sha256, "sha256:2");
  EXPECT_EQ(queue_->FinishJoin(*join, Version("lab"))->number, 1);
  EXPECT_EQ(queue_->FinishJoin(*join, Version("lab"))->number, 1) << "published once";
  EXPECT_EQ(OpenRegistry(postgres_->url())->Versions("lab").size(), 1u);
  EXPECT_EQ(State(job), "done");
  EXPECT_EQ(queue_->CountOpen(), 0);
  EXPECT_FALSE(queue_->Claim("a:1", kLongS));
  const Json details = queue_->Describe(job);
  EXPECT_EQ(details["version"], 1);
  EXPECT_EQ(details["history"].size(), 4u);
  EXPECT_EQ(details["log"].back()["message"], "done");
}

TEST_F(JobQueueTest, WhoLostALeaseChangesNothing) {
  const int64_t job = Planned(1);
  const auto paused = queue_->Claim("a:1", kLongS);
  Expire();
  const auto next = queue_->Claim("b:2", kLongS);
  ASSERT_TRUE(paused && next);
  EXPECT_EQ(next->step, paused->step);
  EXPECT_FALSE(queue_->Renew(*paused, kLongS, {}));
  EXPECT_FALSE(queue_->FinishPart(*paused, "sha256:1", 1));
  EXPECT_FALSE(queue_->Release(*paused, "stopped"));
  EXPECT_FALSE(queue_->Fail(*paused, "failed", 1));
  EXPECT_TRUE(queue_->Renew(*next, kLongS, {}));
  EXPECT_TRUE(queue_->FinishPart(*next, "sha256:2", 2));
  EXPECT_FALSE(queue_->FinishPart(*paused, "sha256:1", 1));
  const auto paused_join = queue_->Claim("a:1", kLongS);
  Expire();
  const auto join = queue_->Claim("b:2", kLongS);
  EXPECT_FALSE(queue_->FinishJoin(paused_join.value(), Version("lab")));
  EXPECT_THROW(OpenRegistry(postgres_->url())->Versions("lab"), MapError) << "not published";
  EXPECT_EQ(State(job), "running");
  EXPECT_TRUE(queue_->FinishJoin(join.value(), Version("lab")));
  EXPECT_FALSE(queue_->FinishJoin(*paused_join, Version("lab")));
  EXPECT_EQ(OpenRegistry(postgres_->url())->Versions("lab").size(), 1u);
}

// Nobody took the step meanwhile: what the worker has done isn't done again.
TEST_F(JobQueueTest, AnExpiredLeaseThatNobodyTookIsStillHeld) {
  Planned(1);
  const auto part = queue_->Claim("a:1", kLongS);
  Expire();
  EXPECT_TRUE(queue_->Renew(part.value(), kLongS, {}));
  Expire();
  EXPECT_TRUE(queue_->FinishPart(*part, "sha256:1", 1));
}

TEST_F(JobQueueTest, FailuresAreTriedAgainLaterAndEndTheJobAtLast) {
  JobSpec spec = Spec("lab");
  spec.max_attempts = 2;
  const int64_t job = queue_->Enqueue(spec);
  EXPECT_TRUE(queue_->Fail(queue_->Claim("a:1", kLongS).value(), "the disk is full", kLongS));
  EXPECT_EQ(State(job), "running");
  EXPECT_FALSE(queue_->Claim("a:1", kLongS)) << "not yet";
  postgres_->Psql("UPDATE waystone.job_steps SET not_before = '-infinity'");
  const auto again = queue_->Claim("b:2", kLongS);
  EXPECT_EQ(again.value().failures, 1);
  EXPECT_TRUE(queue_->Fail(*again, "the disk is full again", kLongS));
  EXPECT_EQ(State(job), "failed");
  EXPECT_EQ(Reason(job), "the disk is full again");
  EXPECT_EQ(queue_->Describe(job)["history"][0]["reason"], "the disk is full");
  // What is no use to be tried again ends it at once.
  const int64_t bad = queue_->Enqueue(Spec("bad"));
  EXPECT_TRUE(queue_->Fail(queue_->Claim("a:1", kLongS).value(), "no image", std::nullopt));
  EXPECT_EQ(State(bad), "failed");
}

TEST_F(JobQueueTest, WorkersThatDieCountAndGivingBackDoesNot) {
  JobSpec spec = Spec("lab");
  spec.max_attempts = 2;
  const int64_t job = queue_->Enqueue(spec);
  for (int i = 0; i < 3; ++i) {
    EXPECT_TRUE(queue_->Release(queue_->Claim("a:1", kLongS).value(), "the worker was stopped"));
  }
  EXPECT_TRUE(queue_->Claim("a:1", kLongS));
  Expire();
  EXPECT_EQ(queue_->Claim("b:2", kLongS).value().failures, 1);
  Expire();
  EXPECT_FALSE(queue_->Claim("c:3", kLongS));
  EXPECT_EQ(State(job), "failed");
  EXPECT_EQ(Reason(job), "worker b:2 was silent for too long, in the last of 2 attempts");
}

TEST_F(JobQueueTest, JobsAreCancelledAndTakenUpAgain) {
  const int64_t job = Planned(2);
  EXPECT_TRUE(queue_->FinishPart(queue_->Claim("a:1", kLongS).value(), "sha256:1", 1));
  const auto part = queue_->Claim("a:1", kLongS);
  queue_->Cancel(job);
  EXPECT_EQ(State(job), "cancelled");
  EXPECT_FALSE(queue_->Renew(part.value(), kLongS, {}));
  EXPECT_FALSE(queue_->FinishPart(*part, "sha256:2", 2));
  EXPECT_FALSE(queue_->Claim("b:2", kLongS));
  EXPECT_NE(MessageOf(ErrorCode::kBadRequest, [&] { queue_->Cancel(job); }), "");
  queue_->Retry(job);
  const auto again = queue_->Claim("b:2", kLongS);
  EXPECT_EQ(again.value().step, part->step) << "the other part is built";
  EXPECT_FALSE(queue_->FinishPart(*part, "sha256:2", 2)) << "the lease before";
  EXPECT_NE(MessageOf(ErrorCode::kBadRequest, [&] { queue_->Retry(job); }), "");
  EXPECT_NE(MessageOf(ErrorCode::kNotFound, [&] { queue_->Cancel(4711); }), "");
  EXPECT_NE(MessageOf(ErrorCode::kNotFound, [&] { queue_->Describe(4711); }), "");
}

TEST_F(JobQueueTest, StepsAreGivenOutOnce) {
  for (int i = 0; i < 20; ++i) queue_->Enqueue(Spec("lab" + std::to_string(i)));
  std::vector<int> taken(8);
  std::vector<std::thread> workers;
  for (int& count : taken) {
    workers.emplace_back([&count] {
      const auto own = Open();
      while (own->CountOpen() > 0) {
        const auto lease = own->Claim("w:1", kLongS);
        if (!lease) continue;  // another one has it at the moment
        ++count;
        own->Fail(*lease, "enough", std::nullopt);
      }
    });
  }
  for (std::thread& worker : workers) worker.join();
  int all = 0;
  for (const int count : taken) all += count;
  EXPECT_EQ(all, 20);
}

TEST_F(JobQueueTest, OtherFormatsAreRefusedAndMissingTablesAreNoJobs) {
  postgres_->Psql("UPDATE waystone.job_format SET format = 2");
  EXPECT_EQ(MessageOf(ErrorCode::kFileUnreadable, [] { Open(); }),
            "the database has jobs of format 2, this program knows format 1; use the program that "
            "enqueued them, or a newer one");
  postgres_->Psql("DROP SCHEMA waystone CASCADE");
  JobQueue empty(postgres_->url(), false);
  EXPECT_TRUE(empty.List(10).empty());
  EXPECT_EQ(empty.CountOpen(), 0);
  EXPECT_FALSE(empty.Claim("a:1", kLongS));
}

// One that was changed by hand keeps no worker from the others.
TEST_F(JobQueueTest, ADamagedJobFailsAlone) {
  const int64_t damaged = queue_->Enqueue(Spec("lab"));
  const int64_t sound = queue_->Enqueue(Spec("hall"));
  postgres_->Psql("UPDATE waystone.jobs SET spec = '{}' WHERE id = " + std::to_string(damaged));
  EXPECT_FALSE(queue_->Claim("a:1", kLongS));
  EXPECT_EQ(State(damaged), "failed");
  EXPECT_EQ(queue_->Claim("a:1", kLongS).value().job, sound);
}

}  // namespace
}  // namespace waystone
