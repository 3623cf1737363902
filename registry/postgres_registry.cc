// SPDX-License-Identifier: Apache-2.0
#include "registry/postgres_registry.h"

#include <utility>
#include <vector>

#include "core/base/clock.h"
#include "core/base/error.h"
#include "registry/postgres_database.h"

namespace waystone {
namespace {

using postgres::Database;
using postgres::Result;
using postgres::Transaction;

// Between questions without a notification: whether the connection still stands.
constexpr double kAskS = 10;
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

// Columns as VersionIn() reads them.
constexpr const char* kVersionColumns = "v.name, v.number, v.sha256, v.bytes, v.details";

MapVersion VersionIn(const Result& result, int row) {
  const MapVersion version{Cell(result, row, 0), static_cast<int>(Number(result, row, 1)),
                           Cell(result, row, 2), Number(result, row, 3), Cell(result, row, 4)};
  return ReadManifest(ManifestOf(version), "the row of " + Describe(version));
}

// The number of the change that this transaction makes. Who makes the next one waits until it
// ends, so that numbers become visible in their order.
std::string BeginChange(Database& database) {
  const Result row =
      database.Run("UPDATE waystone.registry SET changes = changes + 1 RETURNING changes");
  return Cell(row, 0, 0);
}

std::optional<MapState> FindState(Database& database, const std::string& name) {
  const Result rows = database.Run("SELECT " + std::string(kVersionColumns) +
                                       ", m.retired FROM waystone.maps m JOIN "
                                       "waystone.versions v USING (name, number) "
                                       "WHERE m.name = $1",
                                   {name});
  if (Rows(rows) == 0) return std::nullopt;
  return MapState{VersionIn(rows, 0), Flag(rows, 0, 5)};
}

void WriteState(Database& database, const MapState& state, const std::string& change) {
  database.Run(
      "INSERT INTO waystone.maps (name, number, retired, changed) VALUES ($1, $2, $3, $4) "
      "ON CONFLICT (name) DO UPDATE SET number = excluded.number, retired = excluded.retired, "
      "changed = excluded.changed",
      {state.version.name, std::to_string(state.version.number), state.retired ? "t" : "f",
       change});
  database.Run("NOTIFY waystone");
}

class PostgresRegistry : public Registry {
 public:
  PostgresRegistry(const std::string& url, const std::optional<NewRegistry>& create,
                   std::stop_token stop)
      : database_(url, std::move(stop)) {
    if (create) Create(*create);
    if (!Exists()) {
      throw MapError(ErrorCode::kFileUnreadable,
                     "the database has no registry; publish a map to it first (waystone publish)");
    }
    const Result head = database_.Run("SELECT format FROM waystone.registry");
    if (Rows(head) != 1) {
      postgres::FailDatabase(ErrorCode::kFileUnreadable,
                             "the table waystone.registry must have one row");
    }
    CheckRegistryFormat("the database", static_cast<int>(Number(head, 0, 0)));
    const Result names = database_.Run("SELECT id, store FROM waystone.registry");
    id_ = Cell(names, 0, 0);
    store_ = Cell(names, 0, 1);
  }

  const std::string& id() const override { return id_; }
  const std::string& store() const override { return store_; }

  MapVersion Publish(const MapVersion& version) override {
    Transaction transaction(database_);
    MapVersion published = PublishInTransaction(database_, version);
    transaction.Commit();
    return published;
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
    const std::string change = BeginChange(database_);
    const MapState state = StateOf(name);
    const std::vector<MapVersion> versions = Versions(name);
    std::vector<int> numbers;
    for (const MapVersion& version : versions) numbers.push_back(version.number);
    const int to = RollbackNumber(state, numbers, number);
    MapVersion current;
    for (const MapVersion& version : versions) {
      if (version.number == to) current = version;
    }
    WriteState(database_, {current, false}, change);
    transaction.Commit();
    return current;
  }

  void Retire(const std::string& name) override {
    Transaction transaction(database_);
    const std::string change = BeginChange(database_);
    WriteState(database_, {StateOf(name).version, true}, change);
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
  bool Exists() { return HasTable(database_, "registry"); }

  void Create(const NewRegistry& registry) {
    if (Exists()) return;
    if (registry.store.empty()) {
      throw MapError(ErrorCode::kUsage,
                     "a registry in a database needs a store for the map files; give a folder or "
                     "an address that all servers reach (--store)");
    }
    Transaction transaction(database_);
    LockCreation(database_);
    if (Exists()) return;  // another program was faster
    database_.Run(kSchema);
    database_.Run("INSERT INTO waystone.registry (format, id, store) VALUES ($1, $2, $3)",
                  {std::to_string(kRegistryFormat), NewRegistryId(), registry.store});
    transaction.Commit();
  }

  MapState StateOf(const std::string& name) {
    std::optional<MapState> state = FindState(database_, name);
    if (!state) throw NoMapError(name);
    return *std::move(state);
  }

  Database database_;
  std::string id_;
  std::string store_;
  bool listening_ = false;
  int64_t seen_ = 0;  // the last change that was told
  Clock::time_point asked_;
};

}  // namespace

MapVersion PublishInTransaction(Database& database, const MapVersion& version) {
  CheckMapName(version.name);
  const std::string change = BeginChange(database);
  const std::optional<MapState> state = FindState(database, version.name);
  if (state && IsPublished(*state, version)) return state->version;
  MapVersion next = version;
  const Result last = database.Run(
      "SELECT coalesce(max(number), 0) FROM waystone.versions WHERE name = $1", {next.name});
  next.number = static_cast<int>(Number(last, 0, 0)) + 1;
  database.Run(
      "INSERT INTO waystone.versions (name, number, sha256, bytes, details) "
      "VALUES ($1, $2, $3, $4, $5)",
      {next.name, std::to_string(next.number), next.sha256, std::to_string(next.bytes),
       next.details});
  WriteState(database, {next, false}, change);
  return next;
}

std::unique_ptr<Registry> OpenPostgresRegistry(const std::string& url,
                                               const std::optional<NewRegistry>& create,
                                               std::stop_token stop) {
  return std::make_unique<PostgresRegistry>(url, create, std::move(stop));
}

}  // namespace waystone
