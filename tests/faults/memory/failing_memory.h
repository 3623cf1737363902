// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

// The program that links failing_memory.cc takes the place of the C library's malloc, for itself
// and for every library it loads: operator new, SQLite, OpenCV, TBB and the image decoders get
// their memory from here.
namespace waystone {

// The threads whose allocations count: the one that says so, or all others.
enum class CountedThreads { kThis, kOthers };

// What fails: the allocation of this number, from 0, and `more` after it.
struct MemoryFault {
  int64_t allocation = -1;  // none
  int64_t more = 0;
};
inline constexpr int64_t kAllAfter = INT64_MAX / 2;

// Counts allocations as long as it lives, and fails those that `fault` names. One at a time.
class FailingMemory {
 public:
  FailingMemory(CountedThreads threads, const MemoryFault& fault);
  FailingMemory(const FailingMemory&) = delete;
  FailingMemory& operator=(const FailingMemory&) = delete;
  ~FailingMemory();

  static int64_t count();   // of allocations so far
  static int64_t failed();  // of those
};

// The numbers of the allocations that `run` makes on this thread, but of those by one path of calls
// (the innermost 16 return addresses) the first one alone.
std::vector<int64_t> FindAllocationPaths(const std::function<void()>& run);

}  // namespace waystone
