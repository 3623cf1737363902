// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sys/types.h>

#include <string>
#include <vector>

namespace waystone {

// A program started by this one. Not thread-safe.
class ChildProcess {
 public:
  // Starts arguments[0] with the rest. With `capture`, ReadLine() reads its stdout; otherwise it
  // writes to ours. Throws MapError(kInternal) when it can't be started.
  ChildProcess(const std::vector<std::string>& arguments, bool capture);
  ~ChildProcess();  // ends it with SIGTERM and waits
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;

  // The next line of its stdout, without the line's end; empty at the end of it all.
  std::string ReadLine();
  // Waits for its end and returns its exit code, or 128 + the signal that ended it.
  int Wait();
  void Send(int signal);
  pid_t pid() const { return pid_; }

 private:
  pid_t pid_ = -1;
  int out_ = -1;
};

// The path of the running program.
std::string ThisProgram();

}  // namespace waystone
