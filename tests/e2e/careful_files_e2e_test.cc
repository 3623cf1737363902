// SPDX-License-Identifier: Apache-2.0
// What commands write costs nothing that they read, and no file of another kind.
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <future>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <thread>
#include <vector>

#include "cli/system/child_process.h"
#include "schema/file/map_lock.h"
#include "tests/e2e/shared_map.h"

namespace waystone {
namespace {

namespace fs = std::filesystem;

class CarefulFiles : public testing::Test {
 protected:
  CarefulFiles() { fs::copy_file(TheMap().map, map_); }
  ~CarefulFiles() override { fs::remove_all(folder_); }

  // Refused in one line, with `kept` as it was.
  static void ExpectKept(const std::vector<std::string>& arguments, const fs::path& kept,
                         const std::string& about, int code = 3) {
    const std::string before = ReadFile(kept);
    const RunResult result = RunWaystone(arguments);
    EXPECT_EQ(result.code, code) << result.err;
    EXPECT_EQ(std::ranges::count(result.err, '\n'), 1) << result.err;
    EXPECT_NE(result.err.find(about), std::string::npos) << result.err;
    EXPECT_TRUE(ReadFile(kept) == before) << kept;
  }

  fs::path Photo(const std::string& name) const {
    fs::path path = folder_ / name;
    fs::create_directories(path.parent_path());
    const cv::Mat image = cv::imread(TheMap().inside.string());
    cv::imwrite(path.string(), image(cv::Rect(0, 0, 640, 320)));
    return path;
  }

