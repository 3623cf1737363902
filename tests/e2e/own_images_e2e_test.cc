// SPDX-License-Identifier: Apache-2.0
// Every kind of map finds the images that it was made of, each at its own place.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numbers>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <sstream>

#include "api/json.h"
#include "cli/system/child_process.h"
#include "tests/e2e/shared_map.h"
#include "world/render.h"
#include "world/rig.h"
#include "world/walk.h"
#include "world/world.h"

namespace waystone {
namespace {

namespace fs = std::filesystem;

constexpr double kOwnShare = 0.99;
constexpr int kFrames = 40;
constexpr double kStep_m = 0.35;
constexpr int kPanoramaWidth_px = 512;

std::vector<Json> Ask(const fs::path& map, const std::vector<fs::path>& images) {
  std::vector<std::string> arguments = {"localize", map, "--json"};
  arguments.insert(arguments.end(), images.begin(), images.end());
  const RunResult run = RunWaystone(arguments);
  EXPECT_EQ(run.code, 0) << run.err;
  std::istringstream lines(run.out);
  std::vector<Json> answers;
  for (std::string line; std::getline(lines, line);) answers.push_back(Json::parse(line));
  EXPECT_EQ(answers.size(), images.size());
  return answers;
}

int NumberOf(const fs::path& image) { return std::stoi(image.stem().string()); }

// The share of the images that are localized at most `apart` images from themselves.
double OwnShare(const fs::path& map, const std::vector<fs::path>& images, int apart) {
  int found = 0;
  for (const Json& answer : Ask(map, images)) {
    const fs::path asked = answer["image"].get<std::string>();
    const Json& place = answer["place"];
    const bool right = !place.is_null() && std::abs(NumberOf(place["image"].get<std::string>()) -
                                                    NumberOf(asked)) <= apart;
    EXPECT_TRUE(right) << answer.dump();
    found += right;
  }
  return static_cast<double>(found) / static_cast<double>(images.size());
}

std::string Number(int i) { return (i < 10 ? "00" : "0") + std::to_string(i); }

// A walk through the demo building.
class OwnImages : public testing::Test {
 protected:
  ~OwnImages() override { fs::remove_all(folder_); }

  static const World& Building() {
    static const World world = [] {
      WorldOptions options;
      options.texel_m = 0.02;
      return World(DemoPlan(), options);
    }();
    return world;
  }

  // After so many steps of the walk through the corridor and back beside the way there.
  static Eigen::Isometry3d PoseAt(double step) {
    const bool back = step >= kFrames / 2.0;
    const double along = kStep_m * (back ? kFrames - step : step);
    return WorldFromCamera({2.0 + along, back ? 7.4 : 8.1, 1.5},
                           0.03 * step + (back ? std::numbers::pi : 0));
  }

  // Turned to the left by `turn_rad`.
  static cv::Mat PanoramaAt(double step, double turn_rad = 0) {
    const Renderer renderer(PanoramaCamera(kPanoramaWidth_px));
    RenderOptions noisy;
    noisy.noise_sigma = 2;
    noisy.noise_seed = static_cast<uint64_t>(100 * step) + 1;
    Eigen::Isometry3d pose = PoseAt(step);
    pose.rotate(Eigen::AngleAxisd(-turn_rad, Eigen::Vector3d::UnitY()));
    return renderer.Render(Building(), pose, noisy).grey;
  }

  std::vector<fs::path> WritePanoramas(const std::string& name) const {
    fs::create_directory(folder_ / name);
    std::vector<fs::path> images;
    for (int i = 0; i < kFrames; ++i) {
      images.push_back(folder_ / name / (Number(i) + ".png"));
      cv::imwrite(images.back().string(), PanoramaAt(i));
    }
    return images;
  }

