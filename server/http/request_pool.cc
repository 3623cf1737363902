// SPDX-License-Identifier: Apache-2.0
#include "server/http/request_pool.h"

#include <utility>

#include "core/base/start_thread.h"

namespace waystone {

RequestPool::RequestPool(int threads) : free_for_others_(threads) {
  threads_.reserve(static_cast<size_t>(threads) + 1);  // a running thread must find its place
  try {
    for (int i = 0; i < threads + 1; ++i) threads_.push_back(StartThread([this] { Work(); }));
  } catch (...) {  // those that already run must end first
    Stop();
    throw;
  }
}

RequestPool::~RequestPool() { Stop(); }

void RequestPool::Add(Task task, bool urgent) {
  {
    const std::lock_guard guard(mutex_);
    (urgent ? urgent_ : others_).push_back(std::move(task));
  }
  changed_.notify_one();
}

void RequestPool::Stop() {
  {
    const std::lock_guard guard(mutex_);
    stopped_ = true;
    urgent_.clear();
    others_.clear();
  }
  changed_.notify_all();
  for (std::thread& thread : threads_) thread.join();
  threads_.clear();
}

void RequestPool::Work() {
  std::unique_lock lock(mutex_);
  const auto ready = [this] {
    return stopped_ || !urgent_.empty() || (!others_.empty() && free_for_others_ > 0);
  };
  while (true) {
    changed_.wait(lock, ready);
    if (stopped_) return;
    const bool urgent = !urgent_.empty();
    std::deque<Task>& tasks = urgent ? urgent_ : others_;
    const Task task = std::move(tasks.front());
    tasks.pop_front();
    if (!urgent) --free_for_others_;
    lock.unlock();
    task();
    lock.lock();
    if (!urgent) ++free_for_others_;
    changed_.notify_one();
  }
}

}  // namespace waystone
