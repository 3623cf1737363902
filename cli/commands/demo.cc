// SPDX-License-Identifier: Apache-2.0
#include <unistd.h>

#include <filesystem>
#include <iostream>
#include <memory>
#include <string>
#include <vector>

#include "api/json.h"
#include "cli/commands/asked_server.h"
#include "cli/commands/commands.h"
#include "cli/commands/demo_world.h"
#include "cli/files/map_file.h"
#include "cli/output/printable_output.h"
#include "cli/output/progress.h"
#include "cli/system/child_process.h"
#include "core/base/error.h"

namespace waystone {
namespace {

namespace fs = std::filesystem;

constexpr int kUnexpectedAnswer = 4;

struct DemoFlags {
  std::string write_folder;
  std::string keep_folder;
  std::string setting;
};

// The working folder: the user's, or a temporary one that is removed.
class DemoFolder {
 public:
  explicit DemoFolder(const std::string& keep) : keep_(!keep.empty()), path_(keep) {
    if (keep_) {
      MakeFolder();
    } else {
      std::string name = (fs::temp_directory_path() / "waystone-demo-XXXXXX").string();
      if (mkdtemp(name.data()) == nullptr) {
        throw MapError(ErrorCode::kFileUnwritable, "can't create a folder in " +
                                                       fs::temp_directory_path().string() +
                                                       "; set TMPDIR or use --keep DIR");
      }
      path_ = name;
    }
  }
  ~DemoFolder() {
    std::error_code ignored;
    if (!keep_) fs::remove_all(path_, ignored);
  }
  DemoFolder(const DemoFolder&) = delete;
  DemoFolder& operator=(const DemoFolder&) = delete;

  const fs::path& path() const { return path_; }
  bool kept() const { return keep_; }

 private:
  void MakeFolder() const {
    std::error_code error;
    fs::create_directories(path_, error);
    if (error) {
      throw MapError(ErrorCode::kFileUnwritable, "can't create " + path_.string() + ": " +
                                                     error.message() + "; choose another folder");
    }
  }

