// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <functional>
#include <span>

namespace waystone {

// One step from a schema version to the next. Steps are numbered by their place in the list: the
// first makes version 1 of an empty database. A released step never changes.
struct Migration {
  const char* name;  // "0001_initial.sql"
  const char* sql;
};

// Every step of this program, compiled in; as many as kSchemaVersion. Thread-safe.
std::span<const Migration> Migrations();

// Brings a map to the version that `steps` lead to: applies those it lacks to a copy beside the
// file, passes the copy's path to `check`, and renames it into place. Returns the version it had; a
// map that already has the last version isn't touched. Thread-safe for different files.
// Throws MapError: kFileUnreadable, kNotAMap, kMapDamaged, kMapVersion (newer than the last step),
// kFileUnwritable, and what `check` throws. Whatever it throws, the file is as it was.
int MigrateFile(const std::filesystem::path& path, std::span<const Migration> steps,
                const std::function<void(const std::filesystem::path&)>& check);

}  // namespace waystone
