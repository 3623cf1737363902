// SPDX-License-Identifier: Apache-2.0
// libFuzzer's program for all targets: `fuzz TARGET [OPTION...] [CORPUS...]`.
#include <algorithm>
#include <cstdlib>
#include <iostream>

#include "tests/fuzz/fuzz_targets.h"

extern "C" size_t LLVMFuzzerMutate(uint8_t* data, size_t size, size_t max_size);

namespace {

const waystone::FuzzTarget* target = nullptr;

std::string MutateByLibrary(std::string bytes, size_t max_bytes) {
  const size_t size = std::min(bytes.size(), max_bytes);
  bytes.resize(max_bytes);
  bytes.resize(LLVMFuzzerMutate(reinterpret_cast<uint8_t*>(bytes.data()), size, max_bytes));
  return bytes;
}

}  // namespace

// The target's name among the arguments becomes the option of how long its inputs may be.
extern "C" int LLVMFuzzerInitialize(int* argc, char*** argv) {
  for (const waystone::FuzzTarget& each : waystone::FuzzTargets()) {
    if (*argc > 1 && each.name == (*argv)[1]) target = &each;
  }
  if (target == nullptr) {
    std::cerr << "usage: fuzz TARGET [OPTION...] [CORPUS...]\ntargets:";
    for (const waystone::FuzzTarget& each : waystone::FuzzTargets()) std::cerr << ' ' << each.name;
    std::cerr << '\n';
    std::exit(2);
  }
  static std::string longest = "-max_len=" + std::to_string(target->max_bytes);
  (*argv)[1] = longest.data();
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  target->run({data, size});
  return 0;
}

extern "C" size_t LLVMFuzzerCustomMutator(uint8_t* data, size_t size, size_t max_size,
                                          unsigned seed) {
  if (target->mutate == nullptr) return LLVMFuzzerMutate(data, size, max_size);
  const std::string bytes(reinterpret_cast<const char*>(data), size);
  const std::string mutated = target->mutate(bytes, max_size, seed, MutateByLibrary);
  std::copy(mutated.begin(), mutated.end(), data);
  return mutated.size();
}
