// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <SQLiteCpp/Database.h>
#include <SQLiteCpp/Exception.h>
#include <sqlite3.h>

#include <new>

// Turns SQLite's error code for running out of memory into std::bad_alloc, as everywhere else, so
// that no sound map is reported as damaged because of it. All functions are thread-safe for
// different databases.
namespace waystone {

inline void CheckMemory(const SQLite::Exception& error) {
  if (error.getErrorCode() == SQLITE_NOMEM) throw std::bad_alloc();
}

// The same for SQLite's last call.
inline void CheckMemory(SQLite::Database& database) {
  if (database.getErrorCode() == SQLITE_NOMEM) throw std::bad_alloc();
}

// Calls `make` and returns its result, with CheckMemory on its exceptions.
template <class Make>
auto WithCheckedMemory(const Make& make) {
  try {
    return make();
  } catch (const SQLite::Exception& error) {
    CheckMemory(error);
    throw;
  }
}

}  // namespace waystone
