// SPDX-License-Identifier: Apache-2.0
#include "schema/file/map_database.h"

#include <SQLiteCpp/Statement.h>
#include <fcntl.h>
#include <sqlite3.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <new>
#include <string_view>

#include "core/base/error.h"
#include "schema/tables/memory.h"

namespace waystone {
namespace {

namespace fs = std::filesystem;

constexpr int kHeaderBytes = 100;
constexpr std::string_view kMagic("SQLite format 3\0", 16);
// Small pages keep small maps small; a blob spans as many pages as it needs, at 4 bytes each.
constexpr int kPageBytes = 1024;
// The format version in the header of a database whose newest rows may lie in another file.
constexpr unsigned char kWal = 2;
// Instructions that SQLite may take to read a schema: about ten per object, and a map has 50
// objects.
constexpr int64_t kSchemaSteps = 20'000;
constexpr int kStepsBetweenChecks = 1000;

struct Limit {
  int id;
  int value;
};
// Several times what the statements of this program and the definitions of a map need.
constexpr std::array kLimits{
    Limit{SQLITE_LIMIT_SQL_LENGTH, 20'000},   Limit{SQLITE_LIMIT_COLUMN, 200},
    Limit{SQLITE_LIMIT_EXPR_DEPTH, 100},      Limit{SQLITE_LIMIT_COMPOUND_SELECT, 10},
    Limit{SQLITE_LIMIT_VDBE_OP, 250'000},     Limit{SQLITE_LIMIT_FUNCTION_ARG, 10},
    Limit{SQLITE_LIMIT_ATTACHED, 0},          Limit{SQLITE_LIMIT_LIKE_PATTERN_LENGTH, 100},
    Limit{SQLITE_LIMIT_VARIABLE_NUMBER, 100}, Limit{SQLITE_LIMIT_TRIGGER_DEPTH, 1},
    Limit{SQLITE_LIMIT_WORKER_THREADS, 0}};
// A shorter limit would refuse SQLite's own messages.
constexpr int64_t kLeastLength = 100'000;
constexpr int64_t kSpareHeapBytes = 64'000'000;

[[noreturn]] void ThrowUnreadable(
    const fs::path& path, const std::string& cause,
    const std::string& remedy = "check the path and its permissions") {
  throw MapError(ErrorCode::kFileUnreadable, path.string() + ": " + cause + "; " + remedy);
}

[[noreturn]] void ThrowNotAMap(const fs::path& path, const std::string& cause) {
  throw MapError(ErrorCode::kNotAMap, path.string() + " is not a Waystone map: " + cause +
                                          "; expected a file written by `waystone build`");
}

// A file that is open for reading.
class File {
 public:
  explicit File(const fs::path& path) : path_(path) {
    // A pipe would wait for its other end.
    descriptor_ = open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
    if (descriptor_ < 0) ThrowUnreadable(path, std::strerror(errno));
    const mode_t mode = Status().st_mode;
    if (S_ISREG(mode)) return;
    close(descriptor_);
    ThrowUnreadable(path, S_ISDIR(mode) ? "is a folder" : "is not a regular file");
  }
  ~File() { close(descriptor_); }
  File(const File&) = delete;
  File& operator=(const File&) = delete;

  struct stat Status() const {
    struct stat status {};
    if (fstat(descriptor_, &status) != 0) ThrowUnreadable(path_, std::strerror(errno));
    return status;
  }

  // Fills `bytes` from the start of the file and returns how many bytes there were.
  size_t Read(std::span<unsigned char> bytes) const {
    size_t count = 0;
    while (count < bytes.size()) {
      const ssize_t read =
          pread(descriptor_, bytes.data() + count, bytes.size() - count, static_cast<off_t>(count));
      if (read < 0 && errno == EINTR) continue;
      if (read < 0) ThrowUnreadable(path_, std::strerror(errno));
      if (read == 0) break;
      count += static_cast<size_t>(read);
    }
    return count;
  }

 private:
  const fs::path& path_;
  int descriptor_ = -1;
};

bool SameState(const struct stat& a, const struct stat& b) {
  return a.st_size == b.st_size && a.st_mtim.tv_sec == b.st_mtim.tv_sec &&
         a.st_mtim.tv_nsec == b.st_mtim.tv_nsec;
}

// SQLite's own header is big-endian.
uint32_t BigEndian(const unsigned char* bytes, int count) {
  uint32_t value = 0;
  for (int i = 0; i < count; ++i) value = (value << 8) | bytes[i];
  return value;
}

void SetUp(SQLite::Database& database) {
  database.exec(
      "PRAGMA foreign_keys = ON; PRAGMA temp_store = MEMORY; PRAGMA trusted_schema = OFF;"
      "PRAGMA cell_size_check = ON;");
}

int CountSteps(void* steps_left) {
  auto& left = *static_cast<int64_t*>(steps_left);
  left -= kStepsBetweenChecks;
  return left < 0 ? 1 : 0;
}

// What SQLite may allocate for a file: pages are read through a cache of 2 MB, schemas are small,
// and there are one or two copies of a value, which is no longer than the file. Sound maps take a
// tenth of it.
int64_t HeapBytes(int64_t file_bytes) { return kSpareHeapBytes + 2 * file_bytes; }

// Bounds for an untrusted file, in addition to that of the heap.
void Restrict(OpenedMap& map) {
  sqlite3* handle = map.database.getHandle();
  // Neither functions, nor triggers, nor views, nor writes through the schema.
  sqlite3_db_config(handle, SQLITE_DBCONFIG_DEFENSIVE, 1, nullptr);
  sqlite3_db_config(handle, SQLITE_DBCONFIG_TRUSTED_SCHEMA, 0, nullptr);
  sqlite3_db_config(handle, SQLITE_DBCONFIG_ENABLE_TRIGGER, 0, nullptr);
  sqlite3_db_config(handle, SQLITE_DBCONFIG_ENABLE_VIEW, 0, nullptr);
  for (const Limit& limit : kLimits) sqlite3_limit(handle, limit.id, limit.value);
  const int64_t length = std::clamp<int64_t>(map.header.file_bytes, kLeastLength,
                                             sqlite3_limit(handle, SQLITE_LIMIT_LENGTH, -1));
  sqlite3_limit(handle, SQLITE_LIMIT_LENGTH, static_cast<int>(length));
  *map.steps_left = kSchemaSteps;
  sqlite3_progress_handler(handle, kStepsBetweenChecks, CountSteps, map.steps_left.get());
}

MapHeader ReadHeader(const fs::path& path, const File& file) {
  std::array<unsigned char, kHeaderBytes> bytes{};
  const size_t count = file.Read(bytes);
  if (count == 0) ThrowNotAMap(path, "it is empty");
  if (!std::ranges::equal(std::span(bytes).first(std::min(count, kMagic.size())), kMagic)) {
    ThrowNotAMap(path, "it is not an SQLite database");
  }
  const uint32_t page_bytes = BigEndian(&bytes[16], 2);
  MapHeader header;
  header.schema_version = static_cast<int32_t>(BigEndian(&bytes[60], 4));
  header.application_id = static_cast<int32_t>(BigEndian(&bytes[68], 4));
  header.claimed_bytes =
      static_cast<int64_t>(page_bytes == 1 ? 65536 : page_bytes) * BigEndian(&bytes[28], 4);
  header.file_bytes = file.Status().st_size;
  header.free_pages = BigEndian(&bytes[36], 4);
  if (count == kHeaderBytes && header.application_id != kApplicationId) {
    ThrowNotAMap(path, "it is an SQLite database of another program (application_id " +
                           std::to_string(header.application_id) + ")");
  }
  return header;
}

OpenedMap OpenBytes(const fs::path& path) {
  const File file(path);
  const struct stat before = file.Status();
  OpenedMap map{ReadHeader(path, file),
                std::vector<unsigned char>(static_cast<size_t>(before.st_size)),
                std::make_unique<int64_t>(0), HeapBound(HeapBytes(before.st_size)),
                SQLite::Database(":memory:", SQLite::OPEN_READWRITE)};
  if (file.Read(map.bytes) != map.bytes.size() || !SameState(before, file.Status())) {
    ThrowUnreadable(path, "is being written to", "write maps beside and rename them (mv)");
  }
  if (map.bytes.size() >= kHeaderBytes && (map.bytes[18] == kWal || map.bytes[19] == kWal)) {
    throw MapError(ErrorCode::kMapDamaged,
                   path.string() + " was switched to a write-ahead log by another program; run " +
                       "`sqlite3 FILE 'PRAGMA journal_mode = DELETE'` on it");
  }
  const auto size = static_cast<sqlite3_int64>(map.bytes.size());
  // The bytes aren't examined yet: the only possible failure is a lack of memory.
  if (sqlite3_deserialize(map.database.getHandle(), "main", map.bytes.data(), size, size,
                          SQLITE_DESERIALIZE_READONLY) != SQLITE_OK) {
    throw std::bad_alloc();
  }
  SetUp(map.database);
  Restrict(map);
  return map;
}

}  // namespace

MapHeader ReadMapHeader(const fs::path& path) { return ReadHeader(path, File(path)); }

void CheckVersion(const fs::path& path, int file_version, int program_version) {
  if (file_version == program_version) return;
  if (file_version < 0) {
    throw MapError(ErrorCode::kMapVersion,
                   path.string() + " has schema version " + std::to_string(file_version) +
                       ", which no Waystone wrote; restore the map from a backup or rebuild it");
  }
  const bool newer = file_version > program_version;
  throw MapError(ErrorCode::kMapVersion,
                 path.string() + " has schema version " + std::to_string(file_version) + " and " +
                     "this program has version " + std::to_string(program_version) + "; " +
                     (newer ? "use a newer Waystone" : "run `waystone migrate` on it"));
}

std::optional<MapProblem> FindCut(const MapHeader& header) {
  if (header.file_bytes == header.claimed_bytes) return {};
  return MapProblem{"file", "has " + std::to_string(header.file_bytes) +
                                " bytes where its header " + "says " +
                                std::to_string(header.claimed_bytes)};
}

OpenedMap OpenReadOnly(const fs::path& path) {
  return WithCheckedMemory([&] { return OpenBytes(path); });
}

SQLite::Database OpenForWriting(const fs::path& path) {
  SQLite::Database database(fs::absolute(path).string(), SQLite::OPEN_READWRITE);
  SetUp(database);
  database.exec("PRAGMA page_size = " + std::to_string(kPageBytes) +
                "; PRAGMA auto_vacuum = NONE; PRAGMA encoding = 'UTF-8';"
                "PRAGMA journal_mode = OFF; PRAGMA synchronous = OFF;"
                "PRAGMA locking_mode = EXCLUSIVE;");
  return database;
}

std::string DescribeError(SQLite::Database& database, const SQLite::Exception& error) {
  const int cause = sqlite3_system_errno(database.getHandle());
  if (cause == 0) return error.what();
  return std::string(std::strerror(cause)) + " (" + error.what() + ")";
}

void ApplyMigrations(SQLite::Database& database, std::span<const Migration> steps,
                     int from_version) {
  for (const Migration& step : steps.subspan(from_version)) database.exec(step.sql);
  database.exec("PRAGMA user_version = " + std::to_string(steps.size()));
}

}  // namespace waystone
