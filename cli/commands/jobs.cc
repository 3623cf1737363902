// SPDX-License-Identifier: Apache-2.0
#include <iostream>
#include <memory>
#include <optional>
#include <string>

#include "api/json.h"
#include "cli/commands/commands.h"
#include "registry/job_queue.h"

namespace waystone {
namespace {

constexpr int kMostJobs = 1000;

struct JobsFlags {
  std::string registry;
  int64_t job = 0;  // these three: 0 for none
  int64_t cancel = 0;
  int64_t retry = 0;
  bool json = false;
};

// The text of a member; empty for null.
std::string TextIn(const Json& json, const char* name) {
  const Json& value = json.at(name);
  return value.is_null() ? "" : value.is_string() ? value.get<std::string>() : Dump(value);
}

std::string ProgressText(const Json& job) {
  if (job.at("frames").is_null()) return "";
  std::string text = "  " + TextIn(job, "frames_done") + " of " + TextIn(job, "frames") + " frames";
  if (job.at("parts") > 1) {
    text += ", " + TextIn(job, "parts_done") + " of " + TextIn(job, "parts") + " parts";
  }
  return text;
}

void PrintJob(const Json& job) {
  std::cout << TextIn(job, "id") << "  " << TextIn(job, "name") << "  " << TextIn(job, "state")
            << ProgressText(job);
  if (!job.at("version").is_null()) std::cout << "  version " << TextIn(job, "version");
  std::cout << "  " << TextIn(job, "created_at");
  for (const Json& worker : job.at("workers")) {
    std::cout << "  " << TextIn(worker, "worker") << ": " << TextIn(worker, "kind") << ' '
              << TextIn(worker, "step") << ' ' << TextIn(worker, "stage");
  }
  if (!job.at("reason").is_null()) std::cout << "  " << TextIn(job, "reason");
  std::cout << '\n';
}

void PrintDetails(const Json& job) {
  PrintJob(job);
  for (const Json& source : job.at("sources")) {
    std::cout << "  source " << source.get<std::string>() << '\n';
  }
  for (const Json& option : job.at("options")) {
    std::cout << "  option " << option.get<std::string>() << '\n';
  }
  for (const Json& step : job.at("steps")) {
    std::cout << "  " << TextIn(step, "kind") << ' ' << TextIn(step, "number") << "  "
              << TextIn(step, "state") << "  " << TextIn(step, "worker") << "  "
              << TextIn(step, "sha256") << '\n';
  }
  for (const Json& line : job.at("log")) {
    const std::string worker = TextIn(line, "worker");
    std::cout << "  " << TextIn(line, "at") << "  " << worker << (worker.empty() ? "" : "  ")
              << TextIn(line, "message") << '\n';
  }
}

int RunJobs(const JobsFlags& flags) {
  JobQueue queue(flags.registry, false);
  if (flags.cancel > 0) queue.Cancel(flags.cancel);
  if (flags.retry > 0) queue.Retry(flags.retry);
  const int64_t one = flags.job + flags.cancel + flags.retry;  // they exclude each other
  if (one > 0) {
    const Json job = queue.Describe(one);
    if (flags.json) {
      std::cout << Dump(job) << '\n';
    } else if (flags.job > 0) {
      PrintDetails(job);
    } else {
      PrintJob(job);
    }
    return 0;
  }
  for (const Json& job : queue.List(kMostJobs)) {
    if (flags.json) {
      std::cout << Dump(job) << '\n';
    } else {
      PrintJob(job);
    }
  }
  return 0;
}

}  // namespace

void AddJobs(CLI::App& app, Run& run) {
  auto flags = std::make_shared<JobsFlags>();
  CLI::App* command = app.add_subcommand("jobs", "List, cancel or retry the jobs of a registry");
  command->add_option("registry", flags->registry, "Registry in PostgreSQL: postgresql://...")
      ->required();
  CLI::Option* job =
      command->add_option("--job", flags->job, "Show this job with its parts and its log instead")
          ->check(CLI::PositiveNumber);
  CLI::Option* cancel = command
                            ->add_option("--cancel", flags->cancel,
                                         "Cancel this job; workers stop at their next heartbeat")
                            ->check(CLI::PositiveNumber)
                            ->excludes(job);
  command
      ->add_option("--retry", flags->retry,
                   "Resume this job, which failed or was cancelled; parts already built are kept")
      ->check(CLI::PositiveNumber)
      ->excludes(job)
      ->excludes(cancel);
  command->add_flag("--json", flags->json, "Print each job as one JSON object per line");
  command->footer(
      "The newest come first, at most 1000.\n"
      "Example: waystone jobs postgresql://db/maps");
  command->callback([flags, &run] { run = [flags] { return RunJobs(*flags); }; });
}

}  // namespace waystone
