// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <libpq-fe.h>

#include <cstdint>
#include <memory>
#include <stop_token>
#include <string>
#include <vector>

#include "core/base/clock.h"
#include "core/base/error.h"

// A connection to PostgreSQL: internal to registry.
namespace waystone::postgres {

struct FreeResult {
  void operator()(PGresult* result) const { PQclear(result); }
};
using Result = std::unique_ptr<PGresult, FreeResult>;

struct FreeConnection {
  void operator()(PGconn* connection) const { PQfinish(connection); }
};

// Throws MapError with the first line of the cause.
[[noreturn]] void FailDatabase(ErrorCode code, const std::string& cause);

// How long the answer to a statement is waited for: a little longer than the database lets it run,
// so that only a database that is frozen is given up.
constexpr double kAnswerS = 65;

// One connection, for one thread. All functions throw as FailDatabase does: kRegistryUnavailable
// for a database that can't be reached, or may do it later, and kFileUnreadable for what it
// refuses. Where an answer takes longer than `answer_s`, or `stop` is requested while it is
// awaited, the connection is closed.
class Database {
 public:
  explicit Database(const std::string& url, std::stop_token stop = {}, double answer_s = kAnswerS);

  Result Run(const std::string& sql, const std::vector<std::string>& parameters = {});
  // Whether there was a notification since the last call.
  bool TakeNotifications();
  bool connected() const { return PQstatus(connection_.get()) == CONNECTION_OK; }
  int socket() const { return PQsocket(connection_.get()); }

 private:
  Result Answer();
  void WaitForAnswer(Clock::time_point start);
  [[noreturn]] void GiveUp(const std::string& cause);
  [[noreturn]] void Fail(ErrorCode code = ErrorCode::kRegistryUnavailable) const;

  const std::stop_token stop_;
  const double answer_s_;
  std::string given_up_;  // why the connection was closed
  std::unique_ptr<PGconn, FreeConnection> connection_;
};

// Rolled back unless it is committed.
class Transaction {
 public:
  explicit Transaction(Database& database) : database_(database) { database_.Run("BEGIN"); }
  ~Transaction();
  Transaction(const Transaction&) = delete;
  Transaction& operator=(const Transaction&) = delete;

  void Commit() {
    database_.Run("COMMIT");
    committed_ = true;
  }

 private:
  Database& database_;
  bool committed_ = false;
};

// Values of a result. A null is an empty text and 0.
int Rows(const Result& result);
std::string Cell(const Result& result, int row, int column);
int64_t Number(const Result& result, int row, int column);
bool Flag(const Result& result, int row, int column);

// Whether the schema `waystone` has that table.
bool HasTable(Database& database, const std::string& table);

// Holds other programs of this kind back from making tables until the transaction ends.
void LockCreation(Database& database);

}  // namespace waystone::postgres
