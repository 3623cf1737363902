// SPDX-License-Identifier: Apache-2.0
#include "cli/program.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <exception>
#include <filesystem>
#include <iostream>
#include <new>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "cli/commands/commands.h"
#include "cli/output/printable_output.h"
#include "core/base/error.h"
#include "core/base/option_text.h"
#include "core/base/text.h"
#include "core/base/version.h"
#include "core/image/opencv_errors.h"

namespace waystone {
namespace {

constexpr const char* kDescription =
    "Visual localization in large indoor maps: build a map from image sequences offline,\n"
    "then localize single images in it.";

constexpr const char* kFooter =
    "Exit status: 0 success, 2 usage error, 3 invalid input or output, a server that refuses,\n"
    "or out of memory, 4 no usable result, 5 internal error, 6 registry or store can't be\n"
    "reached, 130 interrupted.\n"
    "To get started: waystone demo";

int Fail(const std::string& message, ErrorCode code) {
  std::cerr << "waystone: " << Printable(message) << '\n';
  return InfoOf(code).exit_code;
}

// What TBB throws, a plain std::runtime_error, can only be told by its text.
int FailUnexpectedly(const std::string& cause) {
  if (cause.starts_with("pthread_create has failed")) {
    return Fail("cannot start a thread (" + cause +
                    "); raise the limit on threads (ulimit -u, TasksMax) or free memory",
                ErrorCode::kOutOfMemory);
  }
  return Fail("internal error: " + cause + "; please report it", ErrorCode::kInternal);
}

// CLI11's messages in this program's style, on one line.
std::string UsageMessage(const CLI::App* app, const CLI::Error& error) {
  std::string cause = error.what();
  for (char& c : cause) {
    if (c == '\n') c = ' ';
  }
  while (!cause.empty() && (cause.back() == ' ' || cause.back() == '.')) cause.pop_back();
  std::string command = "waystone";
  for (const CLI::App* sub : app->get_subcommands()) command += " " + sub->get_name();
  return "waystone: " + cause + "; see " + command + " --help\n";
}

void CheckOption(const CLI::App& app, const std::string& word) {
  for (const CLI::Option* option : app.get_options()) {
    if (option->check_name(word)) return;
  }
  throw MapError(ErrorCode::kUsage,
                 "unknown option '" + word + "' before a command; see waystone --help");
}

// Throws MapError(kUsage) for an option or argument that was given without a value.
void CheckValues(const CLI::App& app) {
  for (const CLI::App* command : app.get_subcommands()) {
    for (const CLI::Option* option : command->get_options()) {
      if (option->count() == 0 || std::ranges::count(option->results(), "") == 0) continue;
      throw MapError(ErrorCode::kUsage,
                     option->get_name() + " is empty; give it a value or leave it out");
    }
    CheckValues(*command);
  }
}

// CLI11 would only say that a command is required. Throws MapError(kUsage) when the first argument
// is neither an option nor one of our commands.
void CheckCommand(const CLI::App& app, int argc, char** argv) {
  const std::string word = argc > 1 ? argv[1] : "";
  if (word.starts_with('-') && word != "--") return CheckOption(app, word);
  if (word.empty() || word == "--") return;
  std::string nearest;
  size_t least = std::max<size_t>(1, word.size() / 3) + 1;
  for (const CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; })) {
    const size_t distance = EditDistance(word, command->get_name());
    if (distance == 0) return;
    if (distance < least) nearest = command->get_name();
    least = std::min(least, distance);
  }
  throw MapError(ErrorCode::kUsage, "unknown command '" + word + "'" +
                                        (nearest.empty() ? "; see waystone --help"
                                                         : "; did you mean '" + nearest + "'?"));
}

int ExitOfParse(CLI::App& app, const CLI::ParseError& error) {
  return app.exit(error) == 0 ? 0 : InfoOf(ErrorCode::kUsage).exit_code;
}

// The exit code, once all output is written. A reader that wants no more may close the pipe.
int AfterWriting(PrintableOutput& output, int code) {
  const int error = output.Flush();
  if (code != 0 || error == 0 || error == EPIPE) return code;
  return Fail("can't write to standard output: " + std::string(std::strerror(error)) +
                  "; free up space or write elsewhere",
              ErrorCode::kFileUnwritable);
}

int RunCommand(int argc, char** argv) {
  CLI::App app(kDescription, "waystone");
  app.set_version_flag("--version", std::string("waystone ") + kVersion);
  app.require_subcommand(1);
  app.footer(kFooter);
  app.failure_message(UsageMessage);
  Run run;
  AddBuild(app, run);
  AddAdd(app, run);
  AddServe(app, run);
  AddLocalize(app, run);
  AddWatch(app, run);
  AddDirections(app, run);
  AddEval(app, run);
  AddAudit(app, run);
  AddInfo(app, run);
  AddCheck(app, run);
  AddMigrate(app, run);
  AddMerge(app, run);
  AddName(app, run);
  AddPlan(app, run);
  AddOptions(app, run);
  AddUnwrap(app, run);
  AddCompass(app, run);
  AddExport(app, run);
  AddRemove(app, run);
  AddPrune(app, run);
  AddReplay(app, run);
  AddPublish(app, run);
  AddMaps(app, run);
  AddRollback(app, run);
  AddRetire(app, run);
  AddEnqueue(app, run);
  AddWork(app, run);
  AddJobs(app, run);
  AddDemo(app, run);
  ThrowOpenCvErrors();
  cv::setNumThreads(1);  // frames and queries are what runs in parallel
  try {
    CheckCommand(app, argc, argv);
    app.parse(argc, argv);
    CheckValues(app);
    return run();
  } catch (const CLI::ParseError& error) {
    return ExitOfParse(app, error);
  } catch (const MapError& error) {
    return Fail(error.what(), error.code());
  } catch (const std::bad_alloc&) {
    return Fail("out of memory; close other programs or use a machine with more memory",
                ErrorCode::kOutOfMemory);
  } catch (const std::filesystem::filesystem_error& error) {
    return Fail("'" + error.path1().string() + "' can't be used: " + error.code().message() +
                    "; check the path and its permissions",
                ErrorCode::kFileUnreadable);
  } catch (const std::exception& error) {
    return FailUnexpectedly(error.what());
  }
}

}  // namespace

int RunProgram(int argc, char** argv) {
  // Writing to a file that may not grow then fails with an error that says so.
  std::signal(SIGXFSZ, SIG_IGN);
  PrintableOutput output(std::cout);
  const PrintableOutput errors(std::cerr);
  return AfterWriting(output, RunCommand(argc, argv));
}

}  // namespace waystone
