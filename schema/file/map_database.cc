// SPDX-License-Identifier: Apache-2.0
#include "schema/file/map_database.h"

#include <SQLiteCpp/Statement.h>
#include <sqlite3.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <string_view>
#include <system_error>

#include "core/base/error.h"

namespace waystone {
namespace {

namespace fs = std::filesystem;

constexpr int kHeaderBytes = 100;
constexpr std::string_view kMagic("SQLite format 3\0", 16);
// Small pages keep small maps small; a blob lies across as many as it needs at 4 bytes a page.
constexpr int kPageBytes = 1024;

[[noreturn]] void ThrowUnreadable(const fs::path& path, const std::string& cause) {
  throw MapError(ErrorCode::kFileUnreadable,
                 path.string() + ": " + cause + "; check the path and its permissions");
}

[[noreturn]] void ThrowNotAMap(const fs::path& path, const std::string& cause) {
  throw MapError(ErrorCode::kNotAMap, path.string() + " is not a Waystone map: " + cause +
                                          "; expected a file written by `waystone build`");
}

void CheckRegular(const fs::path& path) {
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (!fs::exists(status)) ThrowUnreadable(path, error ? error.message() : "no such file");
  if (fs::is_directory(status)) ThrowUnreadable(path, "is a folder");
  if (!fs::is_regular_file(status)) ThrowUnreadable(path, "is not a regular file");
}

// SQLite's own header is big-endian.
uint32_t BigEndian(const char* bytes, int count) {
  uint32_t value = 0;
  for (int i = 0; i < count; ++i) value = (value << 8) | static_cast<unsigned char>(bytes[i]);
  return value;
}

// A path as SQLite's file: URI takes it: everything that could mean something else is escaped.
std::string UriOf(const fs::path& path) {
  static constexpr char kDigits[] = "0123456789ABCDEF";
  static constexpr std::string_view kPlain =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789-_.~/";
  std::string uri = "file:";
  for (const char c : fs::absolute(path).string()) {
    if (kPlain.find(c) != std::string_view::npos) {
      uri += c;
    } else {
      uri += '%';
      uri += kDigits[static_cast<unsigned char>(c) >> 4];
      uri += kDigits[static_cast<unsigned char>(c) & 15];
    }
  }
  return uri + "?mode=ro&immutable=1";
}

void SetUp(SQLite::Database& database) {
  database.exec(
      "PRAGMA foreign_keys = ON; PRAGMA temp_store = MEMORY; PRAGMA trusted_schema = OFF;"
      "PRAGMA cell_size_check = ON;");
}

}  // namespace

MapHeader ReadMapHeader(const fs::path& path) {
  CheckRegular(path);
  std::ifstream in(path, std::ios::binary);
  if (!in) ThrowUnreadable(path, std::strerror(errno));
  std::array<char, kHeaderBytes> bytes{};
  in.read(bytes.data(), bytes.size());
  const std::streamsize count = in.gcount();
  if (count == 0) ThrowNotAMap(path, "it is empty");
  if (std::string_view(bytes.data(), std::min<size_t>(count, kMagic.size())) != kMagic) {
    ThrowNotAMap(path, "it is not an SQLite database");
  }
  const uint32_t page_bytes = BigEndian(&bytes[16], 2);
  MapHeader header;
  header.schema_version = static_cast<int32_t>(BigEndian(&bytes[60], 4));
  header.application_id = static_cast<int32_t>(BigEndian(&bytes[68], 4));
  header.claimed_bytes =
      static_cast<int64_t>(page_bytes == 1 ? 65536 : page_bytes) * BigEndian(&bytes[28], 4);
  in.clear();
  header.file_bytes = in.seekg(0, std::ios::end).tellg();
  if (count == kHeaderBytes && header.application_id != kApplicationId) {
    ThrowNotAMap(path, "it is an SQLite database of another program (application_id " +
                           std::to_string(header.application_id) + ")");
  }
  return header;
}

void CheckVersion(const fs::path& path, int file_version, int program_version) {
  if (file_version == program_version) return;
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

SQLite::Database OpenReadOnly(const fs::path& path) {
  CheckRegular(path);
  try {
    SQLite::Database database(UriOf(path), SQLite::OPEN_READONLY | SQLite::OPEN_URI);
    // A file that was made to harm gets no function and no write through its schema.
    sqlite3_db_config(database.getHandle(), SQLITE_DBCONFIG_DEFENSIVE, 1, nullptr);
    SetUp(database);
    return database;
  } catch (const SQLite::Exception& error) {
    ThrowUnreadable(path, error.what());
  }
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
