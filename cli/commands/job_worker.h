// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "cli/commands/lease_keeper.h"
#include "registry/job_queue.h"
#include "registry/map_cache.h"
#include "registry/store.h"

namespace waystone {

struct WorkerOptions {
  std::string registry;        // postgresql://...
  std::string store;           // empty: the one that the registry names
  std::filesystem::path work;  // a folder of this worker only, for maps being built
  int threads = 0;
  double lease_s = 60;       // how long a silent worker keeps a step
  double retry_s = 10;       // before the second attempt; doubled for each further one
  double poll_s = 0.5;       // between two looks for work
  bool one_job = false;      // end when the first job that it had a step of has ended
  bool until_empty = false;  // end when no job is queued or running
};

// Takes steps of jobs, does them, and reports the results. Not thread-safe.
class JobWorker {
 public:
  using Log = std::function<void(const std::string&)>;

  // Throws MapError for a registry, a store or a folder that can't be used. `log` gets a line for
  // each event, from any thread.
  JobWorker(const WorkerOptions& options, Log log);

  // Works until a signal (NoteInterrupts), or as long as the options say. Returns the exit status:
  // 4 when the one job didn't end with a map.
  int Run();

 private:
  struct Outcome {
    bool held = true;  // the lease
    std::string said;  // what was done, for people
  };

  // Calls `ask` until the database answers, reconnecting as needed. Nothing when a signal came
  // first, or the lease was lost; what the database would have said isn't known then.
  template <class Ask>
  auto Persist(const Ask& ask, const LeaseKeeper* keeper = nullptr)
      -> std::optional<decltype(ask(std::declval<JobQueue&>()))>;
  void Sleep(double seconds) const;
  void RemoveOldMaps();
  void Do(const JobLease& lease);
  void DoStep(const JobLease& lease, LeaseKeeper& keeper);
  Outcome Plan(const JobLease& lease, LeaseKeeper& keeper);
  Outcome BuildPart(const JobLease& lease, LeaseKeeper& keeper);
  Outcome Join(const JobLease& lease, LeaseKeeper& keeper);
  bool BuildMapOf(const JobLease& lease, LeaseKeeper& keeper, const std::filesystem::path& file);
  void MergeParts(const JobLease& lease, LeaseKeeper& keeper,
                  const std::vector<MapCache::FilePtr>& files, const std::filesystem::path& merged);
  std::filesystem::path MapOf(const JobLease& lease) const;
  void Fail(const JobLease& lease, const LeaseKeeper& keeper, const std::string& reason,
            bool again);
  void Say(const JobLease& lease, const std::string& what) const;

  WorkerOptions options_;
  Log log_;
  std::string name_;  // "host:process"
  std::unique_ptr<JobQueue> queue_;
  std::string registry_id_;
  std::unique_ptr<Store> store_;
  std::unique_ptr<MapCache> parts_;
};

}  // namespace waystone
