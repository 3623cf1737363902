// SPDX-License-Identifier: Apache-2.0
// What the program says of a command line, of files beside maps, and of an output that can't be
// written.
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <sys/wait.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "tests/e2e/calibrated_maps.h"
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
  // More than a pipe takes, to one that is closed after a line: whether that ends the program or
  // not, and whatever this test has inherited.
  for (const auto& [signal, expected] :
       {std::pair("default", "141\n"), std::pair("ignore", "0\n")}) {
    const std::string errors = folder_ / "err", status = folder_ / "status";
    const std::string command = std::string("{ env --") + signal + "-signal=PIPE " +
                                WAYSTONE_PROGRAM + " options --markdown 2>" + errors +
                                "; echo $? >" + status + "; } | head -1 >/dev/null";
    EXPECT_EQ(std::system(command.c_str()), 0);  // NOLINT(cert-env33-c)
    EXPECT_EQ(ReadFile(status), expected);
    EXPECT_EQ(ReadFile(errors), "");
  }
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

TEST_F(CommandLine, FlagsThatMeanNothingAreRefused) {
  const fs::path map = folder_ / "m.db";
  ExpectRefused({"build", "x", "-o", map, "--scale-by", "a", "b", "1"}, 2, "requires --poses");
  ExpectRefused(
      {"build", "x", "-o", map, "--poses", "p", "--unit", "metres", "--scale-by", "a", "b", "1"}, 2,
      "--scale-by scales poses of unknown unit");
  ExpectRefused({"build", "x", "-o", map, "--max-pose-gap", "1"}, 2, "requires --poses");
  ExpectRefused({"add", map, "x", "--body-from-camera", "0 0 0 0 0 0 1"}, 2, "requires --poses");
  ExpectRefused({"build", "x", "-o", map, "--set", "image_width=99", "--set", "image_width=98"}, 2,
                "--set image_width is given twice");
  ExpectRefused({"publish", TheMap().map, "--to", folder_, "--name", ""}, 2, "--name is empty");
  ExpectRefused({"localize", TheMap().map, "x", "--server", ""}, 2, "--server is empty");
  ExpectRefused({"build", "x", "-o", ""}, 2, "--output is empty");
  ExpectRefused({"serve", TheMap().map, "--host", ""}, 2, "--host is empty");
  ExpectRefused({"info", ""}, 2, "map is empty");
  ExpectRefused({"--foo"}, 2, "unknown option '--foo'");
  ExpectRefused({"--foo", "info"}, 2, "unknown option '--foo'");
  for (const char* ids : {"1,,2", ",1", "1,", ""}) {
    const std::string flag = std::string("--keyframes=") + ids;
    ExpectRefused({"remove", TheMap().map, flag}, 2,
                  *ids == '\0' ? "--keyframes" : "'' is not an id");
  }
}

TEST_F(CommandLine, FilesThatNeverEndAreRefused) {
  const fs::path map = folder_ / "m.db", pipe = folder_ / "pipe";
  fs::copy_file(ThePosedHall().map, map);
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  const std::string limits = "ulimit -v 4000000; timeout 20";
  for (const std::string& file : {std::string("/dev/zero"), pipe.string()}) {
    const auto refuse = [&](const std::vector<std::string>& arguments, const std::string& about) {
      ExpectRefused(arguments, 3, about, limits);
    };
    refuse({"plan", map, file, "--anchor", "1,1=0,0", "--anchor", "9,9=1,1"}, "not a regular file");
    refuse({"name", map, "--from", file}, "not a regular file");
    refuse({"localize", map, file}, "not a regular file");
    refuse({"compass", file, file}, "not a regular file");
    refuse({"unwrap", file, "-o", folder_}, "not a regular file");
    refuse({"eval", map, file}, "not a regular file");
    refuse({"eval", "trajectory", file, file}, "not a regular file");
    refuse({"build", TheMap().images, "-o", folder_ / "n.db", "--quiet", "--poses", file},
           "not a regular file");
  }
}

TEST_F(CommandLine, ServersAreGivenByTheirAddress) {
  for (const char* server : {"ftp://x", "nowhere", "127.0.0.1:8080"}) {
    ExpectRefused({"localize", "-", TheMap().inside, "--server", server}, 2,
                  "is no address of a server");
  }
  WriteFile(folder_ / "tokens", "\n# none yet\n");
  ExpectRefused({"localize", "-", TheMap().inside, "--server", "http://127.0.0.1:1", "--token-file",
                 folder_ / "tokens"},
                2, "has no tokens");
}

}  // namespace
}  // namespace waystone
