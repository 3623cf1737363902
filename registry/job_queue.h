// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "api/json.h"
#include "core/base/error.h"
#include "registry/job.h"
#include "registry/map_version.h"

namespace waystone {

namespace postgres {
class Database;
}

// Throws MapError(kUsage) for a registry that has no jobs: one in a folder.
void CheckHasJobs(const std::string& registry);

// For throwing.
MapError NoJobError(int64_t job);

// The jobs of a registry in PostgreSQL, beside its tables in the schema `waystone`:
//   job_format    one row: the version of these tables; others are refused
//   jobs          a row each: what is to be built, its state, and what came of it
//   job_steps     what workers take: the plan, the parts, and joining them
//   job_attempts  each lease of a step, with its worker and how it ended
//   job_log       what happened, for people
// A job is queued, running (from the first lease on), and then done, failed or cancelled. A step is
// leased to one worker for a time that heartbeats put off; when that is over, it is given to
// another. Whoever lost a lease can't change anything any more: each change asks, in its own
// transaction, whether the lease is still held. All times are the database's. An object is one
// connection, for one thread. All functions throw MapError: kRegistryUnavailable for a database
// that can't be reached, kFileUnreadable for one that can't be used; then the object is of no use
// any more.
class JobQueue {
 public:
  // Throws MapError(kUsage) for a registry in a folder. With `create`, tables that aren't there are
  // made; the registry must be there. Without, a database without these tables has no jobs.
  JobQueue(const std::string& registry, bool create);
  ~JobQueue();
  JobQueue(const JobQueue&) = delete;
  JobQueue& operator=(const JobQueue&) = delete;

  // Whether the database still answered when it was asked last.
  bool connected() const;

  // Returns the job's id.
  int64_t Enqueue(const JobSpec& spec);

  // ---- for workers

  // A step that nobody has: the first one of the oldest job, or of `job` alone. A step whose worker
  // was silent for too long counts as failed once more. `worker` is its name for people.
  std::optional<JobLease> Claim(const std::string& worker, double lease_s,
                                std::optional<int64_t> job = std::nullopt);
  // Puts the end of the lease off. False when it is lost: another worker has the step, or the job
  // was ended.
  bool Renew(const JobLease& lease, double lease_s, const StepProgress& progress);
  // The end of a step; false when the lease was lost, and then nothing is changed. Doing it again
  // is no error, because an answer of the database may be lost.
  bool FinishPlan(const JobLease& lease, const std::vector<JobPart>& parts);
  bool FinishPart(const JobLease& lease, const std::string& sha256, int64_t bytes);
  // Publishes the version and ends the job, both or neither.
  std::optional<MapVersion> FinishJoin(const JobLease& lease, const MapVersion& version);
  // Gives a step back that isn't done; it counts as nothing.
  bool Release(const JobLease& lease, const std::string& reason);
  // A step that failed is tried again after `retry_s` seconds, unless it was the last attempt or
  // there is nothing to try (no value): then the job has failed for that reason.
  bool Fail(const JobLease& lease, const std::string& reason, std::optional<double> retry_s);
  // Of a planned job, in their order.
  std::vector<BuiltPart> Parts(int64_t job);
  void Log(const JobLease& lease, const std::string& worker, const std::string& message);
  // Jobs that are queued or running.
  int64_t CountOpen();
  // "queued", "running", "done", "failed" or "cancelled". Throws MapError(kNotFound).
  std::string StateOf(int64_t job);

  // ---- for people

  // The newest first, at most `most` (Job of clients/openapi.yaml).
  std::vector<Json> List(int most);
  // One with its steps, attempts and log (JobDetails of clients/openapi.yaml). Throws
  // MapError(kNotFound).
  Json Describe(int64_t job);
  // Throws MapError: kNotFound, and kBadRequest for a job that has ended.
  void Cancel(int64_t job);
  // Takes up a job that failed or was cancelled, with the parts that are built. Throws MapError:
  // kNotFound, and kBadRequest for another one.
  void Retry(int64_t job);

 private:
  struct Held;  // what a transaction has found of a lease

  bool Exists();
  void Create();
  std::string LockJob(int64_t job);
  Held LockLease(const JobLease& lease);
  std::optional<JobLease> Take(int64_t job, int step, const std::string& worker, double lease_s);
  void EndAttempt(int64_t job, int step, int64_t token, const std::string& outcome,
                  const std::string& reason);
  void EndStep(const JobLease& lease, const std::string& state, const std::string& outcome,
               const std::string& reason);
  void EndJob(int64_t job, const std::string& state, const std::string& reason);
  void Write(int64_t job, const std::string& worker, const std::string& message);

  std::unique_ptr<postgres::Database> database_;
  bool exists_ = false;
};

}  // namespace waystone