  const fs::path folder_ = FreshFolder();
  const fs::path map_ = folder_ / "room.db";
};

TEST_F(CarefulFiles, NoMapBecomesATextFile) {
  const fs::path other = folder_ / "other.db", link = folder_ / "link";
  fs::copy_file(map_, other);
  fs::create_symlink("room.db", link);
  ExpectKept({"name", map_, "--export", map_, "--force"}, map_, "is the map");
  ExpectKept({"name", map_, "--export", link, "--force"}, map_, "is the map");
  ExpectKept({"name", map_, "--export", other, "--force"}, other, "is a map");
  ExpectKept({"export", map_, "-o", other, "--force"}, other, "is a map");
  EXPECT_EQ(RunWaystone({"name", map_, "--export", folder_ / "names.json"}).code, 0);
  EXPECT_EQ(RunWaystone({"name", map_, "--export", folder_ / "names.json", "--force"}).code, 0);
}

TEST_F(CarefulFiles, JoinedMapsAreNotReplaced) {
  const fs::path other = folder_ / "other.db", soft = folder_ / "soft.db",
                 hard = folder_ / "hard.db";
  fs::copy_file(map_, other);
  fs::create_symlink("room.db", soft);
  fs::create_hard_link(other, hard);
  for (const fs::path& output : {map_, other, soft, hard}) {
    ExpectKept({"merge", map_, other, "-o", output, "--force"}, output, "maps that are joined");
  }
}

TEST_F(CarefulFiles, APathThatCantBeFollowedIsNamed) {
  const fs::path loop = folder_ / "loop";
  fs::create_symlink("loop", loop);
  ExpectKept({"eval", map_, loop}, map_, "loop' can't be used: Too many levels of symbolic links");
  ExpectKept({"unwrap", loop, "-o", folder_ / "out"}, map_, "loop");
}

TEST_F(CarefulFiles, MoreThreadsThanCoresAreNoMatter) {
  fs::create_directory(folder_ / "photos");
  fs::copy_file(TheMap().inside, folder_ / "photos" / TheMap().inside.filename());
  const RunResult built = RunWaystone(
      {"build", folder_ / "photos", "-o", folder_ / "photos.db", "--threads", "64", "--quiet"});
  EXPECT_EQ(built.code, 0);
  EXPECT_EQ(built.err, "");
}

TEST_F(CarefulFiles, UnwrappingReplacesNoImage) {
  const fs::path first = Photo("d/000.png"), second = Photo("d/000_panorama.png");
  ExpectKept({"unwrap", first, second, "-o", folder_ / "d"}, second, "an image that is unwrapped");
  EXPECT_FALSE(fs::exists(folder_ / "d" / "000_used.png")) << "written before the refusal";
}

TEST_F(CarefulFiles, PicturesOfDirectionsReplaceNothing) {
  const fs::path a = Photo("a/y.png"), b = Photo("b/y.png"), lines = Photo("a/y_lines.png");
  WriteFile(folder_ / "camera.yaml",
            "camera_model: PINHOLE\nimage_width: 640\nimage_height: 320\nfx: 580\nfy: 580\n"
            "cx: 320\ncy: 160\n");
  const std::string camera = folder_ / "camera.yaml";
  ExpectKept({"directions", a, b, "--camera", camera, "--draw", folder_ / "out"}, a,
             "would both be y_lines.png", 2);
  EXPECT_FALSE(fs::exists(folder_ / "out"));
  ExpectKept({"directions", a, lines, "--camera", camera, "--draw", folder_ / "a"}, lines,
             "is one of the photos");
}

TEST_F(CarefulFiles, DirectionsAnswersTheOtherPhotos) {
  const fs::path a = Photo("a.png"), b = Photo("b.png");
  WriteFile(folder_ / "camera.yaml",
            "camera_model: PINHOLE\nimage_width: 640\nimage_height: 320\nfx: 580\nfy: 580\n"
            "cx: 320\ncy: 160\n");
  const RunResult result = RunWaystone({"directions", a, folder_ / "nope.png", b, "--json"});
  EXPECT_EQ(result.code, 3);
  EXPECT_EQ(std::ranges::count(result.out, '\n'), 2) << result.out;
  EXPECT_EQ(std::ranges::count(result.err, '\n'), 1) << result.err;
  EXPECT_NE(result.err.find("nope.png' does not exist"), std::string::npos) << result.err;
  const RunResult uncalibrated =
      RunWaystone({"directions", a, b, "--camera", folder_ / "none.yaml"});
  EXPECT_EQ(uncalibrated.code, 3);
  EXPECT_EQ(std::ranges::count(uncalibrated.err, '\n'), 1) << uncalibrated.err;
}

TEST_F(CarefulFiles, APlotReplacesNoTrajectory) {
  const fs::path estimate = folder_ / "t.txt", truth = folder_ / "g.txt";
  std::string poses;
  for (int i = 0; i < 5; ++i) {
    poses +=
        std::to_string(i) + " " + std::to_string(i * i) + " " + std::to_string(i) + " 0 0 0 0 1\n";
  }
  WriteFile(estimate, poses);
  WriteFile(truth, poses);
  for (const fs::path& plot : {estimate, truth}) {
    ExpectKept({"eval", "trajectory", estimate, truth, "--plot", plot}, plot,
               "a trajectory that is evaluated");
  }
  const fs::path plot = folder_ / "p.svg";
  std::vector<std::string> plotted{"eval", "trajectory", estimate, truth, "--plot", plot};
  EXPECT_EQ(RunWaystone(plotted).code, 0);
  ExpectKept(plotted, plot, "--force");
  plotted.emplace_back("--force");
  EXPECT_EQ(RunWaystone(plotted).code, 0);
}

TEST_F(CarefulFiles, ThePreviousVersionReplacesMapsAlone) {
  const fs::path previous = folder_ / "room.db.previous";
  WriteFile(previous, "notes");
  ExpectKept({"remove", map_, "--keyframes", "1", "--keep"}, previous, "only maps are overwritten");
  EXPECT_TRUE(ReadFile(map_) == ReadFile(TheMap().map));
  fs::remove(previous);
  ASSERT_EQ(RunWaystone({"remove", map_, "--keyframes", "1", "--keep"}).code, 0);
  EXPECT_EQ(RunWaystone({"remove", map_, "--keyframes", "2", "--keep"}).code, 0);
}

TEST_F(CarefulFiles, ChangesAtTheSameTimeAreAllKept) {
  std::vector<std::future<RunResult>> runs;
  for (int i = 1; i <= 6; ++i) {
    runs.push_back(std::async(std::launch::async, [this, i] {
      return RunWaystone({"name", map_, "Place " + std::to_string(i), "--keyframes", "1"});
    }));
  }
  for (std::future<RunResult>& run : runs) {
    const RunResult result = run.get();
    EXPECT_EQ(result.code, 0) << result.err;
  }
  const RunResult listed = RunWaystone({"name", map_});
  EXPECT_NE(listed.out.find("6 named places"), std::string::npos) << listed.out;
}

TEST_F(CarefulFiles, ReportsAreRefusedBeforeTheWork) {
  const auto refuse = [&](const fs::path& report, const std::string& about, int code) {
    const fs::path map = folder_ / "new.db";
    ExpectKept({"build", TheMap().images, "-o", map, "--quiet", "--report", report}, map_, about,
               code);
    EXPECT_FALSE(fs::exists(map)) << "built before the refusal";
  };
  refuse(folder_ / "new.db", "-o and --report are both", 2);
  refuse(map_, "room.db exists and is not a folder", 3);
  refuse(TheMap().images, "is the folder of a source", 3);
  refuse("/proc/report", "can't create /proc/report", 3);
  fs::create_directories(folder_ / "site" / "images");
  refuse(folder_ / "site", "images exists and is not of a Waystone report", 3);
}

// The lock holds each up where nothing but memory has been written to.
TEST_F(CarefulFiles, AnInterruptedChangeLeavesTheMap) {
  const std::string before = ReadFile(map_);
  const MapLock lock(map_);
  for (const std::vector<std::string>& arguments : std::vector<std::vector<std::string>>{
           {"add", map_, TheMap().images},
           {"merge", TheMap().map, TheMap().map, "-o", map_, "--force"},
           {"remove", map_, "--keyframes", "1"},
           {"prune", map_},
           {"build", TheMap().images, "-o", map_, "--force"}}) {
    for (const int signal : {SIGINT, SIGTERM}) {
      std::vector<std::string> command = arguments;
      command.insert(command.begin(), WAYSTONE_PROGRAM);
      ChildProcess child(command, false);
      AwaitHandlerOf(child, signal);
      std::this_thread::sleep_for(std::chrono::milliseconds(300));
      child.Send(signal);
      EXPECT_EQ(child.Wait(), 130) << arguments.front();
    }
  }
  EXPECT_TRUE(ReadFile(map_) == before);
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_), fs::directory_iterator()), 1);
}

TEST_F(CarefulFiles, AMapThatIsBeingChangedIsLeftAloneAndRead) {
  const MapLock lock(map_);
  ExpectKept({"name", map_, "Door", "--keyframes", "1"}, map_, "is being changed by another");
  EXPECT_EQ(RunWaystone({"name", map_}).code, 0);
  EXPECT_EQ(RunWaystone({"localize", map_, TheMap().inside}).code, 0);
}

}  // namespace
}  // namespace waystone
