// SPDX-License-Identifier: Apache-2.0
#include "registry/job_queue.h"

#include <utility>

#include "core/base/error.h"
#include "core/base/text.h"
#include "registry/postgres_database.h"
#include "registry/postgres_registry.h"
#include "registry/registry.h"

namespace waystone {
namespace {

using postgres::Database;
using postgres::Result;
using postgres::Transaction;

// Of the tables; others are refused.
constexpr int kJobFormat = 1;

// Who changes anything but heartbeats locks the job's row first, and then rows of the others.
constexpr const char* kTables = R"sql(
CREATE TABLE waystone.job_format (
  only_row boolean PRIMARY KEY DEFAULT true CHECK (only_row),
  format integer NOT NULL
);
CREATE TABLE waystone.jobs (
  id bigint GENERATED ALWAYS AS IDENTITY PRIMARY KEY,
  name text COLLATE "C" NOT NULL,
  spec json NOT NULL,
  state text NOT NULL DEFAULT 'queued'
    CHECK (state IN ('queued', 'running', 'done', 'failed', 'cancelled')),
  frames integer,
  reason text,
  version integer,
  created_at timestamptz NOT NULL DEFAULT clock_timestamp(),
  started_at timestamptz,
  ended_at timestamptz
);
CREATE TABLE waystone.job_steps (
  job bigint NOT NULL REFERENCES waystone.jobs,
  number integer NOT NULL,
  kind text NOT NULL CHECK (kind IN ('plan', 'part', 'join')),
  state text NOT NULL CHECK (state IN ('waiting', 'queued', 'leased', 'done')),
  source integer,
  first_frame integer,
  last_frame integer,
  frames integer,
  token bigint NOT NULL DEFAULT 0,
  failures integer NOT NULL DEFAULT 0,
  not_before timestamptz NOT NULL DEFAULT '-infinity',
  worker text,
  heartbeat_at timestamptz,
  lease_until timestamptz,
  stage text,
  done integer NOT NULL DEFAULT 0,
  total integer NOT NULL DEFAULT 0,
  frames_done integer NOT NULL DEFAULT 0,
  sha256 text,
  bytes bigint,
  PRIMARY KEY (job, number)
);
CREATE INDEX job_steps_open ON waystone.job_steps (job, number) WHERE state IN ('queued', 'leased');
CREATE TABLE waystone.job_attempts (
  job bigint NOT NULL,
  step integer NOT NULL,
  token bigint NOT NULL,
  worker text NOT NULL,
  started_at timestamptz NOT NULL DEFAULT clock_timestamp(),
  ended_at timestamptz,
  outcome text,
  reason text,
  PRIMARY KEY (job, step, token),
  FOREIGN KEY (job, step) REFERENCES waystone.job_steps
);
CREATE TABLE waystone.job_log (
  id bigint GENERATED ALWAYS AS IDENTITY PRIMARY KEY,
  job bigint NOT NULL REFERENCES waystone.jobs,
  at timestamptz NOT NULL DEFAULT clock_timestamp(),
  worker text,
  message text NOT NULL
);
CREATE INDEX job_log_of_job ON waystone.job_log (job, id);
)sql";

}  // namespace

MapError NoJobError(int64_t job) {
  return {ErrorCode::kNotFound,
          "no job " + std::to_string(job) + " in this registry; waystone jobs lists the jobs"};
}

void CheckHasJobs(const std::string& registry) {
  if (IsPostgres(registry)) return;
  throw MapError(ErrorCode::kUsage, "'" + Printable(registry) +
                                        "' has no jobs; they need a registry in PostgreSQL "
                                        "(postgresql://...)");
}

JobQueue::JobQueue(const std::string& registry, bool create, std::stop_token stop) {
  CheckHasJobs(registry);
  database_ = std::make_unique<Database>(registry, std::move(stop));
  if (create) Create();
  exists_ = Exists();
}

JobQueue::~JobQueue() = default;

bool JobQueue::connected() const { return database_->connected(); }

bool JobQueue::Exists() {
  if (!HasTable(*database_, "job_format")) return false;
  const Result row = database_->Run("SELECT format FROM waystone.job_format");
  const int64_t format = Rows(row) == 1 ? Number(row, 0, 0) : 0;
  if (format == kJobFormat) return true;
  throw MapError(ErrorCode::kFileUnreadable,
                 "the database has jobs of format " + std::to_string(format) +
                     ", this program knows format " + std::to_string(kJobFormat) +
                     "; use the program that enqueued them, or a newer one");
}

