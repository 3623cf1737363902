// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <string>

namespace waystone {

// What an attack on a function's memory came to.
struct MemoryAttack {
  int64_t allocations = 0;  // of a run that gets all it wants
  int64_t paths = 0;        // by which these were asked for
  int64_t runs = 0;
  int64_t hit = 0;    // runs in which an allocation failed
  int64_t threw = 0;  // runs that ended with std::bad_alloc
};

struct AttackLimits {
  int64_t single = 200;  // runs in which one allocation fails
  int64_t lasting = 20;  // runs in which all from one on do
};

// Runs `run` once for each path of calls by which it allocates, with the first allocation of that
// path failing; where there are more paths than limits.single, for an even share of them. Then with
// all allocations from one on failing, for an even share of the paths. The environment's
// WAYSTONE_ATTACK_SCALE multiplies the limits. Nothing but std::bad_alloc may leave it. `check` is
// called after each run, those that get all they want included, with whether that was thrown and
// with memory again. Prints what it came to under `name`.
MemoryAttack AttackMemory(const std::string& name, const std::function<void()>& run,
                          const std::function<void(bool threw)>& check,
                          const AttackLimits& limits = {});

}  // namespace waystone
