// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <utility>

#include "core/base/error.h"

namespace waystone {

static_assert(std::endian::native == std::endian::little);

// Reads little-endian values one after the other from the front of a buffer. Not thread-safe.
class ByteReader {
 public:
  // Throws `cut` where the bytes end too early. The bytes must outlive the reader.
  ByteReader(std::span<const uint8_t> bytes, MapError cut) : left_(bytes), cut_(std::move(cut)) {}

  template <class Value>
  Value Take() {
    Value value;
    std::memcpy(&value, Skip(sizeof(value)).data(), sizeof(value));
    return value;
  }

  // Text up to a zero byte, which is skipped.
  std::string TakeText() {
    const auto end = std::ranges::find(left_, uint8_t{0});
    if (end == left_.end()) Fail();
    std::string text(left_.begin(), end);
    Skip(text.size() + 1);
    return text;
  }

  std::span<const uint8_t> Skip(size_t bytes) {
    if (bytes > left_.size()) Fail();
    const std::span<const uint8_t> skipped = left_.first(bytes);
    left_ = left_.subspan(bytes);
    return skipped;
  }

  // The number of items that follow, each of at least `bytes` bytes: never more than there is room
  // for.
  uint64_t TakeCount(size_t bytes) {
    const auto count = Take<uint64_t>();
    if (count > left_.size() / bytes) Fail();
    return count;
  }

 private:
  [[noreturn]] void Fail() const { throw MapError(cut_.code(), cut_.what()); }

  std::span<const uint8_t> left_;
  MapError cut_;
};

}  // namespace waystone
