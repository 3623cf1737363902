// SPDX-License-Identifier: Apache-2.0
#include "cli/system/child_process.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <filesystem>

#include "core/base/error.h"

namespace waystone {

ChildProcess::ChildProcess(const std::vector<std::string>& arguments, bool capture) {
  std::vector<char*> argv;
  argv.reserve(arguments.size() + 1);
  for (const std::string& argument : arguments) argv.push_back(const_cast<char*>(argument.c_str()));
  argv.push_back(nullptr);

  std::array<int, 2> ends = {-1, -1};
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  if (capture && pipe2(ends.data(), O_CLOEXEC) == 0) {
    posix_spawn_file_actions_adddup2(&actions, ends[1], STDOUT_FILENO);
  }
  const int error = posix_spawn(&pid_, argv[0], &actions, nullptr, argv.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  if (ends[1] >= 0) close(ends[1]);
  out_ = ends[0];
  if (error != 0) {
    pid_ = -1;
    throw MapError(ErrorCode::kInternal,
                   "can't start " + arguments.front() + ": " + std::strerror(error));
  }
}

ChildProcess::~ChildProcess() {
  Send(SIGTERM);
  Wait();
  if (out_ >= 0) close(out_);
}

std::string ChildProcess::ReadLine() {
  std::string line;
  char c = 0;
  while (out_ >= 0 && read(out_, &c, 1) == 1 && c != '\n') line += c;
  return line;
}

int ChildProcess::Wait() {
  if (pid_ < 0) return 0;
  int status = 0;
  while (waitpid(pid_, &status, 0) < 0 && errno == EINTR) {
  }
  pid_ = -1;
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

void ChildProcess::Send(int signal) {
  if (pid_ > 0) kill(pid_, signal);
}

std::string ThisProgram() { return std::filesystem::read_symlink("/proc/self/exe").string(); }

}  // namespace waystone
