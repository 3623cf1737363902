// SPDX-License-Identifier: Apache-2.0
#include "api/json_value.h"

#include <array>
#include <cstddef>
#include <cstdlib>
#include <functional>
#include <mutex>
#include <new>

namespace waystone {
namespace {

// Enough for the values of several requests, which fail at their next other allocation.
struct Reserve {
  std::mutex mutex;
  alignas(std::max_align_t) std::array<std::byte, 1 << 20> bytes;
  size_t used = 0;
  int blocks = 0;  // in use; the reserve is empty again when the last one is freed

  bool Holds(const void* block) const {
    return std::less_equal<>()(static_cast<const void*>(bytes.data()), block) &&
           std::less<>()(block, static_cast<const void*>(bytes.data() + bytes.size()));
  }
};

Reserve& TheReserve() {
  static Reserve reserve;
  return reserve;
}

}  // namespace

void* AllocateForJson(size_t count, size_t size_each) {
  size_t bytes = 0;
  if (__builtin_mul_overflow(count, size_each, &bytes)) throw std::bad_array_new_length();
  if (void* block = std::malloc(bytes)) return block;
  constexpr size_t kAlignment = alignof(std::max_align_t);
  const size_t blocks = bytes / kAlignment + (bytes % kAlignment != 0 ? 1 : 0);
  Reserve& reserve = TheReserve();
  const std::lock_guard guard(reserve.mutex);
  if (blocks > (reserve.bytes.size() - reserve.used) / kAlignment) throw std::bad_alloc();
  void* block = reserve.bytes.data() + reserve.used;
  reserve.used += blocks * kAlignment;
  ++reserve.blocks;
  return block;
}

void FreeOfJson(void* memory) {
  Reserve& reserve = TheReserve();
  if (!reserve.Holds(memory)) return std::free(memory);
  const std::lock_guard guard(reserve.mutex);
  if (--reserve.blocks == 0) reserve.used = 0;
}

}  // namespace waystone
