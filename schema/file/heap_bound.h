// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace waystone {

// While it exists, SQLite's heap has a bound: this many bytes more than the other bounds that exist
// now allow. SQLite knows one bound for the whole process, so that maps that are opened at the same
// time share the sum of theirs, and databases that are written meanwhile use it too; without any
// HeapBound there is none. What goes beyond it is std::bad_alloc (schema/tables/memory.h).
// Thread-safe.
class HeapBound {
 public:
  explicit HeapBound(int64_t bytes);
  HeapBound(HeapBound&& other) noexcept;
  HeapBound& operator=(HeapBound&&) = delete;
  ~HeapBound();

 private:
  int64_t bytes_;
};

}  // namespace waystone
