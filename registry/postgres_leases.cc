// SPDX-License-Identifier: Apache-2.0
// What workers do with the jobs of a database.
#include <utility>

#include "core/base/error.h"
#include "registry/job_queue.h"
#include "registry/postgres_database.h"
#include "registry/postgres_registry.h"

namespace waystone {
namespace {

using postgres::Result;
using postgres::Transaction;

// A step that can be taken, of a job j.
constexpr const char* kFree =
    "((s.state = 'queued' AND s.not_before <= clock_timestamp()) OR "
    "(s.state = 'leased' AND s.lease_until < clock_timestamp()))";

constexpr const char* kSeconds = "make_interval(secs => $3)";

std::string Text(int64_t number) { return std::to_string(number); }

StepKind KindOf(const std::string& name) {
  if (name == "plan") return StepKind::kPlan;
  return name == "part" ? StepKind::kPart : StepKind::kJoin;
}

// Columns source, first_frame, last_frame, frames from `column` on.
JobPart PartIn(const Result& rows, int row, int column) {
  return {.source = static_cast<int>(Number(rows, row, column)),
          .from = static_cast<int>(Number(rows, row, column + 1)),
          .to = static_cast<int>(Number(rows, row, column + 2)),
          .frames = static_cast<int>(Number(rows, row, column + 3))};
}

}  // namespace

struct JobQueue::Held {
  bool leased = false;  // by this lease
  bool done = false;    // by this lease, earlier
  int failures = 0;
};

std::optional<JobLease> JobQueue::Claim(const std::string& worker, double lease_s,
                                        std::optional<int64_t> job) {
  if (!exists_ && !(exists_ = Exists())) return std::nullopt;
  Transaction transaction(*database_);
  // A job whose row another worker has at the moment is left to it: there is a next time.
  const Result row = database_->Run(
      std::string("SELECT s.job, s.number FROM waystone.job_steps s JOIN waystone.jobs j ON j.id = "
                  "s.job WHERE j.state IN ('queued', 'running') AND ") +
          kFree +
          " AND ($1::bigint = 0 OR s.job = $1) ORDER BY s.job, s.number LIMIT 1 "
          "FOR UPDATE OF j SKIP LOCKED",
      {Text(job.value_or(0))});
  if (Rows(row) == 0) return std::nullopt;
  std::optional<JobLease> lease =
      Take(Number(row, 0, 0), static_cast<int>(Number(row, 0, 1)), worker, lease_s);
  transaction.Commit();
  return lease;
}

// With the job's row locked, so that the step changes no more but by heartbeats.
std::optional<JobLease> JobQueue::Take(int64_t job, int step, const std::string& worker,
                                       double lease_s) {
  const Result before = database_->Run(
      std::string("SELECT s.state, s.token, s.failures, s.worker FROM waystone.job_steps s WHERE "
                  "s.job = $1 AND s.number = $2 AND ") +
          kFree + " FOR UPDATE",
      {Text(job), Text(step)});
  if (Rows(before) == 0) return std::nullopt;
  const bool expired = Cell(before, 0, 0) == "leased";
  const int64_t failures = Number(before, 0, 2) + (expired ? 1 : 0);
  const Result of_job =
      database_->Run("SELECT name, spec FROM waystone.jobs WHERE id = $1", {Text(job)});
  JobLease lease{.job = job, .step = step, .token = Number(before, 0, 1) + 1};
  try {
    lease.spec = ReadJobSpec(Cell(of_job, 0, 0), Cell(of_job, 0, 1));
  } catch (const MapError& error) {
    EndJob(job, "failed", error.what());
    return std::nullopt;
  }
  if (expired) {
    const std::string reason = "worker " + Cell(before, 0, 3) + " was silent for too long";
    EndAttempt(job, step, lease.token - 1, "expired", reason);
    Write(job, Cell(before, 0, 3), "its lease has expired");
    if (failures >= lease.spec.max_attempts) {
      EndJob(job, "failed", reason + ", in the last of " + Text(failures) + " attempts");
      return std::nullopt;
    }
  }
  const Result taken = database_->Run(
      std::string("UPDATE waystone.job_steps SET state = 'leased', token = token + 1, failures = "
                  "$4, worker = $5, heartbeat_at = clock_timestamp(), lease_until = "
                  "clock_timestamp() + ") +
          kSeconds +
          ", stage = NULL, done = 0, total = 0, frames_done = 0 WHERE job = $1 AND number = $2 "
          "RETURNING kind, source, first_frame, last_frame, frames, (SELECT count(*) FROM "
          "waystone.job_steps p WHERE p.job = $1 AND p.kind = 'part')",
      {Text(job), Text(step), std::to_string(lease_s), Text(failures), worker});
  lease.kind = KindOf(Cell(taken, 0, 0));
  lease.failures = static_cast<int>(failures);
  lease.part = PartIn(taken, 0, 1);
  lease.parts = static_cast<int>(Number(taken, 0, 5));
  database_->Run(
      "INSERT INTO waystone.job_attempts (job, step, token, worker) VALUES ($1, $2, $3, $4)",
      {Text(job), Text(step), Text(lease.token), worker});
  database_->Run(
      "UPDATE waystone.jobs SET state = 'running', started_at = coalesce(started_at, "
      "clock_timestamp()) WHERE id = $1",
      {Text(job)});
  return lease;
}

bool JobQueue::Renew(const JobLease& lease, double lease_s, const StepProgress& progress) {
  const Result row = database_->Run(
      std::string("UPDATE waystone.job_steps s SET heartbeat_at = clock_timestamp(), lease_until = "
                  "clock_timestamp() + ") +
          kSeconds +
          ", stage = nullif($5, ''), done = $6, total = $7, frames_done = $8 FROM waystone.jobs j "
          "WHERE j.id = "
          "s.job AND j.state = 'running' AND s.job = $1 AND s.number = $2 AND s.token = $4 AND "
          "s.state = 'leased' RETURNING 1",
      {Text(lease.job), Text(lease.step), std::to_string(lease_s), Text(lease.token),
       progress.stage, Text(progress.done), Text(progress.total), Text(progress.frames)});
  return Rows(row) == 1;
}

JobQueue::Held JobQueue::LockLease(const JobLease& lease) {
  const std::string job = LockJob(lease.job);
  const Result row = database_->Run(
      "SELECT state, token, failures FROM waystone.job_steps WHERE job = $1 AND number = $2 "
      "FOR UPDATE",
      {Text(lease.job), Text(lease.step)});
  const bool same = Rows(row) == 1 && Number(row, 0, 1) == lease.token;
  return {.leased = same && job == "running" && Cell(row, 0, 0) == "leased",
          .done = same && Cell(row, 0, 0) == "done",
          .failures = same ? static_cast<int>(Number(row, 0, 2)) : 0};
}

bool JobQueue::FinishPlan(const JobLease& lease, const std::vector<JobPart>& parts) {
  Transaction transaction(*database_);
  const Held held = LockLease(lease);
  if (!held.leased) return held.done;
  int number = 0;
  int64_t frames = 0;
  for (const JobPart& part : parts) {
    database_->Run(
        "INSERT INTO waystone.job_steps (job, number, kind, state, source, first_frame, "
        "last_frame, frames) VALUES ($1, $2, 'part', 'queued', $3, $4, $5, $6)",
        {Text(lease.job), Text(++number), Text(part.source), Text(part.from), Text(part.to),
         Text(part.frames)});
    frames += part.frames;
  }
  database_->Run(
      "INSERT INTO waystone.job_steps (job, number, kind, state) VALUES ($1, $2, 'join', "
      "'waiting')",
      {Text(lease.job), Text(number + 1)});
  database_->Run("UPDATE waystone.jobs SET frames = $2 WHERE id = $1",
                 {Text(lease.job), Text(frames)});
  EndStep(lease, "done", "done", "");
  transaction.Commit();
  return true;
}

bool JobQueue::FinishPart(const JobLease& lease, const std::string& sha256, int64_t bytes) {
  Transaction transaction(*database_);
  const Held held = LockLease(lease);
  if (!held.leased) return held.done;
  database_->Run(
      "UPDATE waystone.job_steps SET sha256 = nullif($3, ''), bytes = $4, frames_done = frames "
      "WHERE job = $1 "
      "AND number = $2",
      {Text(lease.job), Text(lease.step), sha256, Text(bytes)});
  EndStep(lease, "done", "done", "");
  database_->Run(
      "UPDATE waystone.job_steps SET state = 'queued' WHERE job = $1 AND kind = 'join' AND NOT "
      "EXISTS (SELECT FROM waystone.job_steps p WHERE p.job = $1 AND p.kind = 'part' AND p.state "
      "<> 'done')",
      {Text(lease.job)});
  transaction.Commit();
  return true;
}

std::optional<MapVersion> JobQueue::FinishJoin(const JobLease& lease, const MapVersion& version) {
  Transaction transaction(*database_);
  const Held held = LockLease(lease);
  if (!held.leased && !held.done) return std::nullopt;
  MapVersion published = version;
  if (held.done) {
    const Result row =
        database_->Run("SELECT version FROM waystone.jobs WHERE id = $1", {Text(lease.job)});
    published.number = static_cast<int>(Number(row, 0, 0));
    return published;
  }
  published = PublishInTransaction(*database_, version);
  database_->Run("UPDATE waystone.jobs SET version = $2 WHERE id = $1",
                 {Text(lease.job), Text(published.number)});
  database_->Run(
      "UPDATE waystone.job_steps SET sha256 = $3, bytes = $4 WHERE job = $1 AND number = $2",
      {Text(lease.job), Text(lease.step), published.sha256, Text(published.bytes)});
  EndStep(lease, "done", "done", "");
  EndJob(lease.job, "done", "");
  transaction.Commit();
  return published;
}

bool JobQueue::Release(const JobLease& lease, const std::string& reason) {
  Transaction transaction(*database_);
  if (!LockLease(lease).leased) return false;
  EndStep(lease, "queued", "released", reason);
  transaction.Commit();
  return true;
}

bool JobQueue::Fail(const JobLease& lease, const std::string& reason,
                    std::optional<double> retry_s) {
  Transaction transaction(*database_);
  const Held held = LockLease(lease);
  if (!held.leased) return false;
  database_->Run(std::string("UPDATE waystone.job_steps SET failures = failures + 1, not_before = "
                             "clock_timestamp() + ") +
                     kSeconds + " WHERE job = $1 AND number = $2",
                 {Text(lease.job), Text(lease.step), std::to_string(retry_s.value_or(0))});
  EndStep(lease, "queued", "failed", reason);
  if (!retry_s || held.failures + 1 >= lease.spec.max_attempts) {
    EndJob(lease.job, "failed", reason);
  }
  transaction.Commit();
  return true;
}

void JobQueue::EndStep(const JobLease& lease, const std::string& state, const std::string& outcome,
                       const std::string& reason) {
  database_->Run(
      "UPDATE waystone.job_steps SET state = $3, worker = NULL, lease_until = NULL, stage = NULL "
      "WHERE job = $1 AND number = $2",
      {Text(lease.job), Text(lease.step), state});
  EndAttempt(lease.job, lease.step, lease.token, outcome, reason);
}

std::vector<BuiltPart> JobQueue::Parts(int64_t job) {
  const Result rows = database_->Run(
      "SELECT source, first_frame, last_frame, frames, coalesce(sha256, ''), coalesce(bytes, 0) "
      "FROM waystone.job_steps WHERE job = $1 AND kind = 'part' ORDER BY number",
      {Text(job)});
  std::vector<BuiltPart> parts;
  for (int row = 0; row < Rows(rows); ++row) {
    parts.push_back({PartIn(rows, row, 0), Cell(rows, row, 4), Number(rows, row, 5)});
  }
  return parts;
}

void JobQueue::Log(const JobLease& lease, const std::string& worker, const std::string& message) {
  Write(lease.job, worker, message);
}

}  // namespace waystone
