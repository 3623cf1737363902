// SPDX-License-Identifier: Apache-2.0
// The descriptors of the tables against the migrations that make them and the document that
// explains them.
#include <SQLiteCpp/SQLiteCpp.h>
#include <gtest/gtest.h>

#include <fstream>
#include <map>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "core/base/check.h"
#include "core/camera/camera.h"
#include "schema/file/map_tables.h"
#include "schema/file/migrate.h"
#include "schema/file/plain_objects.h"
#include "schema/layers/appearance/appearance_layer.h"
#include "schema/layers/layers.h"
#include "schema/layers/orientation/orientation_layer.h"
#include "schema/layers/planes/plane_tables.h"
#include "schema/map_data.h"
#include "schema/sequence_kinds.h"
#include "schema/tables/row.h"
#include "schema/tables/table_writer.h"

namespace waystone {
namespace {

// "INTEGER", or "INTEGER or NULL", by the name of the column.
using TypeByColumn = std::map<std::string, std::string>;

std::string SqlName(ColumnType type) {
  switch (type) {
    case ColumnType::kInteger:
      return "INTEGER";
    case ColumnType::kReal:
      return "REAL";
    case ColumnType::kText:
      return "TEXT";
    case ColumnType::kBlob:
      return "BLOB";
  }
  return "";
}

TypeByColumn DescribedColumns(const TableView& table) {
  TypeByColumn columns;
  for (const Column& column : table.columns) {
    const std::string null = column.nullable ? " or NULL" : "";
    columns[std::string(column.name)] = SqlName(column.type) + null;
    if (column.type == ColumnType::kBlob) {
      columns[std::string(column.name) + "_crc32c"] = "INTEGER" + null;
    }
  }
  return columns;
}

std::string ReadText(const std::string& path) {
  std::ifstream in(std::string(WAYSTONE_SOURCE_DIR) + "/" + path);
  std::stringstream text;
  text << in.rdbuf();
  return text.str();
}

std::vector<std::string> Split(const std::string& text, const std::string& separator) {
  std::vector<std::string> parts;
  size_t start = 0;
  for (size_t end; (end = text.find(separator, start)) != std::string::npos;) {
    parts.push_back(text.substr(start, end - start));
    start = end + separator.size();
  }
  parts.push_back(text.substr(start));
  return parts;
}

SQLite::Database MakeDatabase() {
  SQLite::Database database(":memory:", SQLite::OPEN_READWRITE);
  for (const Migration& step : Migrations()) database.exec(step.sql);
  for (const OptionalTable& table : OptionalTables()) database.exec(table.sql);
  return database;
}

TypeByColumn StoredColumnTypes(SQLite::Database& database, const std::string& table) {
  TypeByColumn columns;
  SQLite::Statement info(database, "SELECT name, type, \"notnull\", pk FROM pragma_table_info(?)");
  info.bind(1, table);
  while (info.executeStep()) {
    const bool nullable = info.getColumn(2).getInt() == 0 && info.getColumn(3).getInt() == 0;
    columns[info.getColumn(0).getString()] =
        info.getColumn(1).getString() + (nullable ? " or NULL" : "");
  }
  return columns;
}

std::vector<std::string> KeyOf(SQLite::Database& database, const std::string& table) {
  std::vector<std::string> key;
  SQLite::Statement info(database,
                         "SELECT name FROM pragma_table_info(?) WHERE pk > 0 ORDER BY pk");
  info.bind(1, table);
  while (info.executeStep()) key.push_back(info.getColumn(0).getString());
  return key;
}

// Those that every map has, and the optional ones.
std::vector<TableView> DescribedTables() {
  std::vector<TableView> tables = AllTables();
  for (const OptionalTable& one : OptionalTables()) tables.push_back(one.table);
  return tables;
}

TEST(Tables, AreWhatTheMigrationsMake) {
  SQLite::Database database = MakeDatabase();
  std::set<std::string> described;
  for (const TableView& table : DescribedTables()) {
    const std::string name(table.name);
    described.insert(name);
    EXPECT_EQ(DescribedColumns(table), StoredColumnTypes(database, name)) << name;
    std::vector<std::string> key;
    for (int i = 0; i < table.key_columns; ++i) key.emplace_back(table.columns[i].name);
    EXPECT_EQ(key, KeyOf(database, name)) << name;
  }
  SQLite::Statement tables(database, "SELECT name FROM sqlite_schema WHERE type = 'table'");
  while (tables.executeStep()) {
    EXPECT_TRUE(described.contains(tables.getColumn(0).getString()))
        << tables.getColumn(0).getString() << " has no descriptor";
  }
}

// The tables of FORMAT.md: below a heading "### name", rows "| a, b | TYPE | meaning |".
std::map<std::string, TypeByColumn> DocumentedTables(const std::string& text) {
  std::map<std::string, TypeByColumn> tables;
  std::string table;
  for (const std::string& line : Split(text, "\n")) {
    if (line.starts_with("#")) table = "";
    if (line.starts_with("### ")) table = Split(line.substr(4), " ")[0];
    const std::vector<std::string> cells = Split(line, " | ");
    if (table.empty() || cells.size() < 3 || cells[0] == "| column") continue;
    const std::vector<std::string> names = Split(cells[0].substr(2), ", ");
    const bool nullable = cells[1].ends_with(" or NULL");
    const std::string null = nullable ? " or NULL" : "";
    const std::vector<std::string> types =
        Split(nullable ? cells[1].substr(0, cells[1].size() - null.size()) : cells[1], ", ");
    for (size_t i = 0; i < names.size(); ++i) {
      tables[table][names[i]] = (types.size() == names.size() ? types[i] : types[0]) + null;
    }
  }
  return tables;
}

// As sqlite_schema has it, and such that older programs leave it alone.
TEST(Tables, AreOptionalOnlyIfPlain) {
  SQLite::Database database = MakeDatabase();
  ASSERT_FALSE(OptionalTables().empty());
  for (const auto& [table, sql] : OptionalTables()) {
    SQLite::Statement row(database, "SELECT sql FROM sqlite_schema WHERE name = ?");
    row.bind(1, std::string(table.name));
    ASSERT_TRUE(row.executeStep());
    EXPECT_EQ(row.getColumn(0).getString(), sql);
    EXPECT_TRUE(IsPlainObject({"table", std::string(table.name), sql})) << table.name;
  }
}

TEST(Tables, AreInFormatMd) {
  const std::map<std::string, TypeByColumn> documented =
      DocumentedTables(ReadText("schema/FORMAT.md"));
  EXPECT_EQ(documented.size(), DescribedTables().size());
  for (const TableView& table : DescribedTables()) {
    const auto found = documented.find(std::string(table.name));
    ASSERT_NE(found, documented.end()) << table.name;
    EXPECT_EQ(found->second, DescribedColumns(table)) << table.name;
  }
}

// What a change of the document would look like to the test above.
TEST(Tables, ReadsTheDocument) {
  const std::map<std::string, TypeByColumn> tables = DocumentedTables(
      "### made (one row)\n| column | type | meaning |\n|---|---|---|\n| id | INTEGER | 1 |\n"
      "| x, y | REAL or NULL | px |\n| data_crc32c, data | INTEGER, BLOB | 3 x `uint8` |\n"
      "## Other\n| a | TEXT | b |\n");
  const TypeByColumn expected{{"id", "INTEGER"},
                              {"x", "REAL or NULL"},
                              {"y", "REAL or NULL"},
                              {"data_crc32c", "INTEGER"},
                              {"data", "BLOB"}};
  EXPECT_EQ(tables, (std::map<std::string, TypeByColumn>{{"made", expected}}));
}

// The pairs of cells of the tables below "## Stored enums", by the heading of the first: "0" to
// "SIFT ...".
std::map<std::string, std::map<int, std::string>> DocumentedEnums(const std::string& text) {
  std::map<std::string, std::map<int, std::string>> enums;
  std::vector<std::string> headings;
  const std::string begin = "## Stored enums\n";
  const size_t start = text.find(begin) + begin.size();
  for (const std::string& line :
       Split(text.substr(start, text.find("\n## ", start) - start), "\n")) {
    std::vector<std::string> cells = Split(line, "|");
    if (cells.size() < 4) {
      headings.clear();
      continue;
    }
    for (std::string& cell : cells) cell = std::regex_replace(cell, std::regex("^ +| +$"), "");
    if (headings.empty()) {
      headings = cells;
      continue;
    }
    for (size_t i = 1; i + 1 < cells.size(); i += 2) {
      if (cells[i].empty() || cells[i].starts_with("--")) continue;
      enums[headings[i]][std::stoi(cells[i])] = cells[i + 1];
    }
  }
  return enums;
}

template <class Enum>
int Stored(Enum value) {
  return static_cast<int>(value);
}

TEST(Tables, StoredEnumsAreInFormatMd) {
  const auto enums = DocumentedEnums(ReadText("schema/FORMAT.md"));
  ASSERT_EQ(enums.size(), 7u);
  const std::map<int, std::string>& features = enums.at("feature_type");
  EXPECT_EQ(features.size(), 3u);
  EXPECT_TRUE(features.at(Stored(FeatureType::kSift)).starts_with("SIFT"));
  EXPECT_TRUE(features.at(Stored(FeatureType::kOrb)).starts_with("ORB"));
  EXPECT_TRUE(features.at(Stored(FeatureType::kAkaze)).starts_with("AKAZE"));
  const std::map<int, std::string>& cameras = enums.at("camera_model");
  EXPECT_EQ(cameras.size(), 8u);
  for (const auto& [stored, meaning] : cameras) {
    const std::string name = Split(meaning, ":")[0];
    const std::optional<CameraModel> model = CameraModelByName(name);
    ASSERT_TRUE(model) << name;
    EXPECT_EQ(stored, Stored(*model)) << name;
  }
  const std::map<int, std::string>& edges = enums.at("kind of appearance_edges");
  EXPECT_TRUE(edges.at(Stored(AppearanceEdgeKind::kConsecutive)).starts_with("consecutive"));
  EXPECT_TRUE(edges.at(Stored(AppearanceEdgeKind::kLoop)).starts_with("a loop"));
  const std::map<int, std::string>& nodes = enums.at("kind of orientation_nodes");
  EXPECT_TRUE(nodes.at(Stored(OrientationNodeKind::kTraversable)).starts_with("traversable"));
  EXPECT_TRUE(nodes.at(Stored(OrientationNodeKind::kTurn)).starts_with("a turn"));
  const std::map<int, std::string>& loops = enums.at("kind of orientation_edges");
  EXPECT_TRUE(loops.at(Stored(OrientationEdgeKind::kTraversable)).starts_with("traversable"));
  EXPECT_TRUE(loops.at(Stored(OrientationEdgeKind::kLoop)).starts_with("a loop"));
  const std::map<int, std::string>& units = enums.at("unit of pose_layer");
  EXPECT_EQ(units.at(Stored(LengthUnit::kUnknown)), NameOf(LengthUnit::kUnknown));
  EXPECT_EQ(units.at(Stored(LengthUnit::kMetres)), NameOf(LengthUnit::kMetres));
  const std::map<int, std::string>& kinds = enums.at("kind of place_ranges");
  for (const NamedKind kind : {NamedKind::kKeyframes, NamedKind::kNodes, NamedKind::kPlanes}) {
    EXPECT_EQ(kinds.at(Stored(kind)), NameOf(kind));
  }
}

TEST(Tables, SequenceKindsAreInFormatMd) {
  std::string kinds;
  for (const std::string_view kind : kSequenceKinds) {
    kinds += (kinds.empty() ? "`" : ", `") + std::string(kind) + "`";
  }
  EXPECT_NE(ReadText("schema/FORMAT.md").find("| kind | TEXT | " + kinds + " |"), std::string::npos)
      << kinds;
}

inline constexpr TableDescriptor kMadeTable{
    "made", 1,
    std::array{IntegerColumn("id"), OrNull(RealColumn("x")), TextColumn("name"),
               OrNull(BlobColumn("data"))}};

TEST(Tables, ListColumnsAsTheyAreStored) {
  EXPECT_EQ(ColumnList(kMadeTable), "id, x, name, data_crc32c, data");
  EXPECT_EQ(StoredColumns(kMadeTable), 5);
}

TEST(Tables, SayWhichValuesFit) {
  EXPECT_TRUE(FitsColumn<int>(IntegerColumn("a")));
  EXPECT_TRUE(FitsColumn<KeyframeId>(IntegerColumn("a")));
  EXPECT_TRUE(FitsColumn<FeatureType>(IntegerColumn("a")));
  EXPECT_FALSE(FitsColumn<double>(IntegerColumn("a")));
  EXPECT_FALSE(FitsColumn<int>(RealColumn("a")));
  EXPECT_FALSE(FitsColumn<std::string>(BlobColumn("a")));
  EXPECT_TRUE(FitsColumn<Bytes>(BlobColumn("a")));
  EXPECT_FALSE(FitsColumn<std::nullptr_t>(TextColumn("a")));
  EXPECT_TRUE(FitsColumn<std::nullptr_t>(OrNull(TextColumn("a"))));
  EXPECT_FALSE(FitsColumn<std::optional<double>>(RealColumn("a")));
  EXPECT_TRUE(FitsColumn<std::optional<double>>(OrNull(RealColumn("a"))));
}

class MadeTable : public testing::Test {
 protected:
  MadeTable() : database_(":memory:", SQLite::OPEN_READWRITE) {
    database_.exec(
        "CREATE TABLE made (id INTEGER PRIMARY KEY, x REAL, name TEXT NOT NULL,"
        " data_crc32c INTEGER, data BLOB) STRICT");
    RowSink sink(database_);
    TableWriter<kMadeTable> writer(sink);
    writer.Row(7, 0.5, std::string("first"), Bytes{1, 2, 3});
    writer.Row(KeyframeId{8}, nullptr, std::string(), nullptr);
    bytes_ = sink.bytes();
  }

