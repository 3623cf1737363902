// SPDX-License-Identifier: Apache-2.0
// The program as a user runs it: what it prints, where, and what it returns.
#include <Eigen/Core>  // before macros of headers that the HTTP library includes

#include <gtest/gtest.h>
#include <httplib.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <filesystem>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>
#include <sstream>
#include <string>
#include <thread>

#include "api/json.h"
#include "cli/system/child_process.h"
#include "tests/core/image/made_heic.h"
#include "tests/e2e/shared_map.h"

namespace waystone {
namespace {

namespace fs = std::filesystem;

// A folder that goes away with the test.
class CliTest : public testing::Test {
 protected:
  ~CliTest() override { fs::remove_all(folder_); }

  // One line on stderr that starts with our name; nothing on stdout.
  static void ExpectFailure(const RunResult& result, int code, const std::string& about) {
    EXPECT_EQ(result.code, code) << result.err;
    EXPECT_EQ(result.out, "");
    EXPECT_EQ(std::count(result.err.begin(), result.err.end(), '\n'), 1) << result.err;
    EXPECT_TRUE(result.err.starts_with("waystone: ")) << result.err;
    EXPECT_NE(result.err.find(about), std::string::npos) << result.err;
  }

  size_t FilesIn(const fs::path& folder) const {
    return static_cast<size_t>(
        std::distance(fs::directory_iterator(folder), fs::directory_iterator()));
  }

