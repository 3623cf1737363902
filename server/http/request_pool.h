// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <condition_variable>
#include <deque>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

namespace waystone {

// Threads that run tasks in the order of their arrival. One more thread is kept for urgent ones, so
// that a health check never waits behind others. Internal to server/http. Thread-safe; only one
// thread may call Stop.
class RequestPool {
 public:
  using Task = std::function<void()>;  // must not throw

  explicit RequestPool(int threads);
  ~RequestPool();  // as Stop
  RequestPool(const RequestPool&) = delete;
  RequestPool& operator=(const RequestPool&) = delete;

  void Add(Task task, bool urgent);
  // Drops what hasn't begun, and returns when the rest has ended.
  void Stop();

 private:
  void Work();

  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<Task> urgent_;
  std::deque<Task> others_;
  int free_for_others_;
  bool stopped_ = false;
  std::vector<std::thread> threads_;
};

}  // namespace waystone
