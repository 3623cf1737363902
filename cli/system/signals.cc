// SPDX-License-Identifier: Apache-2.0
#include "cli/system/signals.h"

#include <csignal>

namespace waystone {
namespace {

// The one thing that a signal handler may touch.
volatile std::sig_atomic_t interrupted = 0;

sigset_t Signals() {
  sigset_t set;
  sigemptyset(&set);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) sigaddset(&set, signal);
  return set;
}

}  // namespace

void NoteInterrupts() {
  struct sigaction action = {};
  action.sa_handler = [](int) { interrupted = 1; };
  action.sa_flags = SA_RESETHAND;
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
}

bool Interrupted() { return interrupted != 0; }

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
