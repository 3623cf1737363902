// SPDX-License-Identifier: Apache-2.0
#include "schema/file/heap_bound.h"

#include <sqlite3.h>

#include <mutex>
#include <utility>

namespace waystone {
namespace {

// Adds to what SQLite may allocate in total; a total of 0 means no bound.
void AllowHeap(int64_t bytes) {
  static std::mutex mutex;
  static int64_t allowed = 0;
  const std::lock_guard lock(mutex);
  allowed += bytes;
  // Removes the bound first: a lower one than before would stay as the soft limit.
  sqlite3_hard_heap_limit64(0);
  sqlite3_hard_heap_limit64(allowed);
}

}  // namespace

HeapBound::HeapBound(int64_t bytes) : bytes_(bytes) { AllowHeap(bytes_); }

HeapBound::HeapBound(HeapBound&& other) noexcept : bytes_(std::exchange(other.bytes_, 0)) {}

HeapBound::~HeapBound() {
  if (bytes_ > 0) AllowHeap(-bytes_);
}

}  // namespace waystone
