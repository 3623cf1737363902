// SPDX-License-Identifier: Apache-2.0
#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <iostream>
#include <memory>
#include <string>

#include "cli/commands/build_sources.h"
#include "cli/commands/commands.h"
#include "cli/commands/job_worker.h"
#include "cli/files/finite.h"
#include "cli/system/signals.h"
#include "core/base/error.h"
#include "core/base/text.h"
#include "core/image/decode.h"
#include "schema/file/file_replacer.h"

namespace waystone {
namespace {

namespace fs = std::filesystem;

// A worker's folder: the given one, which stays, or a temporary one.
class WorkFolder {
 public:
  explicit WorkFolder(const std::string& given) : temporary_(given.empty()) {
    if (temporary_) {
      std::string name = (fs::temp_directory_path() / "waystone-work-XXXXXX").string();
      if (mkdtemp(name.data()) == nullptr) Refuse(name);
      path_ = name;
      return;
    }
    path_ = given;
    std::error_code error;
    fs::create_directories(path_, error);
    lock_ = open((path_ / "lock").c_str(), O_WRONLY | O_CREAT | O_CLOEXEC, 0666);
    if (lock_ < 0) Refuse(path_);
    if (flock(lock_, LOCK_EX | LOCK_NB) == 0) return;
    close(lock_);
    throw MapError(ErrorCode::kFileUnwritable,
                   path_.string() +
                       " is the folder of another worker that runs; give each worker one of its "
                       "own (--work)");
  }
  ~WorkFolder() {
    if (lock_ >= 0) close(lock_);
    std::error_code ignored;
    if (temporary_) fs::remove_all(path_, ignored);
  }
  WorkFolder(const WorkFolder&) = delete;
  WorkFolder& operator=(const WorkFolder&) = delete;

  const fs::path& path() const { return path_; }

 private:
  [[noreturn]] static void Refuse(const fs::path& path) {
    throw UnwritableError(path, std::strerror(errno), 0);
  }

  bool temporary_;
  fs::path path_;
  int lock_ = -1;
};

struct WorkFlags {
  WorkerOptions worker;
  std::string folder;
  bool quiet = false;
};

int RunWork(WorkFlags flags) {
  NoteInterrupts();
  CheckHasJobs(flags.worker.registry);
  const WorkFolder folder(flags.folder);
  flags.worker.work = folder.path();
  PrepareDecoders();
  JobWorker worker(flags.worker, [quiet = flags.quiet](const std::string& line) {
    if (!quiet) std::cerr << "waystone: " + Printable(line) + "\n" << std::flush;
  });
  return worker.Run();
}

}  // namespace

void AddWork(CLI::App& app, Run& run) {
  auto flags = std::make_shared<WorkFlags>();
  WorkerOptions& worker = flags->worker;
  CLI::App* command = app.add_subcommand("work", "Build the maps of a registry's jobs");
  command->add_option("--registry", worker.registry, "Registry in PostgreSQL: postgresql://...")
      ->required();
  command->add_option("--work", flags->folder,
                      "Folder of this worker only, for maps in progress, which it finds again "
                      "after a restart; default: a temporary one");
  command->add_option("--store", worker.store,
                      "Folder or address of the map files, if not the one that the registry names");
  CLI::Option* once = command->add_flag(
      "--once", worker.one_job,
      "Work on one job until it has ended, then exit; exit at once if there is none");
  command->add_flag("--until-empty", worker.until_empty, "Exit when no job is queued or running")
      ->excludes(once);
  AddThreadsFlag(*command, worker.threads);
  command
      ->add_option("--lease", worker.lease_s,
                   "Seconds after which the work of a silent worker is given to another")
      ->check(Finite())
      ->check(CLI::Range(0.5, 86'400.0))
      ->capture_default_str();
  command
      ->add_option("--retry-after", worker.retry_s,
                   "Seconds before failed work is tried again; doubled after each failure")
      ->check(Finite())
      ->check(CLI::Range(0.0, 86'400.0))
      ->capture_default_str();
  command->add_flag("--quiet", flags->quiet, "Print errors only");
  command->footer(
      "Works until Ctrl-C or SIGTERM, and then gives back what it hasn't finished.\n"
      "Example: waystone work --registry postgresql://db/maps --work /var/tmp/waystone");
  command->callback([flags, &run] { run = [flags] { return RunWork(*flags); }; });
}

}  // namespace waystone
