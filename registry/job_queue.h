// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <stop_token>
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

// The error (kNotFound) to throw for a job that the registry doesn't have.
MapError NoJobError(int64_t job);

// The jobs of a registry in PostgreSQL, beside its tables in the schema `waystone`:
//   job_format    one row: the version of these tables; others are refused
//   jobs          one row each: what is to be built, its state, and the result
//   job_steps     what workers take: the plan, the parts, and joining them
//   job_attempts  each lease of a step, with its worker and how it ended
//   job_log       what happened, for people
// A job is queued, running (from the first lease on), and then done, failed or cancelled. A step is
// leased to one worker for a time that heartbeats extend; when that is over, it is given to
// another. A worker that lost its lease can't change anything any more: each change checks, in its
// own transaction, whether the lease is still held. All times are the database's. An object is one
// connection. Not thread-safe. All functions throw MapError: kRegistryUnavailable for a database
// that can't be reached, kFileUnreadable for one that can't be used; the object can't be used any
// more after either.
class JobQueue {
 public:
  // Throws MapError(kUsage) for a registry in a folder. With `create`, tables that aren't there are
  // made; the registry must be there. Without, a database without these tables has no jobs. A
  // request to stop ends the wait for a database that doesn't answer.
  JobQueue(const std::string& registry, bool create, std::stop_token stop = {});
  ~JobQueue();
  JobQueue(const JobQueue&) = delete;
  JobQueue& operator=(const JobQueue&) = delete;

  // Whether the database answered when it was last asked.
  bool connected() const;

  // Returns the job's id.
  int64_t Enqueue(const JobSpec& spec);

  // ---- for workers

  // Leases a step that nobody has for `lease_s` seconds: the first one of the oldest job, or of
  // `job` only; nothing where there is none. A step whose lease ran out counts as failed once more.
  // `worker` is the worker's name for people.
  std::optional<JobLease> Claim(const std::string& worker, double lease_s,
                                std::optional<int64_t> job = std::nullopt);
  // Extends the lease to `lease_s` seconds from now. False when it is lost: another worker has the
  // step, or the job has ended.
  bool Renew(const JobLease& lease, double lease_s, const StepProgress& progress);
  // Ends a step. False when the lease was lost, and then nothing is changed. A second call is no
  // error, because the database's answer to the first one may have been lost.
  bool FinishPlan(const JobLease& lease, const std::vector<JobPart>& parts);
  bool FinishPart(const JobLease& lease, const std::string& sha256, int64_t bytes);
  // Publishes the version and ends the job, both or neither; nothing when the lease was lost.
  std::optional<MapVersion> FinishJoin(const JobLease& lease, const MapVersion& version);
  // Gives back a step that isn't done, without counting it as failed.
  bool Release(const JobLease& lease, const std::string& reason);
  // Ends a step as failed. It is tried again after `retry_s` seconds, unless this was the last
  // attempt or trying again is no use (no value): then the job has failed for that reason.
  bool Fail(const JobLease& lease, const std::string& reason, std::optional<double> retry_s);
  // The parts of a planned job, in order.
  std::vector<BuiltPart> Parts(int64_t job);
  void Log(const JobLease& lease, const std::string& worker, const std::string& message);
  // Jobs that are queued or running.
  int64_t CountOpen();
  // "queued", "running", "done", "failed" or "cancelled". Throws MapError(kNotFound).
  std::string StateOf(int64_t job);

  // ---- for people

  // The jobs, newest first, at most `most` (Job of clients/openapi.yaml).
  std::vector<Json> List(int most);
  // A job with its steps, attempts and log (JobDetails of clients/openapi.yaml). Throws
  // MapError(kNotFound).
  Json Describe(int64_t job);
  // Throws MapError: kNotFound, and kBadRequest for a job that has ended.
  void Cancel(int64_t job);
  // Resumes a job that failed or was cancelled, with the parts that are built. Throws MapError:
  // kNotFound, and kBadRequest for a job in another state.
  void Retry(int64_t job);

 private:
  struct Held;  // what a transaction found out about a lease

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
