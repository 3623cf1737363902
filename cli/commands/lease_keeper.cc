// SPDX-License-Identifier: Apache-2.0
#include "cli/commands/lease_keeper.h"

#include <chrono>
#include <exception>
#include <memory>
#include <utility>

#include "core/base/start_thread.h"

namespace waystone {

LeaseKeeper::LeaseKeeper(std::string registry, JobLease lease, double lease_s, Log log)
    : registry_(std::move(registry)),
      lease_(std::move(lease)),
      lease_s_(lease_s),
      log_(std::move(log)) {}

void LeaseKeeper::Start() {
  thread_ = StartThread([this] { Keep(); });
}

LeaseKeeper::~LeaseKeeper() {
  {
    const std::lock_guard lock(mutex_);
    stopped_ = true;
  }
  stop_.notify_all();
  if (thread_.joinable()) thread_.join();
}

void LeaseKeeper::Report(const StepProgress& progress) {
  const std::lock_guard lock(mutex_);
  progress_ = progress;
}

void LeaseKeeper::Keep() {
  constexpr double kHeartbeats = 3;
  const std::chrono::duration<double> pause(lease_s_ / kHeartbeats);
  std::unique_ptr<JobQueue> queue;
  bool silent = false;
  std::unique_lock lock(mutex_);
  while (!stop_.wait_for(lock, pause, [this] { return stopped_; })) {
    const StepProgress progress = progress_;
    lock.unlock();
    try {
      if (!queue) queue = std::make_unique<JobQueue>(registry_, false);
      if (!queue->Renew(lease_, lease_s_, progress)) lost_ = true;
      if (silent) log_("the registry's database is back");
      silent = false;
    } catch (const std::exception& error) {  // also out of memory: the next heartbeat retries
      queue.reset();
      if (!silent) log_(std::string(error.what()) + "; going on without it");
      silent = true;
    }
    lock.lock();
    if (lost_) return;
  }
}

}  // namespace waystone
