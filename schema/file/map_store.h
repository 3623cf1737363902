// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "schema/map_data.h"
#include "schema/tables/map_problem.h"

// Reading, writing and checking map files. All functions are thread-safe; whoever changes a map
// holds a MapLock (schema/file/map_lock.h), so that no change is lost.
namespace waystone {

// Version of the schema that this program writes: SQLite's user_version.
inline constexpr int kSchemaVersion = 6;
// SQLite's application_id of a map file: "WAYS".
inline constexpr int kApplicationId = 0x57415953;

struct WriteOptions {
  // Replace an existing map (always as a whole, by rename). A file that isn't a Waystone map by its
  // header is never replaced: a mistyped name must not cost a photo.
  bool overwrite = false;
};

// Throws what WriteMap would throw because of the path: kFileExists, or kFileUnwritable when the
// folder is missing or read-only. Meant to be called before an hour of work.
void CheckWritable(const std::filesystem::path& path, const WriteOptions& options);

// Writes a map beside `path`, checks and reopens what it wrote, and renames it into place: a reader
// sees the whole map or what was there before. The same data give the same bytes.
// Throws MapError: kFileExists, kFileUnwritable (with the cause and free space), kMapDamaged.
void WriteMap(const MapData& map, const std::filesystem::path& path, const WriteOptions& options);

struct ReadOptions {
  bool images = true;  // read the keyframes' pictures too
};

// Reads a whole map, checking every blob's length and CRC and every reference. The file's bytes are
// in memory meanwhile, so a map renamed onto it does no harm; nothing is ever written. Throws
// MapError: kFileUnreadable, kNotAMap, kMapDamaged, kMapVersion.
MapData ReadMap(const std::filesystem::path& path, const ReadOptions& options = {});

// Writes the contents of `map` that optional tables hold (such as its named places) into a copy of
// the file from which it was read with its images, checks and reopens the copy, and renames it into
// place. Everything else in the map is unchanged, and so are foreign tables. The same file and
// names give the same bytes. Throws MapError: kFileUnreadable for a file that was replaced since it
// was read, kFileUnwritable, kMapDamaged, also for names that don't fit the map (FindMapProblems).
void RewriteOptionalTables(const MapData& map, const std::filesystem::path& path);

// Everything that is wrong with a map, not only the first problem: SQLite's integrity and foreign
// keys, blob lengths and CRCs, homographies finite and invertible, adjacency symmetric (a < b, both
// there, no self loops) and with a homology that has the double eigenvalue, references that exist.
// Empty for a sound map. Throws MapError only when the file can't be opened as a map at all.
std::vector<MapProblem> CheckMap(const std::filesystem::path& path);

// Bytes of each table (SQLite's dbstat where it is compiled in, else the sums of the blobs).
struct TableSize {
  std::string table;
  int64_t rows = 0;
  int64_t bytes = 0;
};
std::vector<TableSize> TableSizes(const std::filesystem::path& path);

// Brings an older map to the current schema by the numbered migrations, in a copy that is renamed
// into place. Returns the version it had. Throws like ReadMap and WriteMap.
int MigrateMap(const std::filesystem::path& path);

}  // namespace waystone
