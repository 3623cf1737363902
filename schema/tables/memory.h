// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <SQLiteCpp/Database.h>
#include <SQLiteCpp/Exception.h>
#include <sqlite3.h>

#include <new>

// SQLite says by a code that memory has run out; here it is std::bad_alloc as everywhere else, so
// that no sound map is called damaged for it.
namespace waystone {

inline void CheckMemory(const SQLite::Exception& error) {
  if (error.getErrorCode() == SQLITE_NOMEM) throw std::bad_alloc();
}

// The same by SQLite's last call.
inline void CheckMemory(SQLite::Database& database) {
  if (database.getErrorCode() == SQLITE_NOMEM) throw std::bad_alloc();
}

// What `make` returns.
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
