// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace waystone {

// While it exists, SQLite's heap is bounded: by this many bytes more than the other existing bounds
// allow. SQLite has one bound for the whole process, so that maps opened at the same time share the
// sum of theirs, and databases that are written meanwhile use it too; without any HeapBound there
// is none. Exceeding it gives std::bad_alloc (schema/tables/memory.h). Thread-safe.
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
