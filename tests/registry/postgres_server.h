// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fcntl.h>
#include <pwd.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <optional>
#include <string>
#include <thread>
#include <vector>

namespace waystone {

// A PostgreSQL server of Debian's package in a temporary folder, reached by a Unix socket alone. As
// root it runs as the package's user `postgres`, because it refuses to run as root.
class PostgresServer {
 public:
  // The folder of its programs; nothing where the package isn't installed.
  static std::optional<std::filesystem::path> Programs() {
    std::error_code ignored;
    std::optional<std::filesystem::path> found;
    for (const auto& version :
         std::filesystem::directory_iterator("/usr/lib/postgresql", ignored)) {
      if (std::filesystem::exists(version.path() / "bin/initdb", ignored)) {
        found = version.path() / "bin";
      }
    }
    const bool can_run = getuid() != 0 || getpwnam("postgres") != nullptr;
    return can_run ? found : std::nullopt;
  }

  // Throws std::runtime_error where it can't be made.
  PostgresServer() {
    std::string name = "/tmp/waystone-pg-XXXXXX";  // the path of a socket is short: 107 bytes
    if (mkdtemp(name.data()) == nullptr) throw std::runtime_error("no temporary folder");
    folder_ = name;
    if (getuid() == 0) {
      const passwd* user = getpwnam("postgres");
      if (chown(folder_.c_str(), user->pw_uid, user->pw_gid) != 0) {
        throw std::runtime_error("no folder for PostgreSQL");
      }
    }
    const pid_t made = Spawn({(*Programs() / "initdb").string(), "-D", Data(), "-A", "trust", "-U",
                              "waystone", "-E", "UTF8", "--no-locale", "--no-sync"});
    int status = 0;
    waitpid(made, &status, 0);
    if (status != 0) throw std::runtime_error("initdb failed");
    Start();
  }
  ~PostgresServer() {
    Stop(SIGQUIT);
    std::filesystem::remove_all(folder_);
  }
  PostgresServer(const PostgresServer&) = delete;
  PostgresServer& operator=(const PostgresServer&) = delete;

  void Start() {
    process_ = Spawn({(*Programs() / "postgres").string(), "-D", Data(), "-k", folder_.string(),
                      "-c", "listen_addresses=", "-c", "fsync=off"});
    for (int i = 0; i < 1000; ++i) {
      const pid_t probe = Spawn({(*Programs() / "pg_isready").string(), "-q", "-h",
                                 folder_.string(), "-U", "waystone", "-d", "postgres"});
      int status = 0;
      waitpid(probe, &status, 0);
      if (status == 0) return;
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
    throw std::runtime_error("PostgreSQL didn't start");
  }
  // At once with SIGQUIT.
  void Stop(int signal = SIGQUIT) {
    if (process_ < 0) return;
    kill(process_, signal);
    waitpid(process_, nullptr, 0);
    process_ = -1;
  }
  void Psql(const std::string& sql) const {
    const pid_t ran = Spawn({(*Programs() / "psql").string(), "-q", "-h", folder_.string(), "-U",
                             "waystone", "-d", "postgres", "-c", sql});
    int status = 0;
    waitpid(ran, &status, 0);
    if (status != 0) throw std::runtime_error("psql failed: " + sql);
  }
  std::string url() const {
    return "postgresql:///postgres?user=waystone&host=" + folder_.string();
  }

 private:
  std::string Data() const { return (folder_ / "data").string(); }

  // Starts a program as the user who may run it, with its output in a file of the folder.
  pid_t Spawn(const std::vector<std::string>& arguments) const {
    std::vector<char*> words;
    for (const std::string& argument : arguments)
      words.push_back(const_cast<char*>(argument.c_str()));
    words.push_back(nullptr);
    const std::string log = (folder_ / "log").string();
    const passwd* user = getuid() == 0 ? getpwnam("postgres") : nullptr;
    const uid_t uid = user ? user->pw_uid : 0;
    const gid_t gid = user ? user->pw_gid : 0;
    const pid_t child = fork();
    if (child != 0) return child;
    if (user && (setgid(gid) != 0 || setuid(uid) != 0)) _exit(126);
    const int out = open(log.c_str(), O_WRONLY | O_CREAT | O_APPEND, 0600);
    dup2(out, STDOUT_FILENO);
    dup2(out, STDERR_FILENO);
    if (chdir("/") != 0) _exit(126);
    execv(words[0], words.data());
    _exit(127);
  }

  std::filesystem::path folder_;
  pid_t process_ = -1;
};

}  // namespace waystone
