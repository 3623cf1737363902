// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <string>
#include <vector>

namespace waystone {

// What the parsed command line asks for: returns the program's exit code, throws MapError.
using Run = std::function<int()>;

// Adds --set, whose values ApplySettings takes (cli/commands/settings.h).
void AddSetFlag(CLI::App& command, std::vector<std::string>& settings);

// Each adds its subcommand to the program and, when that is the one given, stores what it does in
// `run`, which must outlive the parsing.
void AddBuild(CLI::App& app, Run& run);
void AddAdd(CLI::App& app, Run& run);
void AddServe(CLI::App& app, Run& run);
void AddLocalize(CLI::App& app, Run& run);
void AddWatch(CLI::App& app, Run& run);
void AddDirections(CLI::App& app, Run& run);
void AddEval(CLI::App& app, Run& run);
// A subcommand of `eval`.
void AddEvalTrajectory(CLI::App& eval, Run& run);
void AddAudit(CLI::App& app, Run& run);
void AddInfo(CLI::App& app, Run& run);
void AddCheck(CLI::App& app, Run& run);
void AddMigrate(CLI::App& app, Run& run);
void AddMerge(CLI::App& app, Run& run);
void AddName(CLI::App& app, Run& run);
void AddOptions(CLI::App& app, Run& run);
void AddPlan(CLI::App& app, Run& run);
void AddUnwrap(CLI::App& app, Run& run);
void AddCompass(CLI::App& app, Run& run);
void AddExport(CLI::App& app, Run& run);
void AddPrune(CLI::App& app, Run& run);
void AddRemove(CLI::App& app, Run& run);
void AddReplay(CLI::App& app, Run& run);
void AddPublish(CLI::App& app, Run& run);
void AddMaps(CLI::App& app, Run& run);
void AddRollback(CLI::App& app, Run& run);
void AddRetire(CLI::App& app, Run& run);
void AddEnqueue(CLI::App& app, Run& run);
void AddWork(CLI::App& app, Run& run);
void AddJobs(CLI::App& app, Run& run);
void AddDemo(CLI::App& app, Run& run);

}  // namespace waystone