void JobQueue::Create() {
  if (Exists()) return;
  Transaction transaction(*database_);
  LockCreation(*database_);
  if (Exists()) return;  // another program was faster
  database_->Run(kTables);
  database_->Run("INSERT INTO waystone.job_format (format) VALUES ($1)",
                 {std::to_string(kJobFormat)});
  transaction.Commit();
}

int64_t JobQueue::Enqueue(const JobSpec& spec) {
  CheckJobSpec(spec);
  Transaction transaction(*database_);
  const Result row =
      database_->Run("INSERT INTO waystone.jobs (name, spec) VALUES ($1, $2) RETURNING id",
                     {spec.name, TextOf(spec)});
  const int64_t job = Number(row, 0, 0);
  database_->Run(
      "INSERT INTO waystone.job_steps (job, number, kind, state) VALUES ($1, 0, 'plan', 'queued')",
      {std::to_string(job)});
  Write(job, "", "enqueued");
  transaction.Commit();
  return job;
}

std::string JobQueue::LockJob(int64_t job) {
  if (!exists_ && !(exists_ = Exists())) throw NoJobError(job);
  const Result row = database_->Run("SELECT state FROM waystone.jobs WHERE id = $1 FOR UPDATE",
                                    {std::to_string(job)});
  if (Rows(row) == 0) throw NoJobError(job);
  return Cell(row, 0, 0);
}

void JobQueue::EndAttempt(int64_t job, int step, int64_t token, const std::string& outcome,
                          const std::string& reason) {
  database_->Run(
      "UPDATE waystone.job_attempts SET ended_at = clock_timestamp(), outcome = $4, reason = "
      "nullif($5, '') WHERE job = $1 AND step = $2 AND token = $3",
      {std::to_string(job), std::to_string(step), std::to_string(token), outcome, reason});
}

// Workers that have other steps of it learn that by their next heartbeat.
void JobQueue::EndJob(int64_t job, const std::string& state, const std::string& reason) {
  database_->Run(
      "UPDATE waystone.job_attempts SET ended_at = clock_timestamp(), outcome = 'ended', reason = "
      "'the job was ended' WHERE job = $1 AND ended_at IS NULL",
      {std::to_string(job)});
  database_->Run(
      "UPDATE waystone.job_steps SET state = 'queued', worker = NULL, lease_until = NULL, stage = "
      "NULL WHERE job = $1 AND state = 'leased'",
      {std::to_string(job)});
  database_->Run(
      "UPDATE waystone.jobs SET state = $2, reason = nullif($3, ''), ended_at = clock_timestamp() "
      "WHERE id = $1",
      {std::to_string(job), state, reason});
  Write(job, "", reason.empty() ? state : state + ": " + reason);
}

void JobQueue::Write(int64_t job, const std::string& worker, const std::string& message) {
  database_->Run(
      "INSERT INTO waystone.job_log (job, worker, message) VALUES ($1, nullif($2, ''), $3)",
      {std::to_string(job), worker, message});
}

void JobQueue::Cancel(int64_t job) {
  Transaction transaction(*database_);
  const std::string state = LockJob(job);
  if (state != "queued" && state != "running") {
    throw MapError(ErrorCode::kBadRequest, "job " + std::to_string(job) + " is " + state +
                                               " already; only a job that is queued or running "
                                               "can be cancelled");
  }
  EndJob(job, "cancelled", "");
  transaction.Commit();
}

void JobQueue::Retry(int64_t job) {
  Transaction transaction(*database_);
  const std::string state = LockJob(job);
  if (state != "failed" && state != "cancelled") {
    throw MapError(ErrorCode::kBadRequest, "job " + std::to_string(job) + " is " + state +
                                               "; only a job that failed or was cancelled can be "
                                               "tried again");
  }
  database_->Run(
      "UPDATE waystone.job_steps SET failures = 0, not_before = '-infinity' WHERE job = $1 AND "
      "state = 'queued'",
      {std::to_string(job)});
  database_->Run(
      "UPDATE waystone.jobs SET state = 'queued', reason = NULL, ended_at = NULL WHERE id = $1",
      {std::to_string(job)});
  Write(job, "", "taken up again");
  transaction.Commit();
}

}  // namespace waystone
