// SPDX-License-Identifier: Apache-2.0
#include "tests/schema/crafted_maps.h"
#include "tests/schema/made_map.h"

namespace waystone {
namespace {

namespace fs = std::filesystem;

CraftedMap BySql(const std::string& name, const std::string& sql) {
  return {name, [sql](const fs::path& path) { RunSql(path, sql); }};
}

// Replaces text in the definition of `object` after `sql`, where SQLite would refuse to make it or
// would evaluate it while making it.
CraftedMap ByEditedSchema(const std::string& name, const std::string& sql,
                          const std::string& object, const std::string& from,
                          const std::string& to) {
  return BySql(name, sql + "; PRAGMA writable_schema = ON; UPDATE sqlite_schema SET sql = " +
                         "replace(sql, '" + from + "', '" + to + "') WHERE name = '" + object +
                         "'");
}

CraftedMap BySchemaRow(const std::string& name, const std::string& values) {
  return BySql(name, "CREATE TABLE other (a INTEGER); PRAGMA writable_schema = ON; " + values);
}

// 800 MB of text by way of 400 MB of zeros.
const std::string kCostly = "length(hex(zeroblob(a * 400000000)))";
const std::string kCheap = "length(hex(zeroblob(a)))";
const std::string kOther = "CREATE TABLE other (a INTEGER); INSERT INTO other VALUES (1);";
const std::string kEndless =
    "WITH RECURSIVE r(x) AS (SELECT 1 UNION ALL SELECT x + 1 FROM r) SELECT x";
const std::string kCount =
    "WITH RECURSIVE r(x) AS (SELECT 1 UNION ALL SELECT x + 1 FROM r LIMIT 40000) ";

std::string Repeated(int count, const std::string& text) {
  std::string repeated;
  for (int i = 0; i < count; ++i) repeated += text;
  return repeated;
}

std::string Columns(int count) {
  std::string columns;
  for (int i = 1; i <= count; ++i) columns += ", a" + std::to_string(i);
  return columns;
}

std::vector<CraftedMap> Expressions() {
  return {
      ByEditedSchema("expression index", kOther + "CREATE INDEX i ON other (" + kCheap + ")", "i",
                     kCheap, kCostly),
      ByEditedSchema("expression index on planes",
                     "CREATE INDEX i ON planes (length(hex(zeroblob(vertex_count))))", "i",
                     "vertex_count", "id * 90000000"),
      ByEditedSchema("partial index",
                     kOther + "CREATE INDEX i ON other (a) WHERE " + kCheap + " > 0", "i", kCheap,
                     kCostly),
      BySql("collated index", kOther + "CREATE INDEX i ON other (a COLLATE NOCASE)"),
      BySql("descending index", kOther + "CREATE INDEX i ON other (a DESC)"),
      BySql("CHECK",
            "CREATE TABLE other (a CHECK (" + kCostly + " > 0)); INSERT INTO other VALUES (1)"),
      BySql("CHECK of the table",
            "CREATE TABLE other (a, CHECK (" + kCostly + ")); INSERT INTO other VALUES (1)"),
      BySql("DEFAULT", "CREATE TABLE other (a, b DEFAULT (hex(zeroblob(400000000))))"),
      ByEditedSchema("generated column",
                     "CREATE TABLE other (a INTEGER NOT NULL, b INTEGER AS (" + kCheap +
                         ") NOT NULL) STRICT; INSERT INTO other VALUES (1)",
                     "other", kCheap, kCostly),
      ByEditedSchema("stored generated column",
                     "CREATE TABLE other (a INTEGER, b INTEGER AS (" + kCheap +
                         ") STORED NOT NULL); INSERT INTO other VALUES (1)",
                     "other", kCheap, kCostly),
      BySql("foreign reference", "CREATE TABLE other (a REFERENCES planes)"),
      BySql("trigger on planes",
            "CREATE TRIGGER t AFTER INSERT ON planes BEGIN SELECT hex(zeroblob(400000000)); END"),
      BySql("trigger of a view",
            "CREATE TRIGGER t INSTEAD OF INSERT ON plane_list BEGIN SELECT randomblob(9); END"),
      BySql("endless view", "CREATE VIEW v AS " + kEndless + " FROM r"),
      BySql("view over a function", "CREATE VIEW v AS SELECT load_extension('/tmp/x.so')"),
      BySql("view over a pragma", "CREATE VIEW v AS SELECT * FROM pragma_integrity_check"),
      BySql("plain view", "CREATE VIEW v AS SELECT id FROM planes"),
      BySql("full text", "CREATE VIRTUAL TABLE other USING fts5(a); INSERT INTO other VALUES (1)"),
      BySql("full text 4", "CREATE VIRTUAL TABLE other USING fts4(a)"),
      BySql("full text over planes", "CREATE VIRTUAL TABLE other USING fts5(id, content='planes')"),
      BySql("rtree", "CREATE VIRTUAL TABLE other USING rtree(id, a, b)"),
      BySql("dbstat", "CREATE VIRTUAL TABLE other USING dbstat"),
      BySchemaRow("virtual table without a module",
                  "INSERT INTO sqlite_schema VALUES ('table', 'x', 'x', 0, "
                  "'CREATE VIRTUAL TABLE x USING nosuch(a)')"),
  };
}

std::vector<CraftedMap> OwnObjects() {
  const std::string outline = "outline BLOB NOT NULL";
  return {
      ByEditedSchema("our table with a CHECK", "SELECT 1", "planes", outline,
                     outline + " CHECK (length(hex(zeroblob(400000000))) > 0)"),
      ByEditedSchema("our table with a DEFAULT", "SELECT 1", "planes", outline,
                     outline + " DEFAULT (zeroblob(400000000))"),
      ByEditedSchema("our table with a generated column", "SELECT 1", "planes", outline,
                     outline + ", b BLOB AS (zeroblob(400000000))"),
      ByEditedSchema("our table without STRICT", "SELECT 1", "planes", "STRICT", " "),
      BySql("our view without end",
            "DROP VIEW plane_list; CREATE VIEW plane_list AS " + kEndless + " AS id FROM r"),
      BySql("our table as an endless view",
            "DROP TABLE corridors; CREATE VIEW corridors AS " + kEndless +
                " AS first_frame, x AS last_frame, 0 AS axis FROM r"),
      BySql("our table as a virtual one",
            "DROP TABLE corridors; CREATE VIRTUAL TABLE corridors USING fts5(first_frame, "
            "last_frame, axis)"),
      BySql("statistics", "ANALYZE; UPDATE sqlite_stat1 SET stat = '1 1 999999999999999999 x'"),
      BySql("sequence", "CREATE TABLE other (a INTEGER PRIMARY KEY AUTOINCREMENT)"),
      BySchemaRow("root beyond the end",
                  "UPDATE sqlite_schema SET rootpage = 2000000000 WHERE name = 'planes'"),
      BySchemaRow("root 0", "UPDATE sqlite_schema SET rootpage = 0 WHERE name = 'planes'"),
      BySchemaRow("root 1", "UPDATE sqlite_schema SET rootpage = 1 WHERE name = 'planes'"),
      BySchemaRow("root of two",
                  "UPDATE sqlite_schema SET rootpage = (SELECT rootpage FROM "
                  "sqlite_schema WHERE name = 'keyframes') WHERE name = 'other'"),
      BySchemaRow("no definition", "INSERT INTO sqlite_schema VALUES ('table', 'x', 'x', 2, NULL)"),
      BySchemaRow("empty definition",
                  "INSERT INTO sqlite_schema VALUES ('index', 'x', 'planes', 2, '')"),
      BySchemaRow("a trigger as a table",
                  "INSERT INTO sqlite_schema VALUES ('table', 'x', 'x', 2, 'CREATE TRIGGER x AFTER "
                  "INSERT ON planes BEGIN SELECT 1; END')"),
      BySchemaRow("blob as a definition",
                  "INSERT INTO sqlite_schema VALUES (x'00', x'ff', 7, 'two', x'435245415445')"),
  };
}

std::vector<CraftedMap> LargeSchemas() {
  return {
      BySchemaRow("40,000 tables", "INSERT INTO sqlite_schema " + kCount +
                                       "SELECT 'table', 't' || x, 't' || x, 2, 'CREATE TABLE t' || "
                                       "x || ' (a INTEGER, b TEXT)' FROM r"),
      BySql("1,900 columns", "CREATE TABLE other (a0" + Columns(1899) + ")"),
      BySql("nested parentheses",
            "CREATE VIEW v AS SELECT " + std::string(45, '(') + "1" + std::string(45, ')')),
      BySql("nested operators", "CREATE VIEW v AS SELECT 1" + Repeated(900, " + 1")),
      BySql("compound", "CREATE VIEW v AS SELECT 1" + Repeated(499, " UNION SELECT 1")),
      BySql("long definition", "CREATE VIEW v AS SELECT '" + std::string(5'000'000, 'x') + "'"),
      BySql("escapes in a table's name", "CREATE TABLE \"\x1b]0;x\x07\r\n\x1b[2J\" (a)"),
      BySql("escapes in a view's name", "CREATE VIEW \"map_x\u009b31m\x1b[8m\nok\" AS SELECT 1"),
      BySql("escapes in a trigger",
            "CREATE TRIGGER \"t\x1b[1A\" AFTER DELETE ON map BEGIN SELECT 1; END"),
      BySchemaRow("escapes in what SQLite reports",
                  "INSERT INTO sqlite_schema VALUES ('table', char(27) || '[2J' || char(10), 'x', "
                  "2, 'CREATE TABLE')"),
  };
}

std::vector<CraftedMap> Claims() {
  return {
      BySql("claimed features", "UPDATE planes SET feature_count = 2147483647"),
      BySql("claimed vertices", "UPDATE planes SET vertex_count = 2147483647"),
      BySql("claimed lists", "UPDATE search_index SET list_count = 2147483647"),
      BySql("claimed rows", "UPDATE search_index SET feature_count = 9223372036854775807"),
      BySql("claimed signature",
            "UPDATE appearance_layer SET signature_rows = 4096, k1 = 4096, k2 = 4096"),
      BySql("claimed landmarks", "UPDATE keyframe_landmarks SET landmark_count = 2147483647"),
      BySql("claimed codes", "UPDATE appearance_features SET feature_count = 2147483647"),
      BySql("a text of 5 MB",
            "UPDATE keyframes SET source = printf('%.*c', 5000000, 'x') WHERE id "
            "= (SELECT min(id) FROM keyframes)"),
      BySql("40,000 rows of nonsense", kCount + "INSERT INTO keyframes SELECT 1000 + x, 777, -1, "
                                                "-1, '', NULL, 0, 0 FROM r"),
      BySql("40,000 sequences and keyframes",
            kCount +
                "INSERT INTO sequences SELECT 1000 + x, '', '', 0, 0, NULL, NULL, NULL, NULL, "
                "NULL FROM r; " +
                kCount +
                "INSERT INTO keyframes SELECT 1000 + x, 41000, 0, 0, '', NULL, 1, 1 "
                "FROM r"),
      BySql("40,000 edges without planes",
            kCount + "INSERT INTO edges SELECT 1000 + x, 2000 + x, 0, 0, 1.0, 0, zeroblob(72) "
                     "FROM r"),
      BySql("40,000 terms",
            kCount + "INSERT INTO appearance_verdict_terms SELECT 1000 + x, 1, 'a', 0.0 FROM r"),
  };
}

std::vector<CraftedMap> Harmless() {
  std::vector<CraftedMap> maps{
      BySql("a table of one's own", kOther + kCount + "INSERT INTO other SELECT x FROM r"),
      BySql("a typed table",
            "CREATE TABLE other (id INTEGER PRIMARY KEY, note TEXT NOT NULL UNIQUE,"
            " size REAL) STRICT; INSERT INTO other VALUES (1, 'x', 0.5)"),
      BySql("an index of one's own", kOther + "CREATE UNIQUE INDEX i ON other (a); CREATE INDEX j "
                                              "ON keyframes (sequence, frame)"),
  };
  maps.push_back(
      BySql("40,000 contents", kCount + "INSERT INTO contents SELECT 't' || x, 0, 0 FROM r"));
  for (CraftedMap& map : maps) map.sound = true;
  return maps;
}

}  // namespace

std::vector<CraftedMap> CraftedByStatements() {
  std::vector<CraftedMap> all;
  for (const auto& maps : {Expressions(), OwnObjects(), LargeSchemas(), Claims(), Harmless()}) {
    all.insert(all.end(), maps.begin(), maps.end());
  }
  return all;
}

}  // namespace waystone
