// SPDX-License-Identifier: Apache-2.0
#include <filesystem>
#include <iostream>
#include <memory>
#include <string>
#include <vector>

#include "api/json.h"
#include "cli/commands/build_flags.h"
#include "cli/commands/commands.h"
#include "registry/job_queue.h"
#include "registry/registry.h"

namespace waystone {
namespace {

struct EnqueueFlags {
  BuildFlags build;
  std::vector<const CLI::Option*> build_options;
  JobSpec spec;
  std::string registry;
  std::string store;
  bool json = false;
};

// Workers run in other folders than the one where this was called.
std::string WholePath(const std::string& path) {
  return std::filesystem::absolute(path).lexically_normal().string();
}

// An option whose value is a file.
std::string WithWholePath(const std::string& option) {
  for (const std::string name : {"--camera=", "--poses="}) {
    if (option.starts_with(name)) return name + WholePath(option.substr(name.size()));
  }
  return option;
}

int RunEnqueue(const EnqueueFlags& flags) {
  JobSpec spec = flags.spec;
  for (const std::string& source : flags.build.sources.paths) {
    spec.sources.push_back(WholePath(source));
  }
  for (const std::string& option : GivenOptions(flags.build_options)) {
    spec.options.push_back(WithWholePath(option));
  }
  // What no worker could build is refused here.
  CheckJobSpec(spec);
  MakeBuildOptions(flags.build, spec.name);
  SourceOptionsOf(flags.build.sources);
  CheckPoseFlags(flags.build.poses);
  ParseBuildFlags(spec.sources, spec.options);
  CheckHasJobs(flags.registry);
  OpenRegistry(flags.registry,
               NewRegistry{flags.store.empty() || flags.store.find("://") != std::string::npos
                               ? flags.store
                               : WholePath(flags.store)});
  JobQueue queue(flags.registry, true);
  const int64_t job = queue.Enqueue(spec);
  if (flags.json) {
    std::cout << Dump(queue.Describe(job)) << '\n';
  } else {
    std::cout << "Enqueued job " << job << ": " << spec.name << '\n';
  }
  return 0;
}

}  // namespace

void AddEnqueue(CLI::App& app, Run& run) {
  auto flags = std::make_shared<EnqueueFlags>();
  CLI::App* command = app.add_subcommand("enqueue", "Queue the build of a map for workers");
  AddSourceFlags(*command, std::string(kBuildSources) + ", as paths that all workers can reach",
                 flags->build.sources);
  AddBuildFlags(*command, flags->build);
  for (const CLI::Option* option : command->get_options()) {
    const bool has_value = option != command->get_help_ptr() && !option->get_positional();
    if (has_value) flags->build_options.push_back(option);
  }
  command->add_option("--name", flags->spec.name, "Name of the published map")->required();
  command->add_option("--registry", flags->registry, "Registry in PostgreSQL: postgresql://...")
      ->required();
  command->add_option("--tag", flags->spec.tags, "Tag of the version, shown in lists; repeatable")
      ->allow_extra_args(false);
  command
      ->add_option("--part-frames", flags->spec.part_frames,
                   "Cut a longer walk (planes only, without poses) into overlapping parts of at "
                   "most this many frames, which workers build at the same time")
      ->capture_default_str();
  command
      ->add_option("--attempts", flags->spec.max_attempts,
                   "Maximum number of attempts at each part of the job")
      ->capture_default_str();
  command->add_option("--store", flags->store,
                      "Folder or address of the map files; required if the registry does not exist "
                      "yet");
  command->add_flag("--json", flags->json, "Print the job as one JSON object");
  command->footer(
      "waystone work builds the map and publishes it, waystone jobs shows its progress.\n"
      "Example: waystone enqueue /data/lab-walk --name lab --registry postgresql://db/maps");
  command->callback([flags, &run] { run = [flags] { return RunEnqueue(*flags); }; });
}

}  // namespace waystone
