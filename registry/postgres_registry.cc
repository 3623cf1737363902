// SPDX-License-Identifier: Apache-2.0
#include "registry/postgres_registry.h"

#include <libpq-fe.h>

#include <array>
#include <utility>
#include <vector>

#include "core/base/clock.h"
#include "core/base/error.h"
#include "core/base/text.h"

namespace waystone {
namespace {

// Between questions without a notification: whether the connection still stands.
constexpr double kAskS = 10;
// Any number: of this program's advisory locks there is one.
constexpr const char* kCreationLock = "SELECT pg_advisory_xact_lock(8390880602276785)";

constexpr const char* kSchema = R"sql(
CREATE SCHEMA waystone;
CREATE TABLE waystone.registry (
  only_row boolean PRIMARY KEY DEFAULT true CHECK (only_row),
  format integer NOT NULL,
  id text NOT NULL,
  store text NOT NULL,
  changes bigint NOT NULL DEFAULT 0
);
CREATE TABLE waystone.versions (
  name text COLLATE "C" NOT NULL,
  number integer NOT NULL CHECK (number > 0),
  sha256 text NOT NULL,
  bytes bigint NOT NULL,
  details json NOT NULL,
  published_at timestamptz NOT NULL DEFAULT now(),
  PRIMARY KEY (name, number)
);
CREATE TABLE waystone.maps (
  name text COLLATE "C" PRIMARY KEY,
  number integer NOT NULL,
  retired boolean NOT NULL,
  changed bigint NOT NULL UNIQUE,
  FOREIGN KEY (name, number) REFERENCES waystone.versions
);
)sql";

// Columns as Row() reads them.
constexpr const char* kVersionColumns = "v.name, v.number, v.sha256, v.bytes, v.details";

struct FreeResult {
  void operator()(PGresult* result) const { PQclear(result); }
};
using Result = std::unique_ptr<PGresult, FreeResult>;

struct FreeConnection {
  void operator()(PGconn* connection) const { PQfinish(connection); }
};

std::string FirstLine(const std::string& text) {
  const std::string line = text.substr(0, text.find('\n'));
  return Printable(line.empty() ? "no cause was given" : line);
}

[[noreturn]] void FailDatabase(ErrorCode code, const std::string& cause) {
  throw MapError(code, "the registry's database: " + FirstLine(cause) +
                           "; check the address postgresql://... and that the server runs");
}

// Whether trying again later may do: the server ends, has too many connections or too little room,
// or a lock was held for too long (SQLSTATE, its classes by their first two letters).
bool IsPassing(const std::string& state) {
  return state.starts_with("08") || state.starts_with("40") || state.starts_with("53") ||
         state.starts_with("55") || state.starts_with("57");
}

class Database {
 public:
  explicit Database(const std::string& url) {
    // What the address says comes later and counts. Nothing waits for a dead machine for long.
    const std::array<std::pair<const char*, const char*>, 7> settings{
        {{"connect_timeout", "3"},
         {"keepalives_idle", "5"},
         {"keepalives_interval", "2"},
         {"keepalives_count", "3"},
         {"tcp_user_timeout", "4000"},
         {"options", "-c lock_timeout=30s -c statement_timeout=60s"},
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
    if (!connection_ || PQstatus(connection_.get()) != CONNECTION_OK) Fail();
    PQsetNoticeProcessor(
        connection_.get(), [](void*, const char*) {}, nullptr);
  }

  Result Run(const std::string& sql, const std::vector<std::string>& parameters = {}) {
    std::vector<const char*> values;
    values.reserve(parameters.size());
    for (const std::string& parameter : parameters) values.push_back(parameter.c_str());
    // Several statements at once go without parameters alone.
    Result result(parameters.empty() ? PQexec(connection_.get(), sql.c_str())
                                     : PQexecParams(connection_.get(), sql.c_str(),
                                                    static_cast<int>(values.size()), nullptr,
                                                    values.data(), nullptr, nullptr, 0));
    const ExecStatusType status = PQresultStatus(result.get());
    if (status == PGRES_COMMAND_OK || status == PGRES_TUPLES_OK) return result;
    const char* state = PQresultErrorField(result.get(), PG_DIAG_SQLSTATE);
    Fail(state && !IsPassing(state) ? ErrorCode::kFileUnreadable : ErrorCode::kRegistryUnavailable);
  }

  // Whether there was a notification since the last call.
  bool TakeNotifications() {
    if (PQconsumeInput(connection_.get()) == 0) Fail();
    bool any = false;
    while (PGnotify* notification = PQnotifies(connection_.get())) {
      PQfreemem(notification);
      any = true;
    }
    return any;
  }
  int socket() const { return PQsocket(connection_.get()); }

 private:
  [[noreturn]] void Fail(ErrorCode code = ErrorCode::kRegistryUnavailable) const {
    FailDatabase(code, connection_ ? PQerrorMessage(connection_.get()) : "out of memory");
  }

  std::unique_ptr<PGconn, FreeConnection> connection_;
};

// Rolled back unless it is committed.
class Transaction {
 public:
  explicit Transaction(Database& database) : database_(database) { database_.Run("BEGIN"); }
  ~Transaction() {
    if (committed_) return;
    try {
      database_.Run("ROLLBACK");
    } catch (const std::exception&) {  // the connection is gone, and the transaction with it
    }
  }
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

std::string Cell(const Result& result, int row, int column) {
  return PQgetvalue(result.get(), row, column);
}
int Rows(const Result& result) { return PQntuples(result.get()); }
int64_t Number(const Result& result, int row, int column) {
  return ToInteger(Cell(result, row, column)).value_or(0);
}
bool Flag(const Result& result, int row, int column) { return Cell(result, row, column) == "t"; }

MapVersion VersionIn(const Result& result, int row) {
  const MapVersion version{Cell(result, row, 0), static_cast<int>(Number(result, row, 1)),
                           Cell(result, row, 2), Number(result, row, 3), Cell(result, row, 4)};
  return ReadManifest(ManifestOf(version), "the row of " + Describe(version));
}

class PostgresRegistry : public Registry {
 public:
  PostgresRegistry(const std::string& url, const std::optional<NewRegistry>& create)
      : database_(url) {
    if (create) Create(*create);
    if (!Exists()) {
      throw MapError(ErrorCode::kFileUnreadable,
                     "the database has no registry; publish a map to it first (waystone publish)");
    }
    const Result head = database_.Run("SELECT format FROM waystone.registry");
    if (Rows(head) != 1) {
      FailDatabase(ErrorCode::kFileUnreadable, "the table waystone.registry must have one row");
    }
    CheckRegistryFormat("the database", static_cast<int>(Number(head, 0, 0)));
    const Result names = database_.Run("SELECT id, store FROM waystone.registry");
    id_ = Cell(names, 0, 0);
    store_ = Cell(names, 0, 1);
  }

  const std::string& id() const override { return id_; }
  const std::string& store() const override { return store_; }

  MapVersion Publish(const MapVersion& version) override {
    CheckMapName(version.name);
    Transaction transaction(database_);
    const std::string change = BeginChange();
    const std::optional<MapState> state = FindState(version.name);
    if (state && IsPublished(*state, version)) return state->version;
    MapVersion next = version;
    const Result last = database_.Run(
        "SELECT coalesce(max(number), 0) FROM waystone.versions WHERE name = $1", {next.name});
    next.number = static_cast<int>(Number(last, 0, 0)) + 1;
    database_.Run(
        "INSERT INTO waystone.versions (name, number, sha256, bytes, details) "
        "VALUES ($1, $2, $3, $4, $5)",
        {next.name, std::to_string(next.number), next.sha256, std::to_string(next.bytes),
         next.details});
    WriteState({next, false}, change);
    transaction.Commit();
    return next;
  }

  std::vector<MapVersion> Versions(const std::string& name) override {
    const Result rows =
        database_.Run("SELECT " + std::string(kVersionColumns) +
                          " FROM waystone.versions v WHERE v.name = $1 ORDER BY v.number",
                      {name});
    std::vector<MapVersion> versions;
    for (int row = 0; row < Rows(rows); ++row) versions.push_back(VersionIn(rows, row));
    if (versions.empty()) throw NoMapError(name);
    return versions;
  }

  MapVersion Rollback(const std::string& name, std::optional<int> number) override {
    Transaction transaction(database_);
    const std::string change = BeginChange();
    const MapState state = StateOf(name);
    const std::vector<MapVersion> versions = Versions(name);
    std::vector<int> numbers;
    for (const MapVersion& version : versions) numbers.push_back(version.number);
    const int to = RollbackNumber(state, numbers, number);
    MapVersion current;
    for (const MapVersion& version : versions) {
      if (version.number == to) current = version;
    }
    WriteState({current, false}, change);
    transaction.Commit();
    return current;
  }

  void Retire(const std::string& name) override {
    Transaction transaction(database_);
    const std::string change = BeginChange();
    WriteState({StateOf(name).version, true}, change);
    transaction.Commit();
  }

  RegistryNews Refresh() override {
    RegistryNews news;
    news.complete = !listening_;
    if (!listening_) database_.Run("LISTEN waystone");
    const bool notified = database_.TakeNotifications();
    if (listening_ && !notified && SecondsSince(asked_) < kAskS) return news;
    asked_ = Clock::now();
    const Result rows =
        database_.Run("SELECT " + std::string(kVersionColumns) +
                          ", m.retired, m.changed FROM waystone.maps m JOIN waystone.versions v "
                          "USING (name, number) WHERE m.changed > $1 ORDER BY m.changed",
                      {std::to_string(seen_)});
    for (int row = 0; row < Rows(rows); ++row) {
      try {
        news.changed.push_back({VersionIn(rows, row), Flag(rows, row, 5)});
      } catch (const MapError& error) {
        news.problems.push_back({Cell(rows, row, 0), error.what()});
      }
      seen_ = Number(rows, row, 6);
    }
    listening_ = true;
    return news;
  }

  int news_fd() const override { return database_.socket(); }

 private:
  bool Exists() {
    // The tables as they are now: to_regclass() would tell what was cached.
    return Flag(database_.Run("SELECT EXISTS (SELECT FROM pg_catalog.pg_tables WHERE schemaname = "
                              "'waystone' AND tablename = 'registry')"),
                0, 0);
  }

  void Create(const NewRegistry& registry) {
    if (Exists()) return;
    if (registry.store.empty()) {
      throw MapError(ErrorCode::kUsage,
                     "a registry in a database needs a store for the map files; give a folder or "
                     "an address that all servers reach (--store)");
    }
    Transaction transaction(database_);
    database_.Run(kCreationLock);
    if (Exists()) return;  // another program was faster
    database_.Run(kSchema);
    database_.Run("INSERT INTO waystone.registry (format, id, store) VALUES ($1, $2, $3)",
                  {std::to_string(kRegistryFormat), NewRegistryId(), registry.store});
    transaction.Commit();
  }

  // The number of the change that this transaction makes. Who makes the next one waits until it
  // ends, so that numbers become visible in their order.
  std::string BeginChange() {
    const Result row =
        database_.Run("UPDATE waystone.registry SET changes = changes + 1 RETURNING changes");
    return Cell(row, 0, 0);
  }

  std::optional<MapState> FindState(const std::string& name) {
    const Result rows = database_.Run("SELECT " + std::string(kVersionColumns) +
                                          ", m.retired FROM waystone.maps m JOIN "
                                          "waystone.versions v USING (name, number) "
                                          "WHERE m.name = $1",
                                      {name});
    if (Rows(rows) == 0) return std::nullopt;
    return MapState{VersionIn(rows, 0), Flag(rows, 0, 5)};
  }

  MapState StateOf(const std::string& name) {
    std::optional<MapState> state = FindState(name);
    if (!state) throw NoMapError(name);
    return *std::move(state);
  }

  void WriteState(const MapState& state, const std::string& change) {
    database_.Run(
        "INSERT INTO waystone.maps (name, number, retired, changed) VALUES ($1, $2, $3, $4) "
        "ON CONFLICT (name) DO UPDATE SET number = excluded.number, retired = excluded.retired, "
        "changed = excluded.changed",
        {state.version.name, std::to_string(state.version.number), state.retired ? "t" : "f",
         change});
    database_.Run("NOTIFY waystone");
  }

  Database database_;
  std::string id_;
  std::string store_;
  bool listening_ = false;
  int64_t seen_ = 0;  // the last change that was told
  Clock::time_point asked_;
};

}  // namespace

std::unique_ptr<Registry> OpenPostgresRegistry(const std::string& url,
                                               const std::optional<NewRegistry>& create) {
  return std::make_unique<PostgresRegistry>(url, create);
}

}  // namespace waystone
