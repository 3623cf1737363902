// SPDX-License-Identifier: Apache-2.0
// What the program says of a command line, of files beside maps, and of an output that can't be
// written.
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include "tests/e2e/shared_map.h"

namespace waystone {
namespace {

namespace fs = std::filesystem;

class CommandLine : public testing::Test {
 protected:
  ~CommandLine() override { fs::remove_all(folder_); }

  // One line on stderr.
  static void ExpectRefused(const std::vector<std::string>& arguments, int code,
                            const std::string& about, const std::string& limits = "") {
    const RunResult result = RunWaystone(arguments, limits);
    EXPECT_EQ(result.code, code) << result.err;
    EXPECT_EQ(std::ranges::count(result.err, '\n'), 1) << result.err;
    EXPECT_TRUE(result.err.starts_with("waystone: ")) << result.err;
    EXPECT_NE(result.err.find(about), std::string::npos) << about << ": " << result.err;
  }

  const fs::path folder_ = FreshFolder();
};

// The program with its output going where it can't be written.
int StatusOf(const std::string& arguments, const std::string& redirected, const fs::path& errors) {
  const std::string command =
      std::string(WAYSTONE_PROGRAM) + " " + arguments + " 2>" + errors.string() + " " + redirected;
  return WEXITSTATUS(std::system(command.c_str()));  // NOLINT(cert-env33-c)
}

TEST_F(CommandLine, OutputThatCannotBeWrittenIsAnError) {
  const std::string map = TheMap().map.string();
  for (const std::string& arguments :
       {std::string("--help"), std::string("--version"), "info " + map + " --json", "check " + map,
        "export " + map}) {
    EXPECT_EQ(StatusOf(arguments, ">/dev/full", folder_ / "err"), 3) << arguments;
    const std::string error = ReadFile(folder_ / "err");
    EXPECT_NE(error.find("can't write to standard output: No space left"), std::string::npos)
        << error;
  }
  EXPECT_EQ(StatusOf("options --markdown", "| head -1 >/dev/null", folder_ / "err"), 0);
  EXPECT_EQ(ReadFile(folder_ / "err"), "") << "a closed pipe";
  EXPECT_EQ(StatusOf("info no.db", ">/dev/full", folder_ / "err"), 3);
  EXPECT_NE(ReadFile(folder_ / "err").find("no.db"), std::string::npos) << "the first error counts";
}

TEST_F(CommandLine, NumbersAreFinite) {
  const fs::path map = folder_ / "m.db";
  for (const char* number : {"nan", "inf"}) {
    ExpectRefused({"serve", TheMap().map, "--watch", number}, 2, "--watch");
    ExpectRefused({"serve", TheMap().map, "--drain", number}, 2, "--drain");
    ExpectRefused({"localize", TheMap().map, "x.jpg", "--fov-deg", number}, 2, "--fov-deg");
    ExpectRefused({"build", "x", "-o", map, "--poses", "p", "--max-pose-gap", number}, 2,
                  "--max-pose-gap");
    ExpectRefused({"unwrap", "x", "-o", folder_, "--mirror", number, "1", "2", "3"}, 2, "--mirror");
    ExpectRefused({"build", "x", "-o", map, "--set", std::string("max_skipped_share=") + number}, 2,
                  "it must be a finite number");
  }
}

}  // namespace
}  // namespace waystone
