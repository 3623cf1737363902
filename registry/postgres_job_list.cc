// SPDX-License-Identifier: Apache-2.0
// What the database says of its jobs.
#include <utility>

#include "core/base/error.h"
#include "registry/job_queue.h"
#include "registry/postgres_database.h"

namespace waystone {
namespace {

using postgres::Result;

// "2026-01-31T12:00:00.000Z" of a column; null stays null.
std::string TimeOf(const std::string& column) {
  return "to_char(" + column + " AT TIME ZONE 'UTC', 'YYYY-MM-DD\"T\"HH24:MI:SS.MS\"Z\"')";
}

// The members of clients/openapi.yaml's Job, of a row j of jobs.
std::string JobColumns() {
  return "j.id, j.name, j.state, j.reason, j.version, j.spec->'sources' AS sources, "
         "j.spec->'options' AS options, j.spec->'tags' AS tags, j.frames, " +
         TimeOf("j.created_at") + " AS created_at, " + TimeOf("j.started_at") + " AS started_at, " +
         TimeOf("j.ended_at") +
         " AS ended_at, "
         "(SELECT count(*) FROM waystone.job_steps s WHERE s.job = j.id AND s.kind = 'part') AS "
         "parts, "
         "(SELECT count(*) FROM waystone.job_steps s WHERE s.job = j.id AND s.kind = 'part' AND "
         "s.state = 'done') AS parts_done, "
         "(SELECT coalesce(sum(s.frames_done), 0) FROM waystone.job_steps s WHERE s.job = j.id AND "
         "s.kind = 'part') AS frames_done, "
         "(SELECT count(*) FROM waystone.job_attempts a WHERE a.job = j.id) AS attempts, "
         "(SELECT coalesce(json_agg(json_build_object('worker', s.worker, 'kind', s.kind, 'step', "
         "s.number, 'stage', s.stage) ORDER BY s.number), '[]') FROM waystone.job_steps s WHERE "
         "s.job = j.id AND s.state = 'leased') AS workers";
}

std::string StepColumns() {
  return "s.number, s.kind, s.state, s.frames, s.frames_done, s.stage, s.done, s.total, "
         "s.failures, s.worker, " +
         TimeOf("s.heartbeat_at") + " AS heartbeat_at, " + TimeOf("s.lease_until") +
         " AS lease_until, s.sha256, s.bytes";
}

// The rows of a query as a JSON list, in its order.
std::string ListOf(const std::string& query) {
  return "SELECT coalesce(json_agg(row_to_json(r)), '[]') FROM (" + query + ") r";
}

}  // namespace

std::vector<Json> JobQueue::List(int most) {
  if (!exists_ && !(exists_ = Exists())) return {};
  const Result rows = database_->Run("SELECT row_to_json(r) FROM (SELECT " + JobColumns() +
                                         " FROM waystone.jobs j ORDER BY j.id DESC LIMIT $1) r",
                                     {std::to_string(most)});
  std::vector<Json> jobs;
  for (int row = 0; row < Rows(rows); ++row) jobs.push_back(Json::parse(Cell(rows, row, 0)));
  return jobs;
}

Json JobQueue::Describe(int64_t job) {
  StateOf(job);  // whether there is one
  const std::vector<std::string> id{std::to_string(job)};
  const auto list = [&](const std::string& query) {
    return Json::parse(Cell(database_->Run(ListOf(query), id), 0, 0));
  };
  Json json = list("SELECT " + JobColumns() + " FROM waystone.jobs j WHERE j.id = $1").at(0);
  json["steps"] = list("SELECT " + StepColumns() +
                       " FROM waystone.job_steps s WHERE s.job = $1 ORDER BY s.number");
  json["history"] =
      list("SELECT a.step, a.worker, a.outcome, a.reason, " + TimeOf("a.started_at") +
           " AS started_at, " + TimeOf("a.ended_at") +
           " AS ended_at FROM waystone.job_attempts a WHERE a.job = $1 ORDER BY a.started_at");
  json["log"] = list("SELECT " + TimeOf("l.at") +
                     " AS at, l.worker, l.message FROM waystone.job_log l WHERE l.job = $1 "
                     "ORDER BY l.id");
  return json;
}

std::string JobQueue::StateOf(int64_t job) {
  if (exists_ || (exists_ = Exists())) {
    const Result row =
        database_->Run("SELECT state FROM waystone.jobs WHERE id = $1", {std::to_string(job)});
    if (Rows(row) == 1) return Cell(row, 0, 0);
  }
  throw NoJobError(job);
}

int64_t JobQueue::CountOpen() {
  if (!exists_ && !(exists_ = Exists())) return 0;
  return Number(
      database_->Run("SELECT count(*) FROM waystone.jobs WHERE state IN ('queued', 'running')"), 0,
      0);
}

}  // namespace waystone
