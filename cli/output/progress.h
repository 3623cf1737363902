// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <ostream>
#include <string>

namespace waystone {

enum class ProgressStyle {
  kNone,
  kBar,    // a bar that is drawn over itself: for terminals
  kLines,  // a plain line every few seconds: for logs
  kJson,   // a JSON object per line, as often
};

// For "auto", "none" or "json", as the user says; auto is a bar where stderr is a terminal. Throws
// MapError(kUsage) for another name.
ProgressStyle ProgressStyleByName(const std::string& name, bool quiet);

// Whether to use colours on stderr: on a terminal, without NO_COLOR in the environment.
bool ColoursWelcome();

// Shows how far a long job is, and how long it will still take. Not thread-safe.
class ProgressMeter {
 public:
  struct State {
    std::string stage;
    int done = 0;
    int total = 0;     // 0 when not known
    std::string note;  // "61 keyframes, 14 planes"
  };

  // Seconds since some fixed moment; tests pass their own.
  using Clock = std::function<double()>;
  static double Now();

  ProgressMeter(std::ostream& out, ProgressStyle style, bool colour, Clock clock = Now);
  ~ProgressMeter();  // finishes
  ProgressMeter(const ProgressMeter&) = delete;
  ProgressMeter& operator=(const ProgressMeter&) = delete;

  void Update(const State& state);
  // Leaves the terminal's cursor on a fresh line.
  void Finish();

 private:
  std::string Bar(const State& state) const;
  std::string TimeLeft(const State& state) const;
  void Print(const State& state);

  std::ostream& out_;
  ProgressStyle style_;
  bool colour_;
  Clock clock_;
  std::string stage_;
  double stage_start_s_ = 0;
  double printed_s_ = 0;
  bool drawn_ = false;
};

// "7 s", "3 min 20 s", "2 h 5 min".
std::string Duration(double seconds);

}  // namespace waystone
