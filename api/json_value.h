// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <type_traits>
#include <vector>

namespace waystone {

// Allocates memory for JSON values, from a reserve when memory has run out, which the library can't
// handle: its destructors allocate, and a value whose object or array couldn't be allocated has a
// dangling pointer. Throws std::bad_alloc when the reserve is used up, too. Both functions are
// thread-safe.
void* AllocateForJson(size_t count, size_t size_each);
void FreeOfJson(void* memory);

template <class T>
class JsonAllocator : public std::allocator<T> {
 public:
  // NOLINTBEGIN(readability-identifier-naming): the standard library's names
  template <class U>
  struct rebind {
    using other = JsonAllocator<U>;
  };
  // NOLINTEND(readability-identifier-naming)
  JsonAllocator() = default;
  template <class U>
  explicit(false) JsonAllocator(const JsonAllocator<U>&) {}
  T* allocate(size_t count) { return static_cast<T*>(AllocateForJson(count, sizeof(T))); }
  void deallocate(T* values, size_t) { FreeOfJson(values); }
};

// nlohmann::ordered_json with our own allocator. Only the list of a value's children that the
// library's destructor makes still uses std::allocator<Json>.
using Json = nlohmann::basic_json<nlohmann::ordered_map, std::vector, std::string, bool, int64_t,
                                  uint64_t, double, JsonAllocator>;

}  // namespace waystone

// For the list of children that the library's destructor makes.
template <>
class std::allocator<waystone::Json> {
 public:
  // NOLINTBEGIN(readability-identifier-naming): the standard library's names
  using value_type = waystone::Json;
  using size_type = std::size_t;
  using difference_type = std::ptrdiff_t;
  using propagate_on_container_move_assignment = std::true_type;
  // NOLINTEND(readability-identifier-naming)

  constexpr allocator() = default;
  template <class U>
  explicit(false) constexpr allocator(const std::allocator<U>&) {}
  waystone::Json* allocate(std::size_t count) {
    return static_cast<waystone::Json*>(waystone::AllocateForJson(count, sizeof(waystone::Json)));
  }
  void deallocate(waystone::Json* values, std::size_t) { waystone::FreeOfJson(values); }
  bool operator==(const allocator&) const = default;
};
