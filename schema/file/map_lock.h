// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <filesystem>

namespace waystone {

// Keeps other processes from changing a map between reading and replacing it, so that no change is
// lost. It is an advisory lock (flock) of the map file that ends with the process at the latest:
// readers and servers take none, and no file is left behind. A map that isn't there, or a file
// system without locks, isn't locked. Not thread-safe.
class MapLock {
 public:
  // Waits for others that change the map. Throws MapError(kFileUnwritable) when they take longer
  // than `wait`.
  explicit MapLock(const std::filesystem::path& path,
                   std::chrono::milliseconds wait = std::chrono::seconds(5));
  ~MapLock();
  MapLock(const MapLock&) = delete;
  MapLock& operator=(const MapLock&) = delete;

 private:
  int descriptor_ = -1;
};

}  // namespace waystone
