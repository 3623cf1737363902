// SPDX-License-Identifier: Apache-2.0
#include "tests/faults/memory/failing_memory.h"

#include <dlfcn.h>
#include <gtest/gtest.h>
#include <unwind.h>

#include <atomic>
#include <cerrno>
#include <cstddef>
#include <cstring>
#include <unordered_set>

// NOLINTBEGIN(bugprone-reserved-identifier,readability-identifier-naming): the C library's names
extern "C" {
// Its own, by their second names.
void* __libc_malloc(size_t size);
void* __libc_calloc(size_t count, size_t size);
void* __libc_realloc(void* memory, size_t size);
void* __libc_memalign(size_t alignment, size_t size);
}
// NOLINTEND(bugprone-reserved-identifier,readability-identifier-naming)

namespace waystone {
namespace {

constexpr int kPathDepth = 16;

std::atomic<bool> watching = false;
CountedThreads counted_threads = CountedThreads::kThis;
MemoryFault current_fault;
std::atomic<int64_t> allocations = 0;
std::atomic<int64_t> failures = 0;

// Of the thread that made the FailingMemory.
thread_local bool is_owner = false;
// What is done about an allocation allocates itself.
thread_local bool is_inside = false;

struct Paths {
  std::unordered_set<uint64_t> seen;
  std::vector<int64_t> first;
};
Paths* paths = nullptr;  // while they are looked for

struct PathHash {
  uint64_t value = 0;
  int depth = 0;
};

_Unwind_Reason_Code AddFrame(_Unwind_Context* context, void* argument) {
  auto* hash = static_cast<PathHash*>(argument);
  hash->value = (hash->value ^ _Unwind_GetIP(context)) * 0x9E3779B97F4A7C15U;
  hash->value ^= hash->value >> 29;
  return ++hash->depth < kPathDepth ? _URC_NO_REASON : _URC_END_OF_STACK;
}

void RecordPath(int64_t allocation) {
  is_inside = true;
  PathHash hash;
  _Unwind_Backtrace(AddFrame, &hash);
  if (paths->seen.insert(hash.value).second) paths->first.push_back(allocation);
  is_inside = false;
}

// OpenCV's SIFT ends the program at some of its allocations: destructors of what it uses
// (BufferArea, TLSDataAccumulator) assert that they got memory, or ask for more. Nothing of ours
// can help there, so its allocations are left out.
_Unwind_Reason_Code FindFeatures2d(_Unwind_Context* context, void* found) {
  Dl_info info{};
  const auto* at =
      reinterpret_cast<void*>(_Unwind_GetIP(context));  // NOLINT(performance-no-int-to-ptr)
  if (dladdr(at, &info) == 0 || info.dli_fname == nullptr) return _URC_NO_REASON;
  if (std::strstr(info.dli_fname, "opencv_features2d") == nullptr) return _URC_NO_REASON;
  *static_cast<bool*>(found) = true;
  return _URC_END_OF_STACK;
}

bool IsInSift() {
  is_inside = true;
  bool found = false;
  _Unwind_Backtrace(FindFeatures2d, &found);
  is_inside = false;
  return found;
}

// Whether the allocation that is asked for now fails.
bool Fails() {
  if (!watching || is_inside) return false;
  if (is_owner != (counted_threads == CountedThreads::kThis)) return false;
  const int64_t allocation = allocations++;
  if (paths != nullptr) RecordPath(allocation);
  const int64_t first = current_fault.allocation;
  if (first < 0 || allocation < first || allocation > first + current_fault.more) return false;
  if (IsInSift()) return false;
  ++failures;
  errno = ENOMEM;
  return true;
}

}  // namespace

FailingMemory::FailingMemory(CountedThreads threads, const MemoryFault& fault) {
  EXPECT_FALSE(watching) << "one at a time";
  counted_threads = threads;
  current_fault = fault;
  allocations = failures = 0;
  is_owner = true;
  watching = true;
}

FailingMemory::~FailingMemory() {
  watching = false;
  is_owner = false;
}

int64_t FailingMemory::count() { return allocations; }
int64_t FailingMemory::failed() { return failures; }

std::vector<int64_t> FindAllocationPaths(const std::function<void()>& run) {
  Paths found;
  paths = &found;
  {
    const FailingMemory watched(CountedThreads::kThis, {});
    run();
  }
  paths = nullptr;
  return std::move(found.first);
}

}  // namespace waystone

extern "C" {

void* malloc(size_t size) { return waystone::Fails() ? nullptr : __libc_malloc(size); }

void* calloc(size_t count, size_t size) {
  return waystone::Fails() ? nullptr : __libc_calloc(count, size);
}

void* realloc(void* memory, size_t size) {
  return waystone::Fails() ? nullptr : __libc_realloc(memory, size);
}

// NOLINTNEXTLINE(readability-identifier-naming)
void* memalign(size_t alignment, size_t size) {
  return waystone::Fails() ? nullptr : __libc_memalign(alignment, size);
}

void* aligned_alloc(size_t alignment, size_t size) {
  return waystone::Fails() ? nullptr : __libc_memalign(alignment, size);
}

int posix_memalign(void** memory, size_t alignment, size_t size) {
  void* const taken = waystone::Fails() ? nullptr : __libc_memalign(alignment, size);
  if (taken == nullptr) return ENOMEM;
  *memory = taken;
  return 0;
}

}  // extern "C"
