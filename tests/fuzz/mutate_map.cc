// SPDX-License-Identifier: Apache-2.0
#include <SQLiteCpp/Column.h>
#include <SQLiteCpp/Database.h>
#include <SQLiteCpp/Exception.h>
#include <SQLiteCpp/Statement.h>
#include <sqlite3.h>

#include <algorithm>
#include <array>
#include <limits>
#include <span>

#include "schema/file/map_database.h"
#include "schema/file/map_tables.h"
#include "schema/layers/layers.h"
#include "schema/tables/blob.h"
#include "tests/fuzz/compressed.h"
#include "tests/fuzz/mutate_bytes.h"

namespace waystone {
namespace {

constexpr size_t kMaxMapBytes = 1 << 20;

void ComputeCrc(sqlite3_context* context, int /*count*/, sqlite3_value** values) {
  const auto* data = static_cast<const uint8_t*>(sqlite3_value_blob(values[0]));
  const auto size = static_cast<size_t>(sqlite3_value_bytes(values[0]));
  sqlite3_result_int64(context, Crc32c(BytesView(data, data == nullptr ? 0 : size)));
}

// A map in memory that lets anything be written to it.
class OpenMutant {
 public:
  explicit OpenMutant(const std::string& bytes) : database_(":memory:", SQLite::OPEN_READWRITE) {
    sqlite3* handle = database_.getHandle();
    auto* copy = static_cast<unsigned char*>(sqlite3_malloc64(bytes.size() + 1));
    std::ranges::copy(bytes, copy);
    const auto size = static_cast<sqlite3_int64>(bytes.size());
    sqlite3_deserialize(handle, "main", copy, size, size,
                        SQLITE_DESERIALIZE_FREEONCLOSE | SQLITE_DESERIALIZE_RESIZEABLE);
    // Damage must not make it loop.
    constexpr int kSteps = 200'000;
    sqlite3_progress_handler(
        handle, kSteps, [](void*) { return 1; }, nullptr);
    sqlite3_create_function(handle, "crc32c", 1, SQLITE_UTF8, nullptr, ComputeCrc, nullptr,
                            nullptr);
    database_.exec(
        "PRAGMA ignore_check_constraints = ON; PRAGMA foreign_keys = OFF;"
        "PRAGMA trusted_schema = OFF; PRAGMA journal_mode = OFF;");
  }

  void RepairChecksums() {
    for (const TableView& table : Tables()) {
      for (const Column& column : table.columns) {
        if (column.type != ColumnType::kBlob) continue;
        const std::string name(column.name);
        database_.exec("UPDATE OR IGNORE " + std::string(table.name) + " SET " + name +
                       "_crc32c = crc32c(" + name + ") WHERE " + name + " IS NOT NULL");
      }
    }
    static const std::vector<SchemaObject> objects = ExpectedObjects(Migrations());
    WriteContents(database_, objects);
  }

  // A random row of a random table that has any.
  void ChangeRow(Random& random, const MutateBytes& mutate) {
    const std::vector<TableView> tables = Tables();
    for (int attempt = 0; attempt < 20; ++attempt) {
      const TableView& table = tables[random.Below(static_cast<int>(tables.size()))];
      const std::string name(table.name);
      const int rows = database_.execAndGet("SELECT count(*) FROM " + name).getInt();
      if (rows == 0) continue;
      const std::string where = KeyOfRow(table, random.Below(rows));
      if (random.Below(12) == 0) {
        database_.exec("DELETE FROM " + name + where);
      } else {
        ChangeCell(table, where, random, mutate);
      }
      return;
    }
  }

  std::string Bytes() const {
    sqlite3_int64 size = 0;
    unsigned char* copy = sqlite3_serialize(database_.getHandle(), "main", &size, 0);
    if (copy == nullptr) return "";
    std::string bytes(reinterpret_cast<const char*>(copy), static_cast<size_t>(size));
    sqlite3_free(copy);
    return bytes;
  }

 private:
  std::vector<TableView> Tables() {
    std::vector<TableView> tables = AllTables();
    for (const OptionalTable& one : OptionalTables()) {
      if (database_.tableExists(std::string(one.table.name))) tables.push_back(one.table);
    }
    return tables;
  }

