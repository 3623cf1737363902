// SPDX-License-Identifier: Apache-2.0
// Map files that were made to harm: each is refused in one line, or read as the sound map that it
// was, in little time and memory. Each is tried in a process of its own.
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <iostream>

#include "schema/file/map_store.h"
#include "tests/schema/crafted_maps.h"
#include "tests/schema/made_map.h"

namespace waystone {
namespace {

namespace fs = std::filesystem;

#ifdef WAYSTONE_SANITIZED
constexpr bool kMeasured = false;  // a sanitizer needs memory and time of its own
#else
constexpr bool kMeasured = true;
#endif
constexpr int64_t kMostMemory = 100'000'000;  // above the file's size
constexpr double kMostSeconds = 2;
constexpr int kHangs_s = 10;

// A line of /proc/self/status, in bytes.
int64_t StatusBytes(const std::string& field) {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);) {
    if (line.starts_with(field + ":")) return std::stoll(line.substr(field.size() + 1)) * 1024;
  }
  return 0;
}

double ProcessSeconds() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_utime.tv_sec + usage.ru_stime.tv_sec) +
         1e-6 * static_cast<double>(usage.ru_utime.tv_usec + usage.ru_stime.tv_usec);
}

bool IsOneHarmlessLine(const std::string& text) {
  return !text.empty() && std::ranges::none_of(text, [](char c) {
    return (static_cast<unsigned char>(c) < 0x20) || c == '\x7f';
  }) && text.find("\u009b") == std::string::npos;
}

// What went wrong with one file; empty for nothing. Runs in the child.
class Attempt {
 public:
  Attempt(const fs::path& path, const MapData& map, bool sound)
      : path_(path), map_(map), sound_(sound) {}

  std::string Run() {
    ExpectAnswer("read", [&] { return WithoutVersion(ReadMap(path_)) == map_; });
    ExpectAnswer("check", [&] { return FindsNothing(); });
    ExpectAnswer("sizes", [&] { return !TableSizes(path_).empty(); });
    // As a map of an older version, it goes through the checks before a migration. Then nothing of
    // it can be right.
    std::string bytes = ReadFile(path_);
    if (bytes.size() < 100) return failures_;
    bytes.replace(60, 4, std::string("\0\0\0\4", 4));
    WriteFile(path_, bytes);
    sound_ = false;
    ExpectAnswer("migrate", [&] { return MigrateMap(path_) > 0; });
    return failures_;
  }

 private:
  bool FindsNothing() {
    const std::vector<MapProblem> problems = CheckMap(path_);
    for (const MapProblem& problem : problems) {
      ExpectOneLine("check", problem.where + ": " + problem.message);
    }
    return problems.empty();
  }

  template <class Accepts>
  void ExpectAnswer(const std::string& step, const Accepts& accepts) {
    try {
      // TableSizes looks at the pages and the schema, not at what the rows mean.
      const bool accepted = accepts();
      if (accepted != sound_ && (step != "sizes" || sound_)) {
        Fail(step, accepted ? "accepted" : "read as another map");
      }
    } catch (const MapError& error) {
      const bool known = error.code() == ErrorCode::kMapDamaged ||
                         error.code() == ErrorCode::kNotAMap ||
                         error.code() == ErrorCode::kMapVersion;
      if (sound_ || !known) Fail(step, std::string("refused: ") + error.what());
      ExpectOneLine(step, error.what());
    } catch (const std::exception& error) {
      Fail(step, std::string("threw ") + error.what());
    }
  }

  void ExpectOneLine(const std::string& step, const std::string& text) {
    if (!IsOneHarmlessLine(text) && failures_.find("not one line") == std::string::npos) {
      Fail(step, "not one line");
    }
    // What SQLite says of a statement that was ended, which tells a user nothing.
    if (text.ends_with("interrupted")) Fail(step, text);
  }

  void Fail(const std::string& step, const std::string& what) {
    failures_ += "  " + step + ": " + what + "\n";
  }

