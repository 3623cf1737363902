// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <memory>
#include <mutex>

namespace waystone {

// A number of bytes of which maps take shares; a share is given back when the last request that
// uses its map has ended. Thread-safe; a share itself isn't.
class MapMemory : public std::enable_shared_from_this<MapMemory> {
 public:
  class Share {
   public:
    Share(std::shared_ptr<MapMemory> memory, int64_t bytes)
        : memory_(std::move(memory)), bytes_(bytes) {}
    ~Share() { memory_->Give(bytes_); }
    Share(const Share&) = delete;
    Share& operator=(const Share&) = delete;

    int64_t bytes() const { return bytes_; }
    void ShrinkTo(int64_t bytes) {
      memory_->Give(bytes_ - bytes);
      bytes_ = bytes;
    }

   private:
    std::shared_ptr<MapMemory> memory_;
    int64_t bytes_;
  };

  explicit MapMemory(int64_t limit) : limit_(limit) {}

  int64_t limit() const { return limit_; }
  int64_t used() const {
    const std::lock_guard lock(mutex_);
    return used_;
  }
  // A share, waited for at most `patience`; null where there is still no room.
  std::shared_ptr<Share> Take(int64_t bytes, std::chrono::milliseconds patience) {
    std::unique_lock lock(mutex_);
    const bool room = changed_.wait_for(lock, patience, [&] { return used_ + bytes <= limit_; });
    if (!room) return nullptr;
    auto share = std::make_shared<Share>(shared_from_this(), bytes);
    used_ += bytes;
    return share;
  }

 private:
  void Give(int64_t bytes) {
    {
      const std::lock_guard lock(mutex_);
      used_ -= bytes;
    }
    changed_.notify_all();
  }

  const int64_t limit_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  int64_t used_ = 0;
};

}  // namespace waystone
