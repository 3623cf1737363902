// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <functional>
#include <mutex>
#include <string>
#include <utility>

namespace waystone {

// How far a build is.
struct BuildProgress {
  // "frames", "fusion", "revisits", "links"; "panoramas", "odometry", "loops", "poses";
  // "directions", "loops"; "structure" (with poses), "calibration"
  std::string stage;
  int done = 0;
  int total = 0;      // 0 when not known
  int keyframes = 0;  // so far, as the following
  int planes = 0;
  int panoramas = 0;
};

// Called from any thread, but never concurrently. Returns whether the build goes on.
using ProgressCallback = std::function<bool(const BuildProgress&)>;

// Reports a build's progress to a callback, and stops the build when the callback says so.
// Thread-safe.
class ProgressReporter {
 public:
  ProgressReporter() = default;  // without a callback
  explicit ProgressReporter(ProgressCallback callback) : callback_(std::move(callback)) {}

  // Throws MapError(kInterrupted) when the callback returns false.
  void Report(const std::string& stage, int done, int total);

  // Counts that later reports include.
  void SetPlanes(int keyframes, int planes);
  void AddPanorama() { ++panoramas_; }

 private:
  ProgressCallback callback_;
  std::mutex calling_;
  std::atomic<int> keyframes_ = 0;
  std::atomic<int> planes_ = 0;
  std::atomic<int> panoramas_ = 0;
};

}  // namespace waystone
