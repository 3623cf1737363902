// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <memory>
#include <optional>
#include <string>

#include "cli/commands/job_worker.h"
#include "cli/system/signals.h"
#include "core/base/error.h"

// For job_worker.cc and job_steps.cc only.
namespace waystone {

template <class Ask>
auto JobWorker::Persist(const Ask& ask, const LeaseKeeper* keeper)
    -> std::optional<decltype(ask(std::declval<JobQueue&>()))> {
  constexpr double kFirstPauseS = 0.2;
  constexpr double kMostPauseS = 5;
  // Refusals by a database that answers: then waiting doesn't help.
  constexpr int kMostRefusals = 5;
  int refusals = 0;
  bool said = false;
  for (double pause_s = kFirstPauseS;; pause_s = std::min(2 * pause_s, kMostPauseS)) {
    try {
      if (!queue_) queue_ = std::make_unique<JobQueue>(options_.registry, false);
      return ask(*queue_);
    } catch (const MapError& error) {
      const bool passes = error.code() == ErrorCode::kRegistryUnavailable ||
                          error.code() == ErrorCode::kFileUnreadable;
      if (!passes) throw;
      refusals += queue_ && queue_->connected();
      queue_.reset();
      if (refusals == kMostRefusals) throw;
      if (!said) log_(std::string(error.what()) + "; trying again");
      said = true;
    }
    if (Interrupted() || (keeper && keeper->lost())) return std::nullopt;
    Sleep(pause_s);
  }
}

}  // namespace waystone
