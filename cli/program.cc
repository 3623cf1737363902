// SPDX-License-Identifier: Apache-2.0
#include "cli/program.h"

#include <CLI/CLI.hpp>
#include <csignal>
#include <exception>
#include <iostream>
#include <string>

#include "cli/commands.h"
#include "core/base/error.h"
#include "core/base/version.h"

namespace waystone {
namespace {

constexpr const char* kDescription =
    "Visual localization in large indoor maps: build a map from image sequences offline,\n"
    "then localize single images in it.";

constexpr const char* kFooter =
    "Exit status: 0 success, 2 usage error, 3 invalid input, 4 no usable result,\n"
    "5 internal error, 130 interrupted.\n"
    "To get started: waystone demo";

int Fail(const std::string& message, ErrorCode code) {
  std::cerr << "waystone: " << message << '\n';
  return InfoOf(code).exit_code;
}

// CLI11's messages in the form of this program's, on one line.
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

int ExitOfParse(CLI::App& app, const CLI::ParseError& error) {
  return app.exit(error) == 0 ? 0 : InfoOf(ErrorCode::kUsage).exit_code;
}

}  // namespace

int RunProgram(int argc, char** argv) {
  // A file that may not grow is an error of the write then, which says what is wrong.
  std::signal(SIGXFSZ, SIG_IGN);
  CLI::App app(kDescription, "waystone");
  app.set_version_flag("--version", std::string("waystone ") + kVersion);
  app.require_subcommand(1);
  app.footer(kFooter);
  app.failure_message(UsageMessage);
  Run run;
  AddBuild(app, run);
  AddServe(app, run);
  AddLocalize(app, run);
  AddWatch(app, run);
  AddDirections(app, run);
  AddEval(app, run);
  AddAudit(app, run);
  AddInfo(app, run);
  AddCheck(app, run);
  AddMigrate(app, run);
  AddUnwrap(app, run);
  AddCompass(app, run);
  AddExport(app, run);
  AddReplay(app, run);
  AddDemo(app, run);
  try {
    app.parse(argc, argv);
    return run();
  } catch (const CLI::ParseError& error) {
    return ExitOfParse(app, error);
  } catch (const MapError& error) {
    return Fail(error.what(), error.code());
  } catch (const std::exception& error) {
    return Fail(std::string("internal error: ") + error.what() + "; please report it",
                ErrorCode::kInternal);
  }
}

}  // namespace waystone