  // Builds a map and returns what it says of its own images: the share that it found.
  double Build(const fs::path& map, std::vector<std::string> arguments,
               const std::vector<std::string>& path) const {
    arguments.insert(arguments.begin(), "build");
    arguments.insert(arguments.end(), {"-o", map, "--json"});
    const RunResult run = RunWaystone(arguments);
    EXPECT_EQ(run.code, 0) << run.err;
    if (run.code != 0) return 0;
    Json own = Json::parse(run.out);
    for (const std::string& key : path) own = Json(own[key]);
    EXPECT_GT(own["asked"], 0);
    return own["found"].get<double>() / own["asked"].get<double>();
  }

  const fs::path folder_ = FreshFolder();
};

TEST_F(OwnImages, OfPlanes) {
  const Json own = Json::parse(TheMap().build.out)["own_images"];
  EXPECT_GT(own["asked"], 5);
  EXPECT_EQ(own["found"], own["asked"]);
  std::vector<fs::path> images;
  for (const auto& entry : fs::directory_iterator(TheMap().images)) images.push_back(entry.path());
  // Keyframes are up to 30 images apart.
  EXPECT_GE(OwnShare(TheMap().map, images, 15), kOwnShare);
}

TEST_F(OwnImages, OfPanoramas) {
  const std::vector<fs::path> images = WritePanoramas("walk");
  const fs::path map = folder_ / "walk.db";
  EXPECT_GE(Build(map, {folder_ / "walk"}, {"appearance", "report", "own_images"}), kOwnShare);
  EXPECT_GE(OwnShare(map, images, 0), kOwnShare);
}

// By appearance alone, without features to verify.
TEST_F(OwnImages, OfPanoramasWithoutFeatures) {
  const std::vector<fs::path> images = WritePanoramas("walk");
  const fs::path map = folder_ / "walk.db";
  EXPECT_GE(Build(map, {folder_ / "walk", "--node-features", "0"},
                  {"appearance", "report", "own_images"}),
            kOwnShare);
  EXPECT_GE(OwnShare(map, images, 0), kOwnShare);
}

// A rig is asked as the panorama that its faces make.
TEST_F(OwnImages, OfRigs) {
  for (const RigFace& face : SixFaceRig(kPanoramaWidth_px / 4)) {
    const fs::path images = folder_ / "rig" / face.name;
    fs::create_directories(images);
    const Renderer renderer(face.camera);
    for (int i = 0; i < kFrames; ++i) {
      Eigen::Isometry3d pose = PoseAt(i);
      pose.linear() = pose.linear() * face.rig_from_camera;
      cv::imwrite((images / (Number(i) + ".png")).string(), renderer.Render(Building(), pose).grey);
    }
  }
  const fs::path map = folder_ / "rig.db";
  EXPECT_GE(Build(map, {folder_ / "rig", "--layers", "appearance"},
                  {"appearance", "report", "own_images"}),
            kOwnShare);
  EXPECT_GE(OwnShare(map, WritePanoramas("asked"), 0), kOwnShare);
}

// What a camera below a mirror sees of a panorama: elevation goes with the radius.
class MirrorImages : public OwnImages {
 protected:
  static constexpr int kSide_px = 480;
  static constexpr double kInner_px = 50;
  static constexpr double kOuter_px = 230;
  static constexpr double kTop_rad = 20 * std::numbers::pi / 180;
  static constexpr double kBottom_rad = -52 * std::numbers::pi / 180;

  static cv::Mat MirrorImage(const cv::Mat& panorama, int side_px) {
    const double scale = static_cast<double>(side_px) / kSide_px;
    cv::Mat xs(side_px, side_px, CV_32FC1);
    cv::Mat ys(side_px, side_px, CV_32FC1);
    for (int y = 0; y < side_px; ++y) {
      for (int x = 0; x < side_px; ++x) {
        const double right = x - scale * kSide_px / 2;
        const double up = scale * kSide_px / 2 - y;
        const double radius = std::hypot(right, up) / scale;
        const double share = (radius - kInner_px) / (kOuter_px - kInner_px);
        const double elevation = kBottom_rad + share * (kTop_rad - kBottom_rad);
        const double azimuth = std::atan2(right, up) / (2 * std::numbers::pi) + 0.5;
        const bool seen = share >= 0 && share <= 1;
        xs.at<float>(y, x) = seen ? static_cast<float>(azimuth * panorama.cols - 0.5) : -100;
        ys.at<float>(y, x) =
            static_cast<float>((0.5 - elevation / std::numbers::pi) * panorama.rows - 0.5);
      }
    }
    cv::Mat image;
    cv::remap(panorama, image, xs, ys, cv::INTER_LINEAR, cv::BORDER_CONSTANT, cv::Scalar(12));
    return image;
  }

