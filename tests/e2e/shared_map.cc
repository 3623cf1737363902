// SPDX-License-Identifier: Apache-2.0
#include "tests/e2e/shared_map.h"

#include <gtest/gtest.h>
#include <sys/wait.h>

#include <chrono>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <numbers>
#include <opencv2/imgcodecs.hpp>
#include <thread>

#include "cli/system/child_process.h"
#include "world/render.h"
#include "world/rig.h"
#include "world/walk.h"
#include "world/world.h"

namespace waystone {
namespace {

namespace fs = std::filesystem;

constexpr int kPhotoFrame = 20;  // the photo is taken just after it

const char* const kRoom = R"(
################
#..............#
#..............#
#..............#
#..............#
#..............#
#..............#
################
)";

// Along the room, looking at its long northern wall.
Walk WalkAlong(const FloorPlan& plan) {
  WalkOptions options;
  options.step_m = 0.1;
  options.gaze_rad = 0.3;
  options.gaze_offset_rad = std::numbers::pi / 2;
  return WalkThrough(plan, {{2.5, 5.5}, {13.0, 5.0}}, options);
}

void SaveFrame(const World& world, const Eigen::Isometry3d& pose, const fs::path& path) {
  const Camera camera = PinholeCamera(640, 480, 1.1);
  RenderOptions options;
  options.noise_sigma = 2.0;
  options.noise_seed = std::hash<std::string>()(path.filename().string());
  cv::imwrite(path.string(), Render(world, camera, pose, options).grey);
}

void RenderPictures(const SharedMap& shared) {
  const FloorPlan plan = ParseFloorPlan(kRoom);
  const World world(plan);
  const Walk walk = WalkAlong(plan);
  for (size_t i = 0; i < walk.frames.size(); ++i) {
    SaveFrame(world, walk.frames[i].world_from_camera,
              shared.images / (std::to_string(i) + ".jpg"));
  }
  Eigen::Isometry3d pose = walk.frames.at(kPhotoFrame).world_from_camera;
  pose.translation() =
      (pose.translation() + walk.frames.at(kPhotoFrame + 1).world_from_camera.translation()) / 2;
  SaveFrame(world, pose, shared.inside);
  WorldOptions other;
  other.seed = 99;
  const Walk tour = DemoWalk(OtherPlan());
  SaveFrame(World(OtherPlan(), other), tour.frames.at(tour.frames.size() / 3).world_from_camera,
            shared.elsewhere);
}

SharedMap MakeSharedMap() {
  std::string name = (fs::temp_directory_path() / "waystone-e2e-XXXXXX").string();
  if (mkdtemp(name.data()) == nullptr) throw std::runtime_error("no temporary folder");
  SharedMap shared;
  shared.folder = name;
  shared.images = shared.folder / "images";
  shared.map = shared.folder / "room.db";
  shared.inside = shared.folder / "inside.jpg";
  shared.elsewhere = shared.folder / "elsewhere.jpg";
  fs::create_directories(shared.images);
  RenderPictures(shared);
  shared.build =
      RunWaystone({"build", shared.images, "-o", shared.map, "--threads", "2", "--json"});
  return shared;
}

std::string Quoted(const std::string& text) {
  std::string out = "'";
  for (const char c : text) out += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return out + "'";
}

// Removes the shared folder when all tests are over.
class Cleaner : public testing::Environment {
 public:
  void TearDown() override {
    if (!folder_.empty()) fs::remove_all(folder_);
  }
  static inline fs::path folder_;
};
const testing::Environment* const kCleaner = testing::AddGlobalTestEnvironment(new Cleaner);

}  // namespace

void RenderPosters(const std::string& wall, const fs::path& folder, int first, int last) {
  std::string room = kRoom;
  const FloorPlan plan = ParseFloorPlan(room.replace(room.find('#'), wall.size(), wall));
  const World world(plan, {.poster_probability = 0});
  const Walk walk = WalkAlong(plan);
  fs::create_directories(folder);
  for (int i = first; i <= last; ++i) {
    SaveFrame(world, walk.frames.at(i).world_from_camera, folder / (std::to_string(i) + ".jpg"));
  }
}

const SharedMap& TheMap() {
  static const SharedMap shared = MakeSharedMap();
  Cleaner::folder_ = shared.folder;
  return shared;
}

RunResult RunWaystone(const std::vector<std::string>& arguments, const std::string& limits) {
  const fs::path folder = FreshFolder();
  std::string command = limits + " " + Quoted(WAYSTONE_PROGRAM);
  for (const std::string& argument : arguments) command += " " + Quoted(argument);
  command += " >" + Quoted(folder / "out") + " 2>" + Quoted(folder / "err") + " </dev/null";
  const int status = std::system(command.c_str());  // NOLINT(cert-env33-c): all of it is quoted
  RunResult result;
  result.code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  result.out = ReadFile(folder / "out");
  result.err = ReadFile(folder / "err");
  fs::remove_all(folder);
  return result;
}

void AwaitHandlerOf(const ChildProcess& program, int signal) {
  const std::string field = "SigCgt:";
  const std::string status = "/proc/" + std::to_string(program.pid()) + "/status";
  for (int tries = 0; tries < 6000; ++tries) {
    const std::string text = ReadFile(status);
    const size_t at = text.find(field);
    ASSERT_NE(at, std::string::npos) << "the program has ended";
    const uint64_t caught = std::strtoull(text.c_str() + at + field.size(), nullptr, 16);
    if ((caught >> (signal - 1) & 1) != 0) return;
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  FAIL() << "the program takes no signal " << signal;
}

std::string ReadFile(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

void WriteFile(const fs::path& path, const std::string& bytes) {
  std::ofstream(path, std::ios::binary) << bytes;
}

std::string WithJpegSize(std::string jpeg, int width, int height) {
  // The start of frame: FF C0, length (2), precision (1), height (2), width (2).
  const size_t at = jpeg.find("\xFF\xC0");
  EXPECT_NE(at, std::string::npos);
  jpeg[at + 5] = static_cast<char>(height >> 8);
  jpeg[at + 6] = static_cast<char>(height & 255);
  jpeg[at + 7] = static_cast<char>(width >> 8);
  jpeg[at + 8] = static_cast<char>(width & 255);
  return jpeg;
}

fs::path FreshFolder() {
  std::string name = (fs::temp_directory_path() / "waystone-test-XXXXXX").string();
  EXPECT_NE(mkdtemp(name.data()), nullptr);
  return name;
}

}  // namespace waystone
