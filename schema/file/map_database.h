// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <SQLiteCpp/Database.h>
#include <SQLiteCpp/Exception.h>

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "schema/file/heap_bound.h"
#include "schema/file/map_store.h"
#include "schema/file/migrate.h"

// A map file as a database: opening it without trusting it, and what must hold whatever its tables
// mean. SQLite's own errors are thrown as SQLite::Exception unless stated otherwise. All functions
// are thread-safe for different databases.
namespace waystone {

// The first 100 bytes of a file, read without SQLite.
struct MapHeader {
  int32_t application_id = 0;
  int32_t schema_version = 0;
  int64_t claimed_bytes = 0;  // page size times pages
  int64_t file_bytes = 0;
  int64_t free_pages = 0;
};

// Throws MapError: kFileUnreadable, or kNotAMap for bytes that don't start as SQLite's do or that
// belong to another application.
MapHeader ReadMapHeader(const std::filesystem::path& path);

// Throws MapError(kMapVersion), naming both versions and the remedy, unless they are equal.
void CheckVersion(const std::filesystem::path& path, int file_version, int program_version);

// A problem when the file is shorter or longer than its header says.
std::optional<MapProblem> FindCut(const MapHeader& header);

// A map file that was read into memory through one descriptor: header, bytes and tables belong to
// one file, whatever is renamed onto its path meanwhile.
struct OpenedMap {
  MapHeader header;
  std::vector<unsigned char> bytes;  // the whole file; the database reads from them
  // How many more instructions SQLite may run for it. A statement that exceeds them is interrupted.
  std::unique_ptr<int64_t> steps_left;
  HeapBound heap;             // for SQLite's memory in total
  SQLite::Database database;  // read-only
};

// Opens a map for reading. Nothing is locked, written or created, so read-only folders and media
// are fine. SQLite runs within bounds that a map never reaches: no value is longer than the file, a
// schema has at most some thousand objects, and the time and memory of statements are bounded.
// Reading more than the schema requires that CheckFile has found the map readable. Throws MapError
// as ReadMapHeader does, kMapDamaged for a write-ahead log, and kFileUnreadable for a file that
// changes while it is read.
OpenedMap OpenReadOnly(const std::filesystem::path& path);

// Opens an empty file, or a copy of a map, that nobody else uses, for writing in one go: no
// journal, no flushing; the caller flushes the file and removes it after an error.
SQLite::Database OpenForWriting(const std::filesystem::path& path);

// The system's message for the last error, where it has one ("No space left on device"), and
// SQLite's.
std::string DescribeError(SQLite::Database& database, const SQLite::Exception& error);

// Applies the steps after `from_version` and sets user_version to their count.
void ApplyMigrations(SQLite::Database& database, std::span<const Migration> steps,
                     int from_version);

// An object of a schema by its definition.
struct SchemaObject {
  std::string type;  // "table", "view", "index", "trigger"
  std::string name;
  std::string sql;

  bool operator==(const SchemaObject&) const = default;
};

// What a map made by `steps` consists of.
std::vector<SchemaObject> ExpectedObjects(std::span<const Migration> steps);

// Tables and views of `expected` that are missing or defined differently, and other objects that
// aren't plain (schema/file/plain_objects.h). Reads only definitions and evaluates none. Doesn't
// throw.
std::vector<MapProblem> FindAlteredObjects(SQLite::Database& database,
                                           const std::vector<SchemaObject>& expected);

// `objects` and those optional tables (schema/tables/optional_table.h) that the database has.
std::vector<SchemaObject> WithOptionalObjects(SQLite::Database& database,
                                              std::vector<SchemaObject> objects);

// Fills the table `contents` from the other tables of `objects` and the optional ones.
void WriteContents(SQLite::Database& database, const std::vector<SchemaObject>& objects);

// Tables of `objects`, and optional ones, whose rows aren't those that `contents` was filled from.
// Blobs are left to the CRC beside each. Doesn't throw.
std::vector<MapProblem> FindAlteredContents(SQLite::Database& database,
                                            const std::vector<SchemaObject>& objects);

// What is wrong with a map's file and schema, and whether its rows can be read at all.
struct FileCheck {
  std::vector<MapProblem> problems;
  bool readable = false;
};

// What must hold whatever the rows mean, each step only after the one before: the length that the
// header says, the objects of `expected`, pages that belong to one tree or chain each (or rows
// could repeat without end), and what else integrity_check and foreign_key_check find. Doesn't
// throw.
FileCheck CheckFile(OpenedMap& map, const std::vector<SchemaObject>& expected);

// A problem for pages that belong to no table: bytes without meaning must not be part of the map's
// hash. For a map that CheckFile found readable. Doesn't throw.
std::vector<MapProblem> FindUnusedPages(OpenedMap& map);

// Whether SQLite can list what its pages are used for (dbstat).
bool HasDbstat();

}  // namespace waystone
