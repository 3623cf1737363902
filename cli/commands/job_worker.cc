// SPDX-License-Identifier: Apache-2.0
#include "cli/commands/job_worker.h"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <new>
#include <system_error>
#include <thread>
#include <utility>

#include "cli/commands/job_persist.h"
#include "cli/system/signals.h"
#include "core/base/error.h"
#include "core/base/text.h"
#include "registry/registry.h"

namespace waystone {
namespace {

namespace fs = std::filesystem;

constexpr int64_t kPartsBytes = 100'000'000'000;  // of the parts' maps
constexpr int kNoMap = 4;                         // exit status

// Whether the same source and options would fail in the same way again.
bool IsFinal(ErrorCode code) {
  constexpr std::array kFinal = {ErrorCode::kUsage,         ErrorCode::kBadOptions,
                                 ErrorCode::kBadSource,     ErrorCode::kBadImage,
                                 ErrorCode::kImageTooLarge, ErrorCode::kUnreadableFrames,
                                 ErrorCode::kBadCamera,     ErrorCode::kBadRequest};
  return std::ranges::count(kFinal, code) > 0;
}

std::string StepName(const JobLease& lease) {
  switch (lease.kind) {
    case StepKind::kPlan:
      return "plan";
    case StepKind::kPart:
      return "part " + std::to_string(lease.step) + " of " + std::to_string(lease.parts);
    case StepKind::kJoin:
      return "join";
  }
  return "";
}

bool HasEnded(const std::string& state) { return state != "queued" && state != "running"; }

}  // namespace

JobWorker::JobWorker(const WorkerOptions& options, Log log)
    : options_(options),
      log_(std::move(log)),
      name_(HostName() + ":" + std::to_string(getpid())),
      queue_(std::make_unique<JobQueue>(options.registry, false)) {
  const std::unique_ptr<Registry> registry = OpenRegistry(options.registry);
  registry_id_ = registry->id();
  store_ = OpenStore(options.store.empty() ? registry->store() : options.store);
  parts_ = std::make_unique<MapCache>(options.work / "parts", kPartsBytes);
  fs::create_directories(options.work / "built");
  RemoveOldMaps();
}

fs::path JobWorker::MapOf(const JobLease& lease) const {
  return options_.work / "built" /
         (registry_id_ + "-" + std::to_string(lease.job) + "-" + std::to_string(lease.step) +
          ".db");
}

// Removes the maps of jobs that have ended without this worker.
void JobWorker::RemoveOldMaps() {
  for (const fs::directory_entry& entry : fs::directory_iterator(options_.work / "built")) {
    const std::vector<std::string> words = Words(entry.path().stem().string(), "-");
    if (words.size() != 3 || words[0] != registry_id_) continue;
    const std::optional<int64_t> job = ToInteger(words[1]);
    if (!job) continue;
    std::error_code ignored;
    try {
      if (HasEnded(queue_->StateOf(*job))) fs::remove(entry.path(), ignored);
    } catch (const MapError& error) {
      if (error.code() != ErrorCode::kNotFound) throw;
      fs::remove(entry.path(), ignored);
    }
  }
}

void JobWorker::Sleep(double seconds) const {
  constexpr std::chrono::milliseconds kNap(50);
  for (double left = seconds; left > 0 && !Interrupted();
       left -= std::chrono::duration<double>(kNap).count()) {
    std::this_thread::sleep_for(kNap);
  }
}

int JobWorker::Run() {
  std::optional<int64_t> job;  // the only one, if options say so
  while (!Interrupted()) {
    const auto claimed =
        Persist([&](JobQueue& queue) { return queue.Claim(name_, options_.lease_s, job); });
    if (!claimed) break;
    if (const std::optional<JobLease>& lease = *claimed) {
      if (options_.one_job) job = lease->job;
      Do(*lease);
    }
    if (job) {
      const auto state = Persist([&](JobQueue& queue) { return queue.StateOf(*job); });
      if (state && HasEnded(*state)) return *state == "done" ? 0 : kNoMap;
    }
    if (*claimed) continue;
    if (options_.one_job && !job) break;
    if (options_.until_empty && Persist([](JobQueue& queue) { return queue.CountOpen(); }) == 0) {
      break;
    }
    Sleep(options_.poll_s);
  }
  return 0;
}

void JobWorker::Say(const JobLease& lease, const std::string& what) const {
  log_("job " + std::to_string(lease.job) + " (" + lease.spec.name + "), " + StepName(lease) +
       ": " + what);
}

void JobWorker::Do(const JobLease& lease) {
  LeaseKeeper keeper(options_.registry, lease, options_.lease_s,
                     [this, lease](const std::string& line) { Say(lease, line); });
  try {
    keeper.Start();
    DoStep(lease, keeper);
  } catch (const MapError& error) {
    if (error.code() != ErrorCode::kInterrupted) {
      Fail(lease, keeper, error.what(), !IsFinal(error.code()));
    } else if (keeper.lost()) {
      Say(lease, "given up; another worker has it, or the job was ended");
    } else {
      const auto released =
          Persist([&](JobQueue& queue) { return queue.Release(lease, "the worker was stopped"); });
      Say(lease, released
                     ? "given back; the worker is being stopped"
                     : "not given back, as the database is away: the lease ends by itself; the "
                       "worker is being stopped");
    }
  } catch (const std::bad_alloc&) {
    Fail(lease, keeper, "out of memory; use a worker with more memory, or shorter --part-frames",
         true);
  } catch (const std::exception& error) {
    Fail(lease, keeper, std::string("internal error: ") + error.what() + "; please report it",
         true);
  }
}

void JobWorker::DoStep(const JobLease& lease, LeaseKeeper& keeper) {
  Say(lease, "begun");
  const Outcome outcome = lease.kind == StepKind::kPlan   ? Plan(lease, keeper)
                          : lease.kind == StepKind::kPart ? BuildPart(lease, keeper)
                                                          : Join(lease, keeper);
  if (!outcome.held) {
    return Say(lease, "given up; another worker has it, or the job was ended");
  }
  Say(lease, outcome.said);
  Persist([&](JobQueue& queue) {
    queue.Log(lease, name_, StepName(lease) + ": " + outcome.said);
    return true;
  });
}

void JobWorker::Fail(const JobLease& lease, const LeaseKeeper& keeper, const std::string& reason,
                     bool again) {
  constexpr int kMostDoublings = 6;
  const double wait_s = options_.retry_s * std::exp2(std::min(lease.failures, kMostDoublings));
  Say(lease, "failed: " + reason);
  Persist(
      [&](JobQueue& queue) {
        const bool held = queue.Fail(lease, reason, again ? std::optional(wait_s) : std::nullopt);
        if (held) queue.Log(lease, name_, StepName(lease) + " failed: " + reason);
        return held;
      },
      &keeper);
}

}  // namespace waystone
