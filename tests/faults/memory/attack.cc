// SPDX-License-Identifier: Apache-2.0
#include "tests/faults/memory/attack.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <iostream>
#include <new>
#include <vector>

#include "tests/faults/memory/failing_memory.h"

namespace waystone {
namespace {

// At most `most` of the numbers, evenly spread.
std::vector<int64_t> Share(const std::vector<int64_t>& numbers, int64_t most) {
  const int64_t count = std::min(std::ssize(numbers), most);
  std::vector<int64_t> share;
  for (int64_t i = 0; i < count; ++i) share.push_back(numbers[i * std::ssize(numbers) / count]);
  return share;
}

// How many times the limits: 1, or what WAYSTONE_ATTACK_SCALE says.
int64_t Scale() {
  const char* scale = std::getenv("WAYSTONE_ATTACK_SCALE");
  return scale == nullptr ? 1 : std::max(int64_t{1}, int64_t{std::strtoll(scale, nullptr, 10)});
}

// Whether std::bad_alloc was thrown.
bool RunWith(const MemoryFault& fault, const std::function<void()>& run) {
  const FailingMemory failing(CountedThreads::kThis, fault);
  try {
    run();
    return false;
  } catch (const std::bad_alloc&) {
    return true;
  }
}

}  // namespace

MemoryAttack AttackMemory(const std::string& name, const std::function<void()>& run,
                          const std::function<void(bool threw)>& check,
                          const AttackLimits& limits) {
  MemoryAttack attack;
  run();  // what is made once for the process
  check(false);
  const std::vector<int64_t> paths = FindAllocationPaths(run);
  check(false);
  attack.allocations = FailingMemory::count();
  attack.paths = std::ssize(paths);
  for (const int64_t more : {int64_t{0}, kAllAfter}) {
    const int64_t most = Scale() * (more == 0 ? limits.single : limits.lasting);
    for (const int64_t allocation : Share(paths, most)) {
      SCOPED_TRACE("allocation " + std::to_string(allocation) + (more == 0 ? "" : " and on"));
      const bool threw = RunWith({.allocation = allocation, .more = more}, run);
      ++attack.runs;
      attack.hit += FailingMemory::failed() > 0 ? 1 : 0;
      attack.threw += threw ? 1 : 0;
      check(threw);
      if (testing::Test::HasFatalFailure()) return attack;
    }
  }
  std::cout << name << ": " << attack.allocations << " allocations by " << attack.paths
            << " paths, " << attack.runs << " runs, " << attack.hit << " hit, " << attack.threw
            << " threw\n";
  EXPECT_GT(attack.hit, attack.runs / 2);  // not where SIFT alone allocates
  return attack;
}

}  // namespace waystone