  fs::path Write(const fs::path& name, double step, int side_px = kSide_px) const {
    cv::imwrite((folder_ / name).string(), MirrorImage(PanoramaAt(step), side_px));
    return folder_ / name;
  }

  std::vector<fs::path> WriteWalk() const {
    fs::create_directory(folder_ / "walk");
    std::vector<fs::path> images;
    for (int i = 0; i < kFrames; ++i) images.push_back(Write("walk/" + Number(i) + ".png", i));
    return images;
  }

  double BuildMirror(const fs::path& map) const {
    return Build(map,
                 {folder_ / "walk", "--layers", "appearance", "--mirror", "240", "240", "50", "230",
                  "--mirror-band", "20", "-52"},
                 {"appearance", "report", "own_images"});
  }
};

TEST_F(MirrorImages, AreFoundAndAskedForLikeTheMapsOwn) {
  const std::vector<fs::path> images = WriteWalk();
  const fs::path map = folder_ / "walk.db";
  EXPECT_GE(BuildMirror(map), kOwnShare);
  EXPECT_GE(OwnShare(map, images, 0), kOwnShare);
  // The same camera at half the size, and a whole panorama of the same place.
  cv::imwrite((folder_ / "whole.png").string(), PanoramaAt(7));
  for (const fs::path& asked : {Write("half.png", 7, kSide_px / 2), folder_ / "whole.png"}) {
    const Json answer = Ask(map, {asked}).front();
    ASSERT_EQ(answer["verdict"], "localized") << answer;
    EXPECT_EQ(NumberOf(answer["place"]["image"].get<std::string>()), 7) << answer;
  }
  // Turned at the place.
  constexpr double kTurn_rad = 0.7;
  const fs::path turned = folder_ / "turned.png";
  cv::imwrite(turned.string(), MirrorImage(PanoramaAt(7, kTurn_rad), kSide_px));
  const std::vector<Json> both = Ask(map, {images[7], turned});
  ASSERT_EQ(both[1]["verdict"], "localized") << both[1];
  const auto heading = [&](int i) { return both[i]["place"]["heading"]["rad"].get<double>(); };
  EXPECT_NEAR(std::remainder(heading(1) - heading(0), 2 * std::numbers::pi), kTurn_rad, 0.03);

  ChildProcess server({WAYSTONE_PROGRAM, "serve", map, "--port", "0"}, true);
  const std::string line = server.ReadLine();
  const RunResult served = RunWaystone(
      {"localize", "walk", images[3], "--json", "--server", line.substr(line.find("http://"))});
  const Json answer = Json::parse(served.out);
  EXPECT_EQ(answer["verdict"], "localized") << answer;
  EXPECT_EQ(answer["place"], Ask(map, {images[3]}).front()["place"]);
}

TEST_F(MirrorImages, AnImageThatShowsLessIsRefused) {
  WriteWalk();
  const fs::path map = folder_ / "walk.db";
  BuildMirror(map);
  const cv::Mat panorama = PanoramaAt(3);
  // A strip of elevations from 10 degrees up to 10 down.
  const int rows = panorama.rows / 9;
  cv::imwrite((folder_ / "photo.png").string(),
              panorama(cv::Rect(0, (panorama.rows - rows) / 2, panorama.cols, rows)));
  const Json answer = Ask(map, {folder_ / "photo.png"}).front();
  EXPECT_NE(answer["verdict"], "localized") << answer;
  EXPECT_FALSE(answer["message"].get<std::string>().empty());
}

}  // namespace
}  // namespace waystone
