// SPDX-License-Identifier: Apache-2.0
#include "cli/system/freed_memory.h"

#include <malloc.h>

#include <algorithm>
#include <thread>

namespace waystone {
namespace {

constexpr int kLargestKept = 32 << 20;  // bytes, the most that glibc takes
constexpr int kKept = 256 << 20;        // bytes at the end of the heap

}  // namespace

void KeepFreedMemory() {
  mallopt(M_MMAP_THRESHOLD, kLargestKept);
  mallopt(M_TRIM_THRESHOLD, kKept);
  mallopt(M_ARENA_MAX, std::max(2, static_cast<int>(std::thread::hardware_concurrency())));
}

}  // namespace waystone
