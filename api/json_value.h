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

// Memory of JSON values, from a reserve where it has run out: the library can't bear that. Its
// destructors allocate, and a value whose object or array couldn't be made points nowhere. Throws
// std::bad_alloc when the reserve is empty, too.
void* AllocateForJson(size_t bytes);
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
  T* allocate(size_t count) { return static_cast<T*>(AllocateForJson(count * sizeof(T))); }
  void deallocate(T* values, size_t) { FreeOfJson(values); }
};

// nlohmann::ordered_json, but for an allocator of its own: what takes std::allocator<Json> is only
// the list that the library's destructor makes of a value's children.
using Json = nlohmann::basic_json<nlohmann::ordered_map, std::vector, std::string, bool, int64_t,
                                  uint64_t, double, JsonAllocator>;

}  // namespace waystone

// Of the list of children that the library's destructor makes.
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
    return static_cast<waystone::Json*>(waystone::AllocateForJson(count * sizeof(waystone::Json)));
  }
  void deallocate(waystone::Json* values, std::size_t) { waystone::FreeOfJson(values); }
  bool operator==(const allocator&) const = default;
};
