// SPDX-License-Identifier: Apache-2.0
#include "cli/system/signals.h"

#include <unistd.h>

#include <csignal>
#include <string_view>

#include "core/base/error.h"

namespace waystone {
namespace {

// The one thing that a signal handler may change.
volatile std::sig_atomic_t interrupted = 0;

sigset_t Signals() {
  sigset_t set;
  sigemptyset(&set);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) sigaddset(&set, signal);
  return set;
}

// What a signal handler says; on a terminal a bar of progress stands before it.
constexpr std::string_view kInLog = "waystone: interrupted; nothing was written\n";
constexpr std::string_view kOnTerminal = "\nwaystone: interrupted; nothing was written\n";
// Set before the handler is.
bool on_terminal = false;
int code_at_end = 0;

void OnInterrupt(void (*handler)(int)) {
  struct sigaction action = {};
  action.sa_handler = handler;
  action.sa_flags = SA_RESETHAND;
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
}

}  // namespace

void NoteInterrupts() {
  OnInterrupt([](int) { interrupted = 1; });
}

bool Interrupted() { return interrupted != 0; }

void EndAtInterrupts() {
  code_at_end = InfoOf(ErrorCode::kInterrupted).exit_code;
  on_terminal = isatty(STDERR_FILENO) == 1;
  OnInterrupt([](int) {
    const std::string_view text = on_terminal ? kOnTerminal : kInLog;
    const ssize_t written = write(STDERR_FILENO, text.data(), text.size());
    static_cast<void>(written);  // the status says it, too
    _exit(code_at_end);
  });
}

void BlockSignals() {
  const sigset_t set = Signals();
  pthread_sigmask(SIG_BLOCK, &set, nullptr);
}

Awaited WaitForSignal(double seconds) {
  const sigset_t set = Signals();
  timespec time = {};
  time.tv_sec = static_cast<time_t>(seconds);
  time.tv_nsec = static_cast<int64_t>(1e9 * (seconds - static_cast<double>(time.tv_sec)));
  const int signal = sigtimedwait(&set, nullptr, &time);
  if (signal == SIGHUP) return Awaited::kReload;
  return signal < 0 ? Awaited::kNothing : Awaited::kEnd;
}

}  // namespace waystone