  SQLite::Database database_;
  int64_t bytes_ = 0;
};

TEST_F(MadeTable, ReadsWhatWasWritten) {
  SQLite::Statement rows(database_, "SELECT " + ColumnList(kMadeTable) + " FROM made ORDER BY 1");
  ASSERT_TRUE(rows.executeStep());
  Row row(rows, kMadeTable);
  EXPECT_EQ(row.Where(), "made 7");
  EXPECT_EQ(row.Int(), 7);
  EXPECT_EQ(row.OptionalReal(), 0.5);
  EXPECT_EQ(row.Text(), "first");
  const BytesView data = row.Blob(3);
  EXPECT_EQ(Bytes(data.begin(), data.end()), (Bytes{1, 2, 3}));
  row.CheckComplete();
  ASSERT_TRUE(rows.executeStep());
  Row second(rows, kMadeTable);
  EXPECT_EQ(second.Int(), 8);
  EXPECT_EQ(second.OptionalReal(), std::nullopt);
  EXPECT_EQ(second.Text(), "");
  EXPECT_TRUE(second.IsNull());
}

TEST_F(MadeTable, RefusesToBeReadOtherwise) {
  SQLite::Statement rows(database_, "SELECT " + ColumnList(kMadeTable) + " FROM made");
  ASSERT_TRUE(rows.executeStep());
  Row row(rows, kMadeTable);
  EXPECT_THROW(row.Real(), CheckFailure);  // an INTEGER
  row.Int();
  EXPECT_THROW(row.CheckComplete(), CheckFailure);  // x, name and data weren't read
  row.Real();
  row.Text();
  row.BlobOfRows(1);
  EXPECT_THROW(row.Int(), CheckFailure);  // there is no fifth column
}

TEST_F(MadeTable, CountsBytesWithoutADatabase) {
  RowSink counter;
  TableWriter<kMadeTable> writer(counter);
  writer.Row(7, 0.5, std::string("first"), Bytes{1, 2, 3});
  writer.Row(KeyframeId{8}, nullptr, std::string(), nullptr);
  EXPECT_EQ(counter.bytes(), bytes_);
  EXPECT_EQ(counter.bytes(), (8 + 8 + 5 + 8 + 3) + 8);
}

}  // namespace
}  // namespace waystone