  fs::path path_;
  const MapData& map_;
  bool sound_;
  std::string failures_;
};

struct Outcome {
  std::string failures;
  int64_t memory = 0;  // above what there was before
  double seconds = 0;
};

// Limits that a file which does harm runs into, instead of the machine.
void LimitProcess() {
  if (!kMeasured) return;
  const rlimit seconds{kHangs_s, kHangs_s};
  setrlimit(RLIMIT_CPU, &seconds);
  const auto bytes = static_cast<rlim_t>(StatusBytes("VmSize") + 1'500'000'000);
  const rlimit memory{bytes, bytes};
  setrlimit(RLIMIT_AS, &memory);
}

Outcome TryInProcess(const fs::path& path, const MapData& map, bool sound) {
  int ends[2];
  if (pipe(ends) != 0) return {"  no pipe\n"};
  const pid_t child = fork();
  if (child == 0) {
    LimitProcess();
    std::ofstream("/proc/self/clear_refs") << 5;  // the peak starts anew
    const int64_t before = StatusBytes("VmRSS");
    const double start = ProcessSeconds();
    const std::string failures = Attempt(path, map, sound).Run();
    const std::string report = std::to_string(StatusBytes("VmHWM") - before) + " " +
                               std::to_string(ProcessSeconds() - start) + " " + failures;
    _exit(write(ends[1], report.data(), report.size()) == std::ssize(report) ? 0 : 1);
  }
  close(ends[1]);
  std::string report;
  char buffer[4096];
  for (ssize_t got; (got = read(ends[0], buffer, sizeof(buffer))) > 0;) report.append(buffer, got);
  close(ends[0]);
  int status = 0;
  waitpid(child, &status, 0);
  if (status != 0) return {"  ended by status " + std::to_string(status) + "\n", 0, kHangs_s};
  Outcome outcome;
  size_t end = 0;
  outcome.memory = std::stoll(report, &end);
  size_t length = 0;
  outcome.seconds = std::stod(report.substr(end), &length);
  outcome.failures = report.substr(end + length + 1);
  return outcome;
}

class CraftedMapsTest : public testing::Test {
 protected:
  CraftedMapsTest() { WriteMap(map_, folder_ / "sound.db", {}); }

  void Try(const CraftedMap& crafted) {
    SCOPED_TRACE(crafted.name);
    const fs::path path = folder_ / "m.db";
    fs::copy_file(folder_ / "sound.db", path, fs::copy_options::overwrite_existing);
    crafted.make(path);
    const auto bytes = static_cast<int64_t>(fs::file_size(path));
    ASSERT_NE(ReadFile(path), ReadFile(folder_ / "sound.db")) << "nothing was crafted";
    const Outcome outcome = TryInProcess(path, map_, crafted.sound);
    EXPECT_EQ(outcome.failures, "");
    if (kMeasured) {
      EXPECT_LT(outcome.memory, bytes + kMostMemory);
      EXPECT_LT(outcome.seconds, kMostSeconds);
    }
    most_memory_ = std::max(most_memory_, outcome.memory - bytes);
    most_seconds_ = std::max(most_seconds_, outcome.seconds);
    ++tried_;
  }

  void TearDown() override {
    std::cout << tried_ << " databases; at most " << most_memory_ / 1'000'000
              << " MB above the file's size and " << most_seconds_ << " s\n";
  }

  TemporaryFolder folder_;
  MapData map_ = MadeMap(2);
  int tried_ = 0;
  int64_t most_memory_ = 0;
  double most_seconds_ = 0;
};

TEST_F(CraftedMapsTest, ByStatements) {
  for (const CraftedMap& crafted : CraftedByStatements()) Try(crafted);
  EXPECT_GT(tried_, 40);
}

TEST_F(CraftedMapsTest, ByBytes) {
  for (const CraftedMap& crafted : CraftedByBytes()) Try(crafted);
  EXPECT_GT(tried_, 40);
}

}  // namespace
}  // namespace waystone
