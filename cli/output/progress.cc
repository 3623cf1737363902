// SPDX-License-Identifier: Apache-2.0
#include "cli/output/progress.h"

#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <utility>

#include "api/json_value.h"
#include "core/base/error.h"

namespace waystone {
namespace {

// Seconds between two drawings: smooth for eyes, and few for logs.
constexpr double kBarPeriodS = 0.1;
constexpr double kLinePeriodS = 5.0;
constexpr int kBarCells = 24;
// A share of the work below which its rate says nothing about the rest.
constexpr double kLeastShareForEta = 0.01;

double ComputeShare(const ProgressMeter::State& state) {
  if (state.total <= 0) return 0;
  return std::clamp(static_cast<double>(state.done) / state.total, 0.0, 1.0);
}

std::string CountsOf(const ProgressMeter::State& state) {
  std::string text = std::to_string(state.done);
  if (state.total > 0) text.append("/").append(std::to_string(state.total));
  text.append(" ").append(state.stage);
  if (!state.note.empty()) text.append(", ").append(state.note);
  return text;
}

}  // namespace

ProgressStyle ProgressStyleByName(const std::string& name, bool quiet) {
  if (name != "auto" && name != "none" && name != "json") {
    throw MapError(ErrorCode::kUsage, "--progress " + name + " is not auto, none or json");
  }
  if (name == "json") return ProgressStyle::kJson;
  if (quiet || name == "none") return ProgressStyle::kNone;
  return isatty(STDERR_FILENO) != 0 ? ProgressStyle::kBar : ProgressStyle::kLines;
}

bool ColoursWelcome() {
  const char* no_color = std::getenv("NO_COLOR");
  return isatty(STDERR_FILENO) != 0 && (no_color == nullptr || *no_color == '\0');
}

std::string Duration(double seconds) {
  const auto s = static_cast<int64_t>(std::max(0.0, std::round(seconds)));
  if (s < 60) return std::to_string(s) + " s";
  if (s < 3600) return std::to_string(s / 60) + " min " + std::to_string(s % 60) + " s";
  return std::to_string(s / 3600) + " h " + std::to_string(s % 3600 / 60) + " min";
}

double ProgressMeter::Now() {
  const auto now = std::chrono::steady_clock::now().time_since_epoch();
  return std::chrono::duration<double>(now).count();
}

ProgressMeter::ProgressMeter(std::ostream& out, ProgressStyle style, bool colour, Clock clock)
    : out_(out), style_(style), colour_(colour), clock_(std::move(clock)) {
  stage_start_s_ = printed_s_ = clock_();
}

ProgressMeter::~ProgressMeter() { Finish(); }

void ProgressMeter::Update(const State& state) {
  if (style_ == ProgressStyle::kNone) return;
  const double now = clock_();
  if (state.stage != stage_) {
    stage_ = state.stage;
    stage_start_s_ = now;
  }
  const double period = style_ == ProgressStyle::kBar ? kBarPeriodS : kLinePeriodS;
  if (now - printed_s_ < period) return;
  printed_s_ = now;
  Print(state);
}

void ProgressMeter::Print(const State& state) {
  const std::string left = TimeLeft(state);
  const std::string text = CountsOf(state) + (left.empty() ? "" : ", " + left + " left");
  if (style_ == ProgressStyle::kJson) {
    Json json = {
        {"stage", state.stage}, {"done", state.done}, {"total", state.total}, {"note", state.note}};
    out_ << json.dump(-1, ' ', false, Json::error_handler_t::replace) << std::endl;
  } else if (style_ == ProgressStyle::kLines) {
    out_ << text << std::endl;
  } else {
    // \x1b[K clears what is left of a longer line before.
    out_ << '\r' << Bar(state) << ' ' << text << "\x1b[K" << std::flush;
    drawn_ = true;
  }
}

void ProgressMeter::Finish() {
  if (drawn_) out_ << "\r\x1b[K" << std::flush;
  drawn_ = false;
}

std::string ProgressMeter::Bar(const State& state) const {
  const int full = static_cast<int>(ComputeShare(state) * kBarCells);
  const std::string cells = std::string(full, '#') + std::string(kBarCells - full, '.');
  return colour_ ? "\x1b[36m[" + cells + "]\x1b[0m" : "[" + cells + "]";
}

std::string ProgressMeter::TimeLeft(const State& state) const {
  const double share = ComputeShare(state);
  if (share < kLeastShareForEta || share >= 1) return "";
  return Duration((clock_() - stage_start_s_) / share * (1 - share));
}

}  // namespace waystone