  // " WHERE a = 3 AND b = 4", of the n-th row.
  std::string KeyOfRow(const TableView& table, int n) {
    std::string keys;
    for (int i = 0; i < table.key_columns; ++i) {
      keys += (i == 0 ? "quote(" : ", quote(") + std::string(table.columns[i].name) + ")";
    }
    SQLite::Statement row(database_, "SELECT " + keys + " FROM " + std::string(table.name) +
                                         " LIMIT 1 OFFSET " + std::to_string(n));
    if (!row.executeStep()) return " WHERE FALSE";
    std::string where;
    for (int i = 0; i < table.key_columns; ++i) {
      where += (i == 0 ? " WHERE " : " AND ") + std::string(table.columns[i].name) + " = " +
               row.getColumn(i).getString();
    }
    return where;
  }

  void ChangeCell(const TableView& table, const std::string& where, Random& random,
                  const MutateBytes& mutate) {
    const Column& column = table.columns[random.Below(static_cast<int>(table.columns.size()))];
    const std::string name(column.name);
    SQLite::Statement update(
        database_, "UPDATE OR IGNORE " + std::string(table.name) + " SET " + name + " = ?" + where);
    if (column.nullable && random.Below(8) == 0) {
      update.bind(1);
    } else if (column.type == ColumnType::kInteger) {
      update.bind(1, Integer(Stored(table, name, where), random));
    } else if (column.type == ColumnType::kReal) {
      update.bind(1, Real(Stored(table, name, where), random));
    } else {
      constexpr size_t kLongest = 4096;
      const std::string bytes = mutate(Stored(table, name, where), kLongest);
      if (column.type == ColumnType::kText) {
        update.bind(1, bytes);
      } else {
        update.bind(1, bytes.data(), static_cast<int>(bytes.size()));
      }
    }
    update.exec();
  }

  std::string Stored(const TableView& table, const std::string& name, const std::string& where) {
    SQLite::Statement row(database_, "SELECT " + name + " FROM " + std::string(table.name) + where);
    return row.executeStep() ? row.getColumn(0).getString() : "";
  }

  static int64_t Integer(const std::string& stored, Random& random) {
    constexpr std::array<int64_t, 12> kValues{
        0, 1, -1, 2, 255, 65535, 65536, 2147483647, 2147483648, 4294967296, INT64_MAX, INT64_MIN};
    if (random.Below(2) == 0) return kValues.at(random.Below(kValues.size()));
    return std::strtoll(stored.c_str(), nullptr, 10) / 2 + random.Below(5);
  }

  static double Real(const std::string& stored, Random& random) {
    constexpr double kMost = std::numeric_limits<double>::max();
    constexpr std::array kValues{
        0.0, -0.0,   1.0,   -1.0,   1e-320, std::numeric_limits<double>::infinity(),
        1e9, -1e-15, kMost, -kMost, 1e154,  3.5};
    if (random.Below(2) == 0) return kValues.at(random.Below(kValues.size()));
    return std::strtod(stored.c_str(), nullptr) * random.Uniform(-2, 2);
  }

  SQLite::Database database_;
};

// The map with its checksums made right; as it is where SQLite can't read it.
std::string WithRepairedChecksums(const std::string& bytes, bool change, Random& random,
                                  const MutateBytes& mutate) {
  try {
    OpenMutant map(bytes);
    if (change) map.ChangeRow(random, mutate);
    map.RepairChecksums();
    return map.Bytes();
  } catch (const SQLite::Exception&) {
    return bytes;
  }
}

}  // namespace

std::string MutateMap(std::string bytes, size_t max_bytes, uint32_t seed,
                      const MutateBytes& mutate) {
  Random random(seed);
  std::string map = Decompress(bytes, kMaxMapBytes);
  const int kind = random.Below(8);
  if (kind >= 6 || map.empty()) map = mutate(std::move(map), kMaxMapBytes);
  if (kind < 7) map = WithRepairedChecksums(map, kind < 6, random, mutate);
  std::string compressed = Compress(map);
  return compressed.size() <= max_bytes ? compressed : bytes;
}

}  // namespace waystone
