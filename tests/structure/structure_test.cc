// SPDX-License-Identifier: Apache-2.0
// The walls of the house, as docs/design.md draws them: who may include whom, and what every source
// file starts with.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <optional>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

namespace waystone {
namespace {

namespace fs = std::filesystem;

struct SourceFile {
  std::string path;  // relative to the repository
  std::string text;
};

// Which of our top folders each one may include, itself included.
const std::map<std::string, std::set<std::string>>& AllowedFolders() {
  static const std::map<std::string, std::set<std::string>> allowed = {
      {"core", {"core"}},
      {"world", {"world", "core"}},
      {"schema", {"schema", "core"}},
      {"localizer", {"localizer", "schema", "core"}},
      {"quality", {"quality", "localizer", "schema", "core"}},
      {"builder", {"builder", "localizer", "schema", "world", "core"}},
      {"api", {"api", "quality", "localizer", "schema", "core"}},
      {"registry", {"registry", "api", "quality", "localizer", "schema", "core"}},
      {"server", {"server", "registry", "api", "quality", "localizer", "schema", "core"}},
      {"cli",
       {"cli", "clients", "server", "registry", "api", "quality", "builder", "localizer", "schema",
        "world", "core"}},
      {"clients", {"clients"}},
      {"bench",
       {"bench", "cli", "server", "api", "quality", "builder", "localizer", "schema", "world",
        "core"}},
      {"tests",
       {"tests", "bench", "clients", "cli", "server", "registry", "api", "quality", "builder",
        "localizer", "schema", "world", "core"}},
  };
  return allowed;
}

// The order of core's own folders: each may include itself and those of lower rank.
const std::map<std::string, int>& CoreRanks() {
  static const std::map<std::string, int> ranks = {
      {"base", 0},       {"geometry", 1},     {"robust", 1},      {"image", 2},
      {"camera", 2},     {"features", 3},     {"homography", 3},  {"search", 4},
      {"panorama", 4},   {"manhattan", 4},    {"two_view", 4},    {"trajectory", 2},
      {"pose_graph", 2}, {"localization", 2}, {"camera_pose", 4},
  };
  return ranks;
}

// The rooms of a top folder, the lowest level first: a file may include its own room and those of
// lower levels. "" is the folder itself. Layers of one level know nothing of each other, but for
// those in Entwined().
using RoomLevels = std::vector<std::vector<std::string>>;

const std::map<std::string, RoomLevels>& Rooms() {
  static const std::map<std::string, RoomLevels> rooms = {
      {"localizer",
       {{"verdict"},
        {"index"},
        {"planes", "appearance", "orientation", "poses"},
        {"coarse"},
        {""}}},
      {"schema", {{"tables"}, {"layers", ""}, {"file"}}},
      {"builder",
       {{"sources"},
        {"frames"},
        {"planes", "appearance", "orientation"},
        {"poses"},
        {"calibration"},
        {""},
        {"report", "joining"}}},
      {"server", {{"web", "http"}, {"service"}}},
      {"cli", {{"files", "output", "system"}, {"commands"}, {""}}},
  };
  return rooms;
}

// Rooms whose levels may include each other: a map's data are its layers, and layers are checked as
// parts of a map.
const std::set<std::string>& Entwined() {
  static const std::set<std::string> folders = {"schema"};
  return folders;
}

// A library, or a part of ours, that only some folders may include.
struct Fence {
  std::regex header;
  std::vector<std::string> folders;  // path prefixes that may
};

const std::vector<Fence>& Fences() {
  static const std::vector<Fence> fences = {
      {std::regex("sqlite3\\.h|SQLiteCpp/.*"),
       {"schema/", "cli/files/colmap_database.cc", "tests/", "bench/"}},
      {std::regex("httplib\\.h"),
       {"server/http/http_engine.cc", "registry/http_store.cc", "cli/", "clients/", "tests/",
        "bench/"}},
      {std::regex("libpq-fe\\.h"), {"registry/postgres_database.h", "tests/"}},
      {std::regex("nlohmann/.*"),
       {"builder/options_record", "schema/sessions", "api/", "clients/", "tests/", "bench/"}},
      {std::regex("CLI/.*"), {"cli/", "bench/", "tests/"}},
      {std::regex("ceres/.*"), {"core/pose_graph/", "core/manhattan/", "tests/"}},
      {std::regex("yaml-cpp/.*"), {"builder/sources/", "cli/", "tests/"}},
      // Commands but for `serve` ask the localizer through its session and render by api/.
      {std::regex("server/.*"), {"server/", "cli/commands/serve", "bench/", "tests/"}},
  };
  return fences;
}

std::string TopFolder(const std::string& path) { return path.substr(0, path.find('/')); }

// "planes" of "localizer/planes/verify.cc", "" of "localizer/session.h".
std::string RoomOf(const std::string& path) {
  const size_t start = path.find('/') + 1;
  const size_t end = path.find('/', start);
  return end == std::string::npos ? "" : path.substr(start, end - start);
}

// The level of a room; nothing for one that has none.
std::optional<size_t> LevelOf(const RoomLevels& levels, const std::string& room) {
  for (size_t level = 0; level < levels.size(); ++level) {
    if (std::ranges::count(levels[level], room) > 0) return level;
  }
  return std::nullopt;
}

bool RoomMayInclude(const std::string& top, const std::string& from, const std::string& to) {
  if (!Rooms().count(top)) return true;
  const std::optional<size_t> a = LevelOf(Rooms().at(top), from);
  const std::optional<size_t> b = LevelOf(Rooms().at(top), to);
  return a && b && (from == to || *b < *a || (*a == *b && Entwined().count(top) > 0));
}

std::string CoreFolder(const std::string& path) {
  const size_t start = path.find('/') + 1;
  return path.substr(start, path.find('/', start) - start);
}

std::vector<std::string> IncludesOf(const std::string& text) {
  static const std::regex include(R"(^[ \t]*#[ \t]*include[ \t]*["<]([^">]+)[">])");
  std::vector<std::string> found;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    std::smatch match;
    if (std::regex_search(line, match, include)) found.push_back(match[1]);
  }
  return found;
}

bool MayInclude(const SourceFile& file, const std::string& include) {
  for (const Fence& fence : Fences()) {
    if (!std::regex_match(include, fence.header)) continue;
    bool inside = false;
    for (const std::string& prefix : fence.folders) inside |= file.path.starts_with(prefix);
    if (!inside) return false;
  }
  const std::string to = TopFolder(include);
  if (!AllowedFolders().count(to) || include.find('/') == std::string::npos) return true;
  const std::string from = TopFolder(file.path);
  if (!AllowedFolders().at(from).count(to)) return false;
  if (from == to && !RoomMayInclude(to, RoomOf(file.path), RoomOf(include))) return false;
  if (from != "core") return true;
  const std::string a = CoreFolder(file.path);
  const std::string b = CoreFolder(include);
  if (!CoreRanks().count(a) || !CoreRanks().count(b)) return false;  // a folder without a rank
  return a == b || CoreRanks().at(b) < CoreRanks().at(a);
}

std::vector<std::string> Violations(const SourceFile& file) {
  std::vector<std::string> found;
  for (const std::string& include : IncludesOf(file.text)) {
    if (!MayInclude(file, include)) found.push_back(file.path + " includes " + include);
    if (include.find('/') == std::string::npos && include.ends_with(".h") &&
        fs::exists(fs::path(WAYSTONE_SOURCE_DIR) / fs::path(file.path).parent_path() / include)) {
      found.push_back(file.path + " includes " + include + " without its full path");
    }
  }
  if (!file.text.starts_with("// SPDX-License-Identifier: Apache-2.0\n")) {
    found.push_back(file.path + " doesn't start with the SPDX line");
  }
  if (file.path.ends_with(".h") && file.text.find("\n#pragma once\n") == std::string::npos) {
    found.push_back(file.path + " has no #pragma once");
  }
  return found;
}

// The headers that say that they are "internal to FOLDER", with that folder.
std::map<std::string, std::string> InternalHeaders(const std::vector<SourceFile>& files) {
  static const std::regex new_line("\n// ");
  static const std::regex note(R"([Ii]nternal to ([a-z_]+(/[a-z_]+)*))");
  std::map<std::string, std::string> internal;
  for (const SourceFile& file : files) {
    std::smatch match;
    if (!file.path.ends_with(".h") || file.path.starts_with("tests/")) continue;
    const std::string text = std::regex_replace(file.text, new_line, " ");
    if (std::regex_search(text, match, note)) internal[file.path] = match[1];
  }
  return internal;
}

// Includes of internal headers from elsewhere than their folder, its tests and the fuzzers, and
// headers that name a folder which isn't theirs.
std::vector<std::string> InternalViolations(const std::vector<SourceFile>& files) {
  const std::map<std::string, std::string> internal = InternalHeaders(files);
  std::vector<std::string> found;
  for (const auto& [header, folder] : internal) {
    if (!header.starts_with(folder + "/")) {
      found.push_back(header + " says that it is internal to " + folder + ", where it isn't");
    }
  }
  for (const SourceFile& file : files) {
    for (const std::string& include : IncludesOf(file.text)) {
      const auto it = internal.find(include);
      if (it == internal.end() || file.path.starts_with(it->second + "/") ||
          file.path.starts_with("tests/" + it->second + "/") ||
          file.path.starts_with("tests/fuzz/")) {
        continue;
      }
      found.push_back(file.path + " includes " + include + ", which is internal to " + it->second);
    }
  }
  return found;
}

std::vector<SourceFile> AllSources() {
  std::vector<SourceFile> files;
  const fs::path root = WAYSTONE_SOURCE_DIR;
  for (const auto& [folder, allowed] : AllowedFolders()) {
    if (!fs::exists(root / folder)) continue;
    for (const auto& entry : fs::recursive_directory_iterator(root / folder)) {
      const std::string extension = entry.path().extension();
      if (extension != ".h" && extension != ".cc") continue;
      std::ifstream in(entry.path());
      std::stringstream text;
      text << in.rdbuf();
      files.push_back({fs::relative(entry.path(), root).string(), text.str()});
    }
  }
  return files;
}

TEST(Structure, IncludesFollowTheGrain) {
  const std::vector<SourceFile> files = AllSources();
  ASSERT_GT(files.size(), 20u) << "the sources weren't found under " << WAYSTONE_SOURCE_DIR;
  for (const SourceFile& file : files) {
    for (const std::string& violation : Violations(file)) ADD_FAILURE() << violation;
  }
}

TEST(Structure, InternalHeadersStayInside) {
  const std::vector<SourceFile> files = AllSources();
  EXPECT_GE(InternalHeaders(files).size(), 5u) << "the notes are written otherwise now";
  for (const std::string& violation : InternalViolations(files)) ADD_FAILURE() << violation;
}

// What the test above looks for, planted: each line must be found out.
TEST(Structure, PlantedViolationsAreFound) {
  const std::vector<std::pair<std::string, std::string>> planted = {
      {"core/base/x.cc", "#include \"schema/map_data.h\""},
      {"core/base/x.cc", "#include \"core/features/features.h\""},
      {"core/base/x.cc", "#include \"core/geometry/rotation.h\""},
      {"core/robust/x.h", "#pragma once\n#include \"core/features/features.h\""},
      {"core/camera/x.cc", "#include \"core/image/decode.h\""},
      {"core/unranked/x.cc", "#include \"core/base/check.h\""},
      {"core/base/x.cc", "#include <nlohmann/json.hpp>"},
      {"world/x.cc", "#include \"schema/map_data.h\""},
      {"schema/x.cc", "#include \"localizer/verdict/answer.h\""},
      {"localizer/x.cc", "#include \"builder/build_map.h\""},
      {"localizer/x.cc", "#include <SQLiteCpp/SQLiteCpp.h>"},
      {"builder/x.cc", "#include \"server/http/router.h\""},
      {"builder/x.cc", "#  include  <sqlite3.h>"},
      {"server/http/x.cc", "#include \"builder/build_map.h\""},
      {"server/http/x.cc", "  #include \"cli/commands/commands.h\""},
      {"server/http/x.cc", "#include <httplib.h>"},
      {"registry/x.cc", "#include <httplib.h>"},
      {"registry/x.cc", "#include <libpq-fe.h>"},
      {"registry/x.cc", "#include \"server/http/router.h\""},
      {"clients/cpp/x.cc", "#include \"localizer/verdict/answer.h\""},
      {"api/x.cc", "#include \"server/http/router.h\""},
      {"cli/commands/replay.cc", "#include \"server/http/router.h\""},
      {"localizer/verdict/x.cc", "#include \"localizer/index/map_index.h\""},
      {"localizer/verdict/x.cc", "#include \"localizer/planes/verify.h\""},
      {"localizer/planes/x.cc", "#include \"localizer/appearance/appearance.h\""},
      {"localizer/orientation/x.cc", "#include \"localizer/planes/verify.h\""},
      {"localizer/appearance/x.cc", "#include \"localizer/session.h\""},
      {"localizer/unknown/x.cc", "#include \"localizer/verdict/answer.h\""},
      {"schema/tables/x.cc", "#include \"schema/file/map_store.h\""},
      {"schema/tables/x.cc", "#include \"schema/layers/planes/plane_layer.h\""},
      {"schema/layers/x.cc", "#include \"schema/file/map_store.h\""},
      {"builder/sources/x.cc", "#include \"builder/planes/keyframe_selector.h\""},
      {"builder/planes/x.cc", "#include \"builder/build_map.h\""},
      {"builder/appearance/x.cc", "#include \"builder/planes/fusion.h\""},
      {"server/web/x.cc", "#include \"server/http/router.h\""},
      {"server/http/x.cc", "#include \"server/service/map_catalog.h\""},
      {"cli/files/x.cc", "#include \"cli/commands/settings.h\""},
  };
  const std::string spdx = "// SPDX-License-Identifier: Apache-2.0\n";
  for (const auto& [path, line] : planted) {
    EXPECT_EQ(Violations({path, spdx + line + "\n"}).size(), 1u) << path << ": " << line;
  }
  EXPECT_EQ(Violations({"core/base/x.cc", "#include <vector>\n"}).size(), 1u);
  EXPECT_EQ(Violations({"core/base/x.h", spdx + "int x;\n"}).size(), 1u);
}

TEST(Structure, PlantedUsesOfInternalHeadersAreFound) {
  const SourceFile header = {"core/image/x.h", "// Parsers. Internal to\n// core/image.\n"};
  const std::string include = "#include \"core/image/x.h\"\n";
  EXPECT_TRUE(InternalViolations(
                  {header, {"core/image/x.cc", include}, {"tests/core/image/x_test.cc", include}})
                  .empty());
  for (const std::string path : {"core/camera/x.cc", "core/image_x/x.cc", "tests/core/x.cc"}) {
    EXPECT_EQ(InternalViolations({header, {path, include}}).size(), 1u) << path;
  }
  EXPECT_EQ(InternalViolations({{"api/x.h", "// Parsers: internal to quality.\n"}}).size(), 1u);
}

TEST(Structure, SoundFilesPass) {
  const std::string spdx = "// SPDX-License-Identifier: Apache-2.0\n";
  const std::string includes =
      "#include <vector>\n#include <httplib.h>\n#include \"server/http/router.h\"\n"
      "#include \"core/base/error.h\"\n// #include \"builder/build_map.h\"\n";
  EXPECT_TRUE(Violations({"server/http/http_engine.cc", spdx + includes}).empty());
}

}  // namespace
}  // namespace waystone
