// SPDX-License-Identifier: Apache-2.0
#include "registry/postgres_database.h"

#include <poll.h>

#include <array>
#include <cstdio>
#include <utility>

#include "core/base/error.h"
#include "core/base/text.h"

namespace waystone::postgres {
namespace {

// Any number: of this program's advisory locks there is one.
constexpr const char* kCreationLock = "SELECT pg_advisory_xact_lock(8390880602276785)";

// A program that was paused or cut off in a transaction doesn't hold the others back for long. What
// the database ends itself must come before kAnswerS.
constexpr const char* kOptions =
    "-c lock_timeout=30s -c statement_timeout=60s -c idle_in_transaction_session_timeout=30s";

std::string FirstLine(const std::string& text) {
  const std::string line = text.substr(0, text.find('\n'));
  return Printable(line.empty() ? "no cause was given" : line);
}

// Whether trying again later may do: the server ends, has too many connections or too little room,
// or a lock was held for too long (SQLSTATE, its classes by their first two letters).
bool IsPassing(const std::string& state) {
  return state.starts_with("08") || state.starts_with("40") || state.starts_with("53") ||
         state.starts_with("55") || state.starts_with("57");
}

}  // namespace

void FailDatabase(ErrorCode code, const std::string& cause) {
  throw MapError(code, "the registry's database: " + FirstLine(cause) +
                           "; check the address postgresql://... and that the server runs");
}

Database::Database(const std::string& url, std::stop_token stop, double answer_s)
    : stop_(std::move(stop)), answer_s_(answer_s) {
  // What the address says comes later and counts. Nothing waits for a dead machine for long.
  const std::array<std::pair<const char*, const char*>, 7> settings{
      {{"connect_timeout", "3"},
       {"keepalives_idle", "5"},
       {"keepalives_interval", "2"},
       {"keepalives_count", "3"},
       {"tcp_user_timeout", "4000"},
       {"options", kOptions},
       {"fallback_application_name", "waystone"}}};
  std::vector<const char*> names;
  std::vector<const char*> values;
  for (const auto& [name, value] : settings) {
    names.push_back(name);
    values.push_back(value);
  }
  names.insert(names.end(), {"dbname", "client_encoding", nullptr});
  values.insert(values.end(), {url.c_str(), "UTF8", nullptr});
  connection_.reset(PQconnectdbParams(names.data(), values.data(), 1));
  if (!connection_) FailDatabase(ErrorCode::kRegistryUnavailable, "out of memory");
  if (PQstatus(connection_.get()) != CONNECTION_OK) Fail();
  PQsetNoticeProcessor(
      connection_.get(), [](void*, const char*) {}, nullptr);
  if (PQsetnonblocking(connection_.get(), 1) != 0) Fail();
}

Result Database::Run(const std::string& sql, const std::vector<std::string>& parameters) {
  std::vector<const char*> values;
  values.reserve(parameters.size());
  for (const std::string& parameter : parameters) values.push_back(parameter.c_str());
  // Several statements at once go without parameters alone.
  const int sent = parameters.empty() ? PQsendQuery(connection_.get(), sql.c_str())
                                      : PQsendQueryParams(connection_.get(), sql.c_str(),
                                                          static_cast<int>(values.size()), nullptr,
                                                          values.data(), nullptr, nullptr, 0);
  if (sent == 0) Fail();
  Result result = Answer();
  const ExecStatusType status = PQresultStatus(result.get());
  if (status == PGRES_COMMAND_OK || status == PGRES_TUPLES_OK) return result;
  const char* state = PQresultErrorField(result.get(), PG_DIAG_SQLSTATE);
  Fail(state && !IsPassing(state) ? ErrorCode::kFileUnreadable : ErrorCode::kRegistryUnavailable);
}

// The result of the last statement that was run: the one that failed, if any.
Result Database::Answer() {
  const Clock::time_point start = Clock::now();
  Result last;
  while (true) {
    WaitForAnswer(start);
    Result next(PQgetResult(connection_.get()));
    if (!next) return last;
    last = std::move(next);
  }
}

// Waits for the next result, at most answer_s_ from `start` on, and until a stop is requested.
// libpq's own waiting has no end: the machine of a server that is frozen keeps the connection
// alive.
void Database::WaitForAnswer(Clock::time_point start) {
  constexpr int kPauseMs = 1000;
  while (true) {
    const int unsent = PQflush(connection_.get());
    if (unsent < 0) Fail();
    if (unsent == 0 && PQisBusy(connection_.get()) == 0) return;
    if (stop_.stop_requested()) GiveUp("no answer until the program was stopped");
    if (SecondsSince(start) > answer_s_) {
      char cause[64];
      std::snprintf(cause, sizeof cause, "no answer within %g s", answer_s_);
      GiveUp(cause);
    }
    const short sending = unsent > 0 ? POLLOUT : 0;
    pollfd socket{PQsocket(connection_.get()), static_cast<short>(POLLIN | sending), 0};
    poll(&socket, 1, kPauseMs);
    if (PQconsumeInput(connection_.get()) == 0) Fail();
  }
}

bool Database::TakeNotifications() {
  if (PQconsumeInput(connection_.get()) == 0) Fail();
  bool any = false;
  while (PGnotify* notification = PQnotifies(connection_.get())) {
    PQfreemem(notification);
    any = true;
  }
  return any;
}

void Database::GiveUp(const std::string& cause) {
  connection_.reset();
  given_up_ = cause;
  Fail();
}

void Database::Fail(ErrorCode code) const {
  FailDatabase(code, connection_ ? PQerrorMessage(connection_.get()) : given_up_);
}

Transaction::~Transaction() {
  if (committed_) return;
  try {
    database_.Run("ROLLBACK");
  } catch (const std::exception&) {  // the connection is gone, and the transaction with it
  }
}

int Rows(const Result& result) { return PQntuples(result.get()); }
std::string Cell(const Result& result, int row, int column) {
  return PQgetvalue(result.get(), row, column);
}
int64_t Number(const Result& result, int row, int column) {
  return ToInteger(Cell(result, row, column)).value_or(0);
}
bool Flag(const Result& result, int row, int column) { return Cell(result, row, column) == "t"; }

bool HasTable(Database& database, const std::string& table) {
  // The tables as they are now: to_regclass() would tell what was cached.
  return Flag(database.Run("SELECT EXISTS (SELECT FROM pg_catalog.pg_tables WHERE schemaname = "
                           "'waystone' AND tablename = $1)",
                           {table}),
              0, 0);
}

void LockCreation(Database& database) { database.Run(kCreationLock); }

}  // namespace waystone::postgres