  bool keep_;
  fs::path path_;
};

void WriteWalkWithProgress(const fs::path& dir) {
  ProgressMeter meter(RawErrors(), ProgressStyleByName("auto", false), ColoursWelcome());
  WriteDemoWalk(dir, [&meter](int done, int total) { meter.Update({"images", done, total, ""}); });
}

void Say(const std::string& text) { std::cout << text << std::endl; }

void Build(const fs::path& images, const fs::path& map) {
  Say("\n$ waystone build " + images.string() + " -o " + map.string());
  ChildProcess build({ThisProgram(), "build", images.string(), "-o", map.string()}, false);
  const int code = build.Wait();
  if (code != 0) {
    throw MapError(ErrorCode::kInternal,
                   "waystone build exited with status " + std::to_string(code) + "; see above");
  }
}

// The address in "Serving 1 map at http://127.0.0.1:40001".
std::string UrlIn(const std::string& line) {
  const size_t at = line.find("http://");
  if (at == std::string::npos) {
    throw MapError(ErrorCode::kInternal, "the server didn't start; see above");
  }
  return line.substr(at);
}

struct Question {
  fs::path photo;
  std::string about;
  std::string expected;
};

// Queries the server as curl would. Returns the verdict.
std::string Ask(const std::string& url, const Question& question) {
  const std::string path = "/v1/maps/demo/localize";
  Say("\n" + question.about + ":\n$ curl --data-binary @" + question.photo.string() +
      " -H 'Content-Type: image/jpeg' " + url + path);
  const std::vector<uint8_t> photo = ReadBytes(question.photo);
  Json answer = AskServer({url, ""}, "demo", question.photo.filename().string(),
                          std::string(photo.begin(), photo.end()));
  std::string verdict = answer.value("verdict", "no verdict");
  // Abridged: the matrices and outlines of planes would fill a page.
  if (answer.contains("planes")) {
    for (Json& plane : answer["planes"]) {
      plane.erase("outline");
      plane.erase("reference_from_query");
    }
  }
  Say(Dump(answer));
  return verdict;
}

int AskAll(const std::string& url, const DemoPhotos& photos) {
  int code = 0;
  for (const Question& question : std::vector<Question>{
           {photos.right, "A photo from a viewpoint that is not in the sequence", "localized"},
           {photos.elsewhere, "A photo from another building", "not_in_map"},
           {photos.broken, "The first photo, truncated", "bad_image"}}) {
    const std::string verdict = Ask(url, question);
    if (verdict == question.expected) continue;
    std::cerr << "waystone: expected " << question.expected << ", got " << verdict << '\n';
    code = kUnexpectedAnswer;
  }
  return code;
}

int RunWriteSetting(const DemoFlags& flags) {
  ProgressMeter meter(RawErrors(), ProgressStyleByName("auto", false), ColoursWelcome());
  WriteSetting(flags.setting, flags.write_folder, [&meter](int done, int total) {
    meter.Update({"panoramas", done, total, ""});
  });
  Say("Panoramas: " + flags.write_folder + "/panorama, poses: " + flags.write_folder +
      "/poses.csv; README.txt describes each file.\n" + "Next: waystone eval trajectory " +
      flags.write_folder + "/odometry.csv " + flags.write_folder + "/poses.csv");
  return 0;
}

int RunDemo(const DemoFlags& flags) {
  if (!flags.setting.empty()) return RunWriteSetting(flags);
  if (!flags.write_folder.empty()) {
    WriteWalkWithProgress(flags.write_folder);
    WriteDemoQueries(flags.write_folder);
    Say("Wrote the sequence to " + flags.write_folder + "; README.txt describes each file.\n" +
        "Next: waystone build " + flags.write_folder + "/images -o demo.db\n" +
        "then: waystone eval demo.db " + flags.write_folder + "/queries.csv --poses " +
        flags.write_folder + "/poses.csv");
    return 0;
  }
  const DemoFolder folder(flags.keep_folder);
  const fs::path walk = folder.path() / "walk";
  const fs::path map = folder.path() / "demo.db";
  Say("Rendering a walk through a synthetic building (640x480 pixels) ...");
  WriteWalkWithProgress(walk);
  const DemoPhotos photos = WriteDemoPhotos(folder.path());
  Build(walk / "images", map);
  Say("\n$ waystone serve " + map.string());
  ChildProcess server({ThisProgram(), "serve", map.string(), "--port", "0"}, true);
  const std::string url = UrlIn(server.ReadLine());
  Say("Serving at " + url);
  const int code = AskAll(url, photos);
  Say("\nDone. Answers are abridged here: outlines and homographies are left out.");
  Say(folder.kept() ? "Next: waystone serve " + map.string()
                    : "To keep the sequence, the map and the photos: waystone demo --keep DIR");
  return code;
}

}  // namespace

void AddDemo(CLI::App& app, Run& run) {
  auto flags = std::make_shared<DemoFlags>();
  CLI::App* command = app.add_subcommand(
      "demo", "Map a synthetic building, serve the map and localize three photos");
  CLI::Option* write =
      command->add_option("--write", flags->write_folder,
                          "Only write the sequence and its ground truth to this new folder");
  command->add_option("--keep", flags->keep_folder, "Work in this new folder and keep its contents")
      ->excludes(write);
  command
      ->add_option("--setting", flags->setting,
                   "Write a drive of a robot with panoramas instead: office (200 images) or "
                   "laboratory (150)")
      ->needs(write);
  command->footer(
      "Takes about a minute.\nExample: waystone demo --keep demo\n"
      "         waystone demo --write office --setting office");
  command->callback([flags, &run] { run = [flags] { return RunDemo(*flags); }; });
}

}  // namespace waystone