  const fs::path folder_ = FreshFolder();
};

TEST_F(CliTest, BuildPrintsWhatItBuilt) {
  const RunResult& build = TheMap().build;
  ASSERT_EQ(build.code, 0) << build.err;
  const Json json = Json::parse(build.out);
  EXPECT_GE(json["keyframes"].get<int>(), 2);
  EXPECT_GE(json["planes"].get<int>(), 1);
  EXPECT_GT(json["features"].get<int>(), 40);
  EXPECT_GT(json["bytes"].get<int>(), 0);
  EXPECT_EQ(json["skipped"], 0);
  EXPECT_TRUE(json["version"].get<std::string>().starts_with("sha256:"));
  EXPECT_TRUE(json["seconds"].contains("total"));
  EXPECT_FALSE(json["tables"].empty());
  EXPECT_EQ(build.err.find('\x1b'), std::string::npos) << "escapes where there is no terminal";
}

TEST_F(CliTest, SameBytesWithOneThreadAndTwo) {
  const fs::path out = folder_ / "room.db";
  const RunResult result =
      RunWaystone({"build", TheMap().images, "-o", out, "--threads", "1", "--quiet"});
  ASSERT_EQ(result.code, 0) << result.err;
  EXPECT_EQ(result.out + result.err, "") << "--quiet isn't";
  EXPECT_TRUE(ReadFile(out) == ReadFile(TheMap().map));
}

TEST_F(CliTest, AFileSizeLimitIsAnErrorLikeAFullDisk) {
  fs::create_directory(folder_ / "maps");
  const fs::path out = folder_ / "maps" / "room.db";
  // Blocks of 512 bytes or of 1024, depending on the shell: either is too few for a map.
  const RunResult result = RunWaystone(
      {"build", TheMap().images, "-o", out, "--every", "4", "--quiet"}, "ulimit -f 64;");
  ExpectFailure(result, 3, out.string());
  EXPECT_EQ(FilesIn(folder_ / "maps"), 0u) << "a part of a map was left behind";
}

TEST_F(CliTest, InputsAreNeverOverwritten) {
  const fs::path walk = folder_ / "walk";
  fs::copy(TheMap().images, walk, fs::copy_options::recursive);
  const fs::path photo = fs::directory_iterator(walk)->path();
  const std::string before = ReadFile(photo);
  ExpectFailure(RunWaystone({"build", walk, "-o", photo, "--force"}), 3,
                "only maps are overwritten");
  EXPECT_TRUE(ReadFile(photo) == before);
  fs::create_directory(folder_ / "images");
  ExpectFailure(RunWaystone({"build", walk, "-o", folder_ / "m.db", "--report", folder_}), 3,
                "choose another folder");
  const fs::path map = folder_ / "copy.db";
  fs::copy_file(TheMap().map, map);
  ExpectFailure(RunWaystone({"export", map, "-o", map, "--force"}), 3, "choose another name");
  EXPECT_TRUE(ReadFile(map) == ReadFile(TheMap().map));
}

TEST_F(CliTest, FlagsOfAnotherFormatAreRefused) {
  ExpectFailure(RunWaystone({"export", TheMap().map, "--images", TheMap().images}), 2,
                "--format colmap");
  ExpectFailure(RunWaystone({"export", TheMap().map, "--format", "dot", "--max-features", "5"}), 2,
                "the format is dot");
}

// Three quarters of the photos were lost on their way.
TEST_F(CliTest, AMostlyUnreadableSequenceIsNoMapAndTheOldOneStays) {
  const fs::path walk = folder_ / "walk";
  fs::copy(TheMap().images, walk, fs::copy_options::recursive);
  std::vector<fs::path> photos(fs::directory_iterator(walk), {});
  std::ranges::sort(photos);
  for (size_t i = 0; i < photos.size(); ++i) {
    if (i % 4 != 0) WriteFile(photos[i], "lost");
  }
  const fs::path map = folder_ / "room.db";
  fs::copy_file(TheMap().map, map);
  const RunResult result = RunWaystone({"build", walk, "-o", map, "--force", "--quiet"});
  ExpectFailure(result, 4, "max_skipped_share");
  EXPECT_TRUE(ReadFile(map) == ReadFile(TheMap().map));
}

// The header of a video that wasn't copied to its end has the number of all of its frames.
TEST_F(CliTest, FramesThatAVideoLacksAreSkippedAndMostOfThemAreNoMap) {
  const fs::path video = folder_ / "walk.avi";
  {
    cv::VideoWriter writer(video.string(), cv::VideoWriter::fourcc('M', 'J', 'P', 'G'), 10,
                           {640, 480}, false);
    ASSERT_TRUE(writer.isOpened());
    for (size_t i = 0; i < FilesIn(TheMap().images); ++i) {
      writer.write(cv::imread((TheMap().images / (std::to_string(i) + ".jpg")).string(),
                              cv::IMREAD_GRAYSCALE));
    }
  }
  const auto bytes = fs::file_size(video);
  fs::resize_file(video, bytes * 7 / 10);
  const fs::path map = folder_ / "walk.db";
  const RunResult some = RunWaystone({"build", video, "-o", map, "--every", "2"});
  EXPECT_EQ(some.code, 0) << some.err;
  EXPECT_EQ(some.out.find(" 0 skipped"), std::string::npos) << some.out;
  EXPECT_NE(some.out.find("it is missing: the video ends after "), std::string::npos) << some.out;
  fs::resize_file(video, bytes * 3 / 10);
  const RunResult few =
      RunWaystone({"build", video, "-o", map, "--every", "2", "--force", "--quiet"});
  ExpectFailure(few, 4, "it is missing: the video ends after ");
}

TEST_F(CliTest, LinksToThemselvesAreSkippedAndNamed) {
  const fs::path walk = folder_ / "walk";
  fs::copy(TheMap().images, walk, fs::copy_options::recursive);
  fs::create_symlink("loop", walk / "loop");
  fs::create_symlink("a_loop.jpg", walk / "a_loop.jpg");
  const RunResult result =
      RunWaystone({"build", walk, "-o", folder_ / "m.db", "--from", "40", "--progress", "none"});
  EXPECT_EQ(result.code, 0) << result.err;
  EXPECT_NE(result.out.find("a_loop.jpg"), std::string::npos) << result.out;
}

TEST_F(CliTest, ReportIsWritten) {
  const RunResult result = RunWaystone({"build", TheMap().images, "-o", folder_ / "r.db", "--every",
                                        "2", "--report", folder_ / "report"});
  ASSERT_EQ(result.code, 0) << result.err;
  EXPECT_NE(result.out.find("planes"), std::string::npos) << result.out;
  const std::string page = ReadFile(folder_ / "report" / "index.html");
  EXPECT_NE(page.find("<svg"), std::string::npos);
  EXPECT_EQ(page.find("http://"), std::string::npos) << "the page needs something from elsewhere";
  EXPECT_GT(FilesIn(folder_ / "report" / "images"), 1u);
}

TEST_F(CliTest, LocalizeSaysWhere) {
  const RunResult result = RunWaystone({"localize", TheMap().map, TheMap().inside});
  EXPECT_EQ(result.code, 0) << result.err;
  EXPECT_NE(result.out.find("inside.jpg: localized near "), std::string::npos) << result.out;
  EXPECT_NE(result.out.find(" inliers, "), std::string::npos) << result.out;
}

TEST_F(CliTest, APhotoIsAnsweredTheSameInAnyFormat) {
  const cv::Mat photo = cv::imread(TheMap().inside, cv::IMREAD_GRAYSCALE);
  const cv::Mat blocks = photo(cv::Rect(0, 0, photo.cols / 16 * 16, photo.rows / 16 * 16));
  cv::imwrite(folder_ / "a.png", blocks);
  cv::imwrite(folder_ / "b.webp", blocks, {cv::IMWRITE_WEBP_QUALITY, 98});
  const std::vector<uint8_t> heic = MakeHeic(blocks, {.turned = true});
  WriteFile(folder_ / "c.heic", std::string(heic.begin(), heic.end()));
  const RunResult result = RunWaystone({"localize", TheMap().map, folder_ / "a.png",
                                        folder_ / "b.webp", folder_ / "c.heic", "--json"});
  EXPECT_EQ(result.code, 0) << result.err;
  std::istringstream lines(result.out);
  std::vector<Json> answers;
  for (std::string line; std::getline(lines, line);) answers.push_back(Json::parse(line));
  ASSERT_EQ(answers.size(), 3U);
  for (const Json& answer : answers) {
    EXPECT_EQ(answer["verdict"], "localized");
    EXPECT_EQ(answer["place"]["image"], answers[0]["place"]["image"]);
  }
  EXPECT_EQ(answers[2]["planes"], answers[0]["planes"]) << "the same pixels";
}

TEST_F(CliTest, LocalizeTakesOptionsOfQueries) {
  const auto ask = [](const std::string& setting) {
    return RunWaystone({"localize", TheMap().map, TheMap().inside, "--set", setting});
  };
  EXPECT_NE(ask("planes.max_features=800").out.find(": localized near "), std::string::npos);
  EXPECT_EQ(ask("planes.gates.min_inliers=100000").out.find(": localized near "),
            std::string::npos);
  ExpectFailure(ask("planes.min_votes=0"), 2, "planes.min_votes is 0");
  ExpectFailure(ask("planes.min_vote=5"), 2, "did you mean 'planes.min_votes'");
  ExpectFailure(RunWaystone({"serve", TheMap().map, "--set", "planes.min_vote=5"}), 2,
                "did you mean 'planes.min_votes'");
}

TEST_F(CliTest, LocalizePrintsWhatAServerReturns) {
  const RunResult result =
      RunWaystone({"localize", TheMap().map, TheMap().inside, "--fov-deg", "63", "--json"});
  const Json answer = Json::parse(result.out);
  EXPECT_EQ(answer["unused"], Json::array({"camera"})) << "by a map of planes";
}

TEST_F(CliTest, LocalizeSaysByItsStatusWhatAServerSaid) {
  httplib::Server server;
  server.Post("/.*", [](const httplib::Request&, httplib::Response& out) {
    out.status = 503;
    out.set_content(R"({"code": "store_unavailable", "detail": "away"})",
                    "application/problem+json");
  });
  const int port = server.bind_to_any_port("127.0.0.1");
  std::thread serving([&] { server.listen_after_bind(); });
  const auto ask = [&](const std::vector<std::string>& more) {
    std::vector<std::string> arguments = {"localize", "-", TheMap().inside, "--server",
                                          "http://127.0.0.1:" + std::to_string(port)};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return RunWaystone(arguments);
  };
  ExpectFailure(ask({}), 6, "away");
  ExpectFailure(ask({"--tag", "\xff"}), 6, "away");
  ExpectFailure(ask({TheMap().inside, "--near", "f", "nan", "0", "5"}), 2,
                "'nan' is not a finite number");
  server.stop();
  serving.join();
}

TEST_F(CliTest, LocalizeAnswersAllPhotosAndSaysWhichCouldNotBeRead) {
  WriteFile(folder_ / "text.jpg", "this is no picture");
  const RunResult result =
      RunWaystone({"localize", TheMap().map, folder_ / "missing.jpg", TheMap().inside,
                   folder_ / "text.jpg", TheMap().elsewhere, "--json"});
  EXPECT_EQ(result.code, 3);
  EXPECT_NE(result.err.find("missing.jpg"), std::string::npos) << result.err;
  std::istringstream lines(result.out);
  std::vector<std::string> verdicts;
  for (std::string line; std::getline(lines, line);) {
    verdicts.push_back(Json::parse(line)["verdict"]);
  }
  EXPECT_EQ(verdicts, (std::vector<std::string>{"localized", "bad_image", "not_in_map"}));
}

TEST_F(CliTest, InfoAndCheck) {
  const RunResult info = RunWaystone({"info", TheMap().map, "--json"});
  EXPECT_EQ(info.code, 0) << info.err;
  EXPECT_EQ(Json::parse(info.out)["name"], "room");
  EXPECT_EQ(RunWaystone({"info", TheMap().map}).code, 0);
  const RunResult check = RunWaystone({"check", TheMap().map});
  EXPECT_EQ(check.code, 0) << check.out;
  EXPECT_EQ(Json::parse(RunWaystone({"check", TheMap().map, "--json"}).out)["ok"], true);
  EXPECT_EQ(RunWaystone({"migrate", TheMap().map}).code, 0);
}

TEST_F(CliTest, FilesThatAreNoMaps) {
  WriteFile(folder_ / "text.db", "this is no map");
  WriteFile(folder_ / "empty.db", "");
  const std::string map = ReadFile(TheMap().map);
  WriteFile(folder_ / "half.db", map.substr(0, map.size() / 2));
  for (const char* command : {"info", "serve"}) {
    for (const char* name : {"text.db", "empty.db", "half.db", "missing.db"}) {
      ExpectFailure(RunWaystone({command, folder_ / name}), 3, name);
    }
  }
  EXPECT_EQ(RunWaystone({"check", folder_ / "text.db"}).code, 3);
  EXPECT_EQ(RunWaystone({"check", folder_ / "half.db"}).code, 3);
  ExpectFailure(RunWaystone({"localize", folder_ / "half.db", TheMap().inside}), 3, "half.db");
  EXPECT_EQ(FilesIn(folder_), 3u) << "something was left beside the maps";
}

TEST_F(CliTest, BrokenMapIsFoundOut) {
  std::string map = ReadFile(TheMap().map);
  for (size_t i = map.size() / 2; i < map.size() / 2 + 2000; i += 7) map[i] ^= 0x55;
  WriteFile(folder_ / "bad.db", map);
  const RunResult check = RunWaystone({"check", folder_ / "bad.db", "--json"});
  EXPECT_EQ(check.code, 3);
}

TEST_F(CliTest, SourcesThatAreNone) {
  const std::string out = folder_ / "m.db";
  ExpectFailure(RunWaystone({"build", folder_ / "nowhere", "-o", out}), 3, "nowhere");
  fs::create_directories(folder_ / "empty");
  ExpectFailure(RunWaystone({"build", folder_ / "empty", "-o", out}), 3, "empty");
  fs::create_directories(folder_ / "text");
  WriteFile(folder_ / "text" / "1.jpg", "this is no picture");
  EXPECT_EQ(RunWaystone({"build", folder_ / "text", "-o", out, "--quiet"}).code, 3);
  EXPECT_FALSE(fs::exists(out));
}

TEST_F(CliTest, NothingIsOverwrittenUnasked) {
  WriteFile(folder_ / "there.db", "precious");
  ExpectFailure(RunWaystone({"build", TheMap().images, "-o", folder_ / "there.db"}), 3, "--force");
  EXPECT_EQ(ReadFile(folder_ / "there.db"), "precious");
  fs::copy_file(TheMap().map, folder_ / "there.db", fs::copy_options::overwrite_existing);
  const RunResult forced = RunWaystone(
      {"build", TheMap().images, "-o", folder_ / "there.db", "--force", "--every", "3"});
  EXPECT_EQ(forced.code, 0) << forced.err;
  EXPECT_FALSE(ReadFile(folder_ / "there.db") == ReadFile(TheMap().map));
  EXPECT_EQ(FilesIn(folder_), 1u);
}

TEST_F(CliTest, FoldersThatCannotBeWrittenAreSaidBeforeTheWork) {
  ExpectFailure(RunWaystone({"build", TheMap().images, "-o", folder_ / "no" / "m.db"}), 3, "no");
  ExpectFailure(RunWaystone({"build", TheMap().images, "-o", "/proc/m.db"}), 3, "/proc");
}

TEST_F(CliTest, WallsWithoutTextureGiveNoMap) {
  fs::create_directories(folder_ / "plain");
  for (const char* name : {"1.pgm", "2.pgm", "3.pgm"}) {
    WriteFile(folder_ / "plain" / name, "P5\n64 48\n255\n" + std::string(64 * 48, 'x'));
  }
  const RunResult result =
      RunWaystone({"build", folder_ / "plain", "-o", folder_ / "m.db", "--quiet"});
  ExpectFailure(result, 4, "no plane");
  EXPECT_FALSE(fs::exists(folder_ / "m.db"));
}

TEST_F(CliTest, UsageErrors) {
  const RunResult none = RunWaystone({});
  EXPECT_EQ(none.code, 2);
  for (const std::vector<std::string>& arguments : std::vector<std::vector<std::string>>{
           {},
           {"fly"},
           {"build"},
           {"build", "x"},
           {"info", "a.db", "--colour"},
           {"build", "x", "-o", "y.db", "--every", "often"},
           {"build", "x", "-o", folder_ / "y.db", "--every", "0"},
           {"build", "x", "-o", folder_ / "y.db", "--features", "surf"},
           {"build", "x", "-o", folder_ / "y.db", "--max-features", "-5"},
           {"serve", "x.db", "--port", "70000"},
           {"serve", "x.db", "--host", "0.0.0.0"},
           {"demo", "--write", "a", "--keep", "b"}}) {
    ExpectFailure(RunWaystone(arguments), 2, "; ");
  }
}

// The largest resident size of a run of the program, in MB.
int64_t PeakMegabytes(const std::vector<std::string>& arguments) {
  const pid_t child = fork();
  if (child == 0) {
    std::vector<char*> argv{const_cast<char*>(WAYSTONE_PROGRAM)};
    for (const std::string& argument : arguments)
      argv.push_back(const_cast<char*>(argument.c_str()));
    argv.push_back(nullptr);
    execv(WAYSTONE_PROGRAM, argv.data());
    _exit(127);
  }
  int status = 0;
  rusage usage{};
  wait4(child, &status, 0, &usage);
  EXPECT_EQ(status, 0);
  return usage.ru_maxrss / 1024;
}

TEST_F(CliTest, APhotoOfAnySizeIsFoundWithinTheMemoryOfAQuery) {
  const cv::Mat photo = cv::imread(TheMap().inside.string());
  cv::Mat large;
  const double scale = std::sqrt(48e6 / static_cast<double>(photo.total()));
  cv::resize(photo, large, {}, scale, scale, cv::INTER_CUBIC);
  const std::string path = folder_ / "large.jpg";
  cv::imwrite(path, large);
  const RunResult result = RunWaystone({"localize", TheMap().map, path, "--json"});
  EXPECT_EQ(Json::parse(result.out)["verdict"], "localized") << result.out << result.err;
  EXPECT_LT(PeakMegabytes({"localize", TheMap().map, path}), 400);
}

TEST_F(CliTest, AMistypedCommandGetsASuggestion) {
  ExpectFailure(RunWaystone({"localise", "a.db", "b.jpg"}), 2, "did you mean 'localize'?");
  ExpectFailure(RunWaystone({"buid", "x"}), 2, "did you mean 'build'?");
  ExpectFailure(RunWaystone({"teleport"}), 2, "unknown command 'teleport'; see waystone --help");
}

// A file's name gets into the map, and from there to the terminal of whoever looks at it.
TEST_F(CliTest, NamesCannotDriveTheTerminal) {
  const fs::path images = folder_ / "red\x1b[31m";
  fs::copy(TheMap().images, images);
  const fs::path map = folder_ / "m.db";
  const RunResult build = RunWaystone({"build", images, "-o", map, "--every", "2"});
  ASSERT_EQ(build.code, 0) << build.err;
  const RunResult info = RunWaystone({"info", map});
  EXPECT_NE(info.out.find("red\\u001b[31m"), std::string::npos) << info.out;
  const RunResult json = RunWaystone({"info", map, "--json"});
  EXPECT_NE(json.out.find("red\\u001b[31m"), std::string::npos) << json.out;
  const RunResult missing = RunWaystone({"info", folder_ / "\x1b]0;title\x07.db"});
  EXPECT_NE(missing.err.find("\\u001b]0;title\\u0007.db"), std::string::npos) << missing.err;
  for (const std::string& text : {build.out, build.err, info.out, json.out, missing.err}) {
    EXPECT_EQ(text.find('\x1b'), std::string::npos) << text;
  }
}

TEST_F(CliTest, HelpEndsWithAnExample) {
  const RunResult all = RunWaystone({"--help"});
  EXPECT_EQ(all.code, 0);
  std::istringstream lines(all.out.substr(all.out.find("Subcommands:")));
  std::string line;
  int commands = 0;
  for (std::getline(lines, line); std::getline(lines, line) && !line.empty(); ++commands) {
    std::string command;
    std::istringstream(line) >> command;
    const RunResult help = RunWaystone({command, "--help"});
    EXPECT_EQ(help.code, 0);
    EXPECT_NE(help.out.find("\nExample: waystone " + command + " "), std::string::npos)
        << command << ": " << help.out;
  }
  EXPECT_GT(commands, 25) << all.out;
  EXPECT_TRUE(RunWaystone({"--version"}).out.starts_with("waystone "));
}

// The first thing that README.md has its readers do.
TEST(Demo, LocalizesItsPhotos) {
  const RunResult demo = RunWaystone({"demo"});
  EXPECT_EQ(demo.code, 0) << demo.out << demo.err;
  size_t at = 0;
  for (const char* verdict : {"localized", "not_in_map", "bad_image"}) {
    at = demo.out.find(std::string("\n{\"verdict\":\"") + verdict + "\",", at);
    ASSERT_NE(at, std::string::npos) << verdict << " is missing:\n" << demo.out;
  }
}

TEST_F(CliTest, InterruptedBuildLeavesNothing) {
  for (const int signal : {SIGINT, SIGTERM}) {
    ChildProcess build({WAYSTONE_PROGRAM, "build", TheMap().images, TheMap().images,
                        TheMap().images, "-o", folder_ / "m.db", "--quiet"},
                       false);
    AwaitHandlerOf(build, signal);
    std::this_thread::sleep_for(std::chrono::milliseconds(1000));
    build.Send(signal);
    EXPECT_EQ(build.Wait(), 130);
    EXPECT_EQ(FilesIn(folder_), 0u);
  }
}

TEST(Export, WritesWhatTheMapHas) {
  const RunResult graphml = RunWaystone({"export", TheMap().map});
  EXPECT_EQ(graphml.code, 0);
  EXPECT_NE(graphml.out.find("</graphml>"), std::string::npos);
  const RunResult poses = RunWaystone({"export", TheMap().map, "--format", "tum"});
  EXPECT_EQ(poses.code, 3);
  EXPECT_NE(poses.err.find("appearance layer"), std::string::npos) << poses.err;
  EXPECT_EQ(RunWaystone({"export", TheMap().map, "--format", "svg"}).code, 2);
}

TEST_F(CliTest, ExportToColmapIsWholeAndTheSameEachTime) {
  const auto export_to = [&](const std::string& name, const std::vector<std::string>& more) {
    std::vector<std::string> arguments = {"export", TheMap().map, "--format",
                                          "colmap", "-o",         folder_ / name};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return RunWaystone(arguments);
  };
  const std::vector<std::string> images = {"--images", TheMap().images};
  const RunResult done = export_to("a", images);
  ASSERT_EQ(done.code, 0) << done.err;
  EXPECT_NE(done.out.find("matched pairs"), std::string::npos) << done.out;
  EXPECT_EQ(FilesIn(folder_ / "a"), 2U);
  EXPECT_NE(ReadFile(folder_ / "a" / "image_list.txt").find(".jpg\n"), std::string::npos);
  ASSERT_EQ(export_to("b", images).code, 0);
  const std::string database = ReadFile(folder_ / "a" / "database.db");
  EXPECT_TRUE(database == ReadFile(folder_ / "b" / "database.db"));
  ExpectFailure(export_to("a", images), 3, "--force");
  EXPECT_TRUE(database == ReadFile(folder_ / "a" / "database.db"));
  EXPECT_EQ(export_to("a", {"--images", TheMap().images, "--force"}).code, 0);
  ExpectFailure(export_to("c", {}), 2, "--images");
  ExpectFailure(export_to("c", {"--images", TheMap().inside}), 3, "");
  EXPECT_FALSE(fs::exists(folder_ / "c"));
}

}  // namespace
}  // namespace waystone
