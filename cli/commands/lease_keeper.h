// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <string>
#include <thread>

#include "registry/job_queue.h"

namespace waystone {

// Keeps a worker's lease of a step from Start() on: three heartbeats in the lease's time, over a
// connection of its own. While the database can't be reached it goes on trying: the lease is lost
// only when the database says so. Thread-safe.
class LeaseKeeper {
 public:
  using Log = std::function<void(const std::string&)>;

  // `log` gets a line for each event, from any thread.
  LeaseKeeper(std::string registry, JobLease lease, double lease_s, Log log);
  // Throws MapError(kOutOfMemory) where the system has no thread for it.
  void Start();
  ~LeaseKeeper();
  LeaseKeeper(const LeaseKeeper&) = delete;
  LeaseKeeper& operator=(const LeaseKeeper&) = delete;

  // What the next heartbeat reports.
  void Report(const StepProgress& progress);
  // Whether another worker has the step, or the job has ended.
  bool lost() const { return lost_; }

 private:
  void Keep();

  const std::string registry_;
  const JobLease lease_;
  const double lease_s_;
  const Log log_;
  std::mutex mutex_;
  std::condition_variable stop_;
  bool stopped_ = false;
  StepProgress progress_;
  std::atomic<bool> lost_ = false;
  std::thread thread_;
};

}  // namespace waystone
