// SPDX-License-Identifier: Apache-2.0
#include "bench/accuracy/oriented_set.h"

#include <memory>
#include <sstream>

#include "bench/accuracy/common.h"
#include "builder/sources/rig_source.h"
#include "builder/sources/source.h"
#include "core/base/error.h"
#include "world/render.h"
#include "world/rig.h"
#include "world/walk.h"

namespace waystone::bench {
namespace {

namespace fs = std::filesystem;

void CheckCells(const std::vector<std::string>& cells, size_t least, const fs::path& path) {
  if (cells.size() >= least) return;
  throw MapError(ErrorCode::kFileUnreadable, path.string() + ": a line has " +
                                                 std::to_string(cells.size()) + " cells, not " +
                                                 std::to_string(least));
}

std::function<std::vector<cv::Mat>(int)> Reader(RigSequence sequence) {
  const auto shared = std::make_shared<const RigSequence>(std::move(sequence));
  return [shared](int i) { return ReadMoment(*shared, shared->moments.at(i)); };
}

// image,split,v1x..v3z,o1x..o3z: o are the orthogonalised directions, y up.
OrientedSet OpenVanishingPoints(const fs::path& folder) {
  constexpr size_t kFirst = 11;
  OrientedSet set;
  set.name = fs::canonical(folder).filename();
  RigSequence sequence;
  sequence.layout = "images";
  sequence.rig = ReadRigFile(folder / "camera.yaml");
  for (const auto& cells : ReadCsv(folder / "vp_gt.csv")) {
    CheckCells(cells, kFirst + 9, folder / "vp_gt.csv");
    Eigen::Matrix3d axes;
    for (int axis = 0; axis < 3; ++axis) {
      for (int i = 0; i < 3; ++i) axes(i, axis) = std::stod(cells[kFirst + 3 * axis + i]);
    }
    axes.row(1) *= -1;
    if (axes.determinant() < 0) axes.col(2) *= -1;
    set.names.push_back(cells[0]);
    set.rig_from_axes.push_back(axes);
    sequence.moments.push_back(
        {.source = cells[0], .time_s = {}, .images = {folder / "images" / (cells[0] + ".jpg")}});
  }
  set.rig = sequence.rig;
  set.images = Reader(std::move(sequence));
  return set;
}

// id,x,y,z,qx,qy,qz,qw,visible places apart by spaces: world_from_rig.
OrientedSet OpenPlaces(const fs::path& folder) {
  constexpr size_t kCells = 8;
  OrientedSet set;
  set.name = fs::canonical(folder).filename();
  RigSequence sequence = OpenRigSequence(folder / "rig");
  for (const auto& cells : ReadCsv(folder / "poses.csv")) {
    CheckCells(cells, kCells, folder / "poses.csv");
    const auto number = [&](size_t i) { return std::stod(cells[i]); };
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    pose.linear() = Eigen::Quaterniond(number(7), number(4), number(5), number(6))
                        .normalized()
                        .toRotationMatrix();
    pose.translation() = Eigen::Vector3d(number(1), number(2), number(3));
    set.names.push_back(cells[0]);
    set.world_from_rig.push_back(pose);
    set.rig_from_axes.emplace_back(pose.linear().transpose());
    std::istringstream places(cells.size() > kCells ? cells[kCells] : "");
    std::set<int>& visible = set.visible.emplace_back();
    for (int place = 0; places >> place;) visible.insert(place);
  }
  if (sequence.moments.size() != set.names.size()) {
    throw MapError(ErrorCode::kBadSource,
                   folder.string() + ": rig/ has " + std::to_string(sequence.moments.size()) +
                       " places, poses.csv " + std::to_string(set.names.size()));
  }
  set.rig = sequence.rig;
  set.images = Reader(std::move(sequence));
  return set;
}

// What every rendering needs.
struct Stage {
  World world{DemoPlan(), {}};
  std::vector<Renderer> renderers;
};

}  // namespace

OrientedSet OpenOrientedSet(const fs::path& folder) {
  if (fs::exists(folder / "vp_gt.csv")) return OpenVanishingPoints(folder);
  if (fs::exists(folder / "poses.csv") && fs::exists(folder / "rig")) return OpenPlaces(folder);
  throw MapError(ErrorCode::kUsage,
                 folder.string() + " has neither vp_gt.csv nor poses.csv and rig/");
}

OrientedSet RenderedSet(bool rig, int frames) {
  constexpr int kFaceWidth = 320;  // px
  OrientedSet set;
  set.name = rig ? "world, six faces" : "world, pinhole";
  set.rig = rig ? CubeRig(kFaceWidth) : RigOfOne(PinholeCamera(640, 480, 1.1));
  const auto stage = std::make_shared<Stage>();
  for (const RigCamera& camera : set.rig.cameras) stage->renderers.emplace_back(camera.camera);
  const Walk walk = DemoWalk(stage->world.plan());
  const int step = std::max<int>(1, static_cast<int>(walk.frames.size()) / frames);
  for (size_t i = 0; i < walk.frames.size(); i += step) {
    set.names.push_back(std::to_string(i));
    set.world_from_rig.push_back(walk.frames[i].world_from_camera);
    set.rig_from_axes.emplace_back(walk.frames[i].world_from_camera.linear().transpose());
  }
  set.images = [stage, cameras = set.rig.cameras, poses = set.world_from_rig](int i) {
    std::vector<cv::Mat> images;
    for (size_t c = 0; c < cameras.size(); ++c) {
      RenderOptions options;
      options.lens_blur_px = 0.6;
      options.noise_sigma = 4;
      options.noise_seed = static_cast<uint64_t>(i) * cameras.size() + c;
      images.push_back(stage->renderers[c]
                           .Render(stage->world, poses[i] * cameras[c].rig_from_camera, options)
                           .grey);
    }
    return images;
  };
  return set;
}

}  // namespace waystone::bench
