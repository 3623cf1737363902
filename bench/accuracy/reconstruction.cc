// SPDX-License-Identifier: Apache-2.0
#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <iostream>
#include <map>

#include "bench/accuracy/common.h"
#include "bench/accuracy/posed_queries.h"
#include "bench/accuracy/rgbd_truth.h"
#include "bench/accuracy/stopwatch.h"
#include "builder/poses/keyframe_reader.h"
#include "builder/sources/memory_source.h"
#include "cli/files/colmap_database.h"
#include "cli/files/colmap_images.h"
#include "cli/system/child_process.h"
#include "core/base/error.h"
#include "core/geometry/angle.h"
#include "core/geometry/rotation.h"
#include "core/image/decode.h"

namespace waystone::bench {
namespace {

namespace fs = std::filesystem;
using Eigen::Isometry3d;

constexpr int kMapFrames = 500;
constexpr int kQueryStep = 10;

// The half to be mapped as a video, with or without a calibration.
std::unique_ptr<Source> OpenHalf(const fs::path& folder, const RgbdTruth& truth,
                                 const std::optional<Camera>& camera) {
  MemorySequence sequence{.name = "kitchen", .camera = camera};
  for (int i = 0; i < kMapFrames; ++i) {
    const fs::path path = folder / truth.image(i);
    sequence.frames.emplace_back(FrameInfo{i, "frame " + std::to_string(i), {}},
                                 [path] { return DecodeGrey(ReadBytes(path)); });
  }
  return std::make_unique<MemorySource>(std::move(sequence));
}

// COLMAP's largest model.
struct Model {
  std::map<int, Isometry3d> model_from_camera;  // by frame
  Camera camera;
};

void RunMapper(const fs::path& folder) {
  fs::create_directories(folder / "models");
  const std::string command = "exec colmap mapper --database_path '" +
                              (folder / "database.db").string() + "' --image_path '" +
                              folder.string() + "' --output_path '" + (folder / "models").string() +
                              "' >'" + (folder / "log.txt").string() + "' 2>&1";
  ChildProcess mapper({"/bin/sh", "-c", command}, false);
  if (const int status = mapper.Wait(); status != 0) {
    throw MapError(ErrorCode::kNotAvailable, "colmap mapper ended with status " +
                                                 std::to_string(status) +
                                                 "; install Debian's package colmap");
  }
}

int FrameOfName(const std::string& name) { return std::stoi(name.substr(name.find(' ') + 1)); }

Model ReadLargestModel(const fs::path& folder, int& models) {
  Model largest;
  for (const auto& entry : fs::directory_iterator(folder / "models")) {
    ++models;
    const std::vector<FilePose> poses = ReadColmapImages(entry.path() / "images.bin");
    if (poses.size() <= largest.model_from_camera.size()) continue;
    largest = {{}, ReadCameraFile(entry.path() / "cameras.bin")};
    for (const FilePose& pose : poses) {
      largest.model_from_camera[FrameOfName(pose.name)] = pose.pose.world_from_camera;
    }
  }
  return largest;
}

// Turns the poses onto the true ones by the mean of all turns, then scales and shifts them by least
// squares over the positions. Positions alone hardly determine the rotation of a straight walk
// about its line.
void AlignToTruth(const RgbdTruth& truth, Model& model) {
  const auto count = static_cast<double>(model.model_from_camera.size());
  Eigen::Affine3d turns(Eigen::Matrix3d::Zero().eval());
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  Eigen::Vector3d true_middle = Eigen::Vector3d::Zero();
  for (const auto& [frame, pose] : model.model_from_camera) {
    const Isometry3d right = truth.world_from_colour(frame);
    turns.linear() += right.linear() * pose.linear().transpose();
    middle += pose.translation() / count;
    true_middle += right.translation() / count;
  }
  const Eigen::Matrix3d turn = turns.rotation();  // the nearest one
  double along = 0;
  double length = 0;
  for (const auto& [frame, pose] : model.model_from_camera) {
    const Eigen::Vector3d turned = turn * (pose.translation() - middle);
    along += turned.dot(truth.world_from_colour(frame).translation() - true_middle);
    length += turned.squaredNorm();
  }
  for (auto& [frame, pose] : model.model_from_camera) {
    pose.translation() =
        true_middle + along / length * (turn * (pose.translation() - middle)).eval();
    pose.linear() = turn * pose.linear();
  }
}

nlohmann::ordered_json AskSecondHalf(const fs::path& folder, const RgbdTruth& truth,
                                     const Model& model) {
  const auto pose_of = [&](int frame) -> std::optional<Isometry3d> {
    const auto found = model.model_from_camera.find(frame);
    return found == model.model_from_camera.end() ? std::nullopt : std::optional(found->second);
  };
  const BuildResult built =
      BuildPosed(OpenHalf(folder, truth, model.camera), PosesByFrame(pose_of));
  const auto index = MapIndex::Build(built.map);
  PoseErrors errors;
  for (int q = kMapFrames; q < truth.frames(); q += kQueryStep) {
    AskPose(*index, DecodeGrey(ReadBytes(folder / truth.image(q))), model.camera,
            truth.world_from_colour(q), "kitchen " + std::to_string(q), errors);
  }
  return SummarisePoses("kitchen", errors);
}

// The map's keyframes and verified matches, as `waystone export --format colmap` writes them.
size_t WriteProject(const MapIndex& index, std::unique_ptr<Source> images, const fs::path& folder) {
  const std::unique_ptr<Source> sources[] = {std::move(images)};
  ColmapProject project{&index.map(), {}, {}};
  project.features = ReadKeyframes(index.map(), sources, {.max_features = kReconstructionFeatures});
  project.matches = MatchKeyframes(index, project.features);
  WriteColmapDatabase(project, folder / "database.db", true);
  return project.matches.size();
}

// Of the model's keyframes, once it is aligned to the truth.
nlohmann::ordered_json PoseErrorsOf(const Model& model, const RgbdTruth& truth) {
  std::vector<double> metres;
  std::vector<double> degrees;
  for (const auto& [frame, pose] : model.model_from_camera) {
    const Isometry3d right = truth.world_from_colour(frame);
    metres.push_back((pose.translation() - right.translation()).norm());
    degrees.push_back(RotationAngle(pose.linear(), right.linear()) * kDegreesPerRadian);
  }
  return {{"registered", metres.size()},
          {"focal_px", model.camera.params.at(0)},
          {"position_median_cm", 100 * Quantile(metres, 0.5)},
          {"position_p90_cm", 100 * Quantile(metres, 0.9)},
          {"rotation_median_deg", Quantile(degrees, 0.5)},
          {"rotation_p90_deg", Quantile(degrees, 0.9)}};
}

}  // namespace

int RunReconstruction(const Args& args) {
  if (args.size() != 1) throw MapError(ErrorCode::kUsage, "reconstruction wants the kitchen");
  const fs::path folder = args[0];
  const RgbdTruth truth(folder);
  const auto index = MapIndex::Build(BuildPosed(OpenHalf(folder, truth, {}), {}).map);
  const ScratchFolder scratch;
  const fs::path& work = scratch.path();
  const Stopwatch exporting;
  const size_t pairs = WriteProject(*index, OpenHalf(folder, truth, {}), work);
  const double export_s = exporting.wall_s();
  const Stopwatch mapping;
  RunMapper(work);
  const double mapper_s = mapping.wall_s();
  int models = 0;
  Model model = ReadLargestModel(work, models);
  if (models == 0) throw MapError(ErrorCode::kNotAvailable, "colmap mapper made no model");
  AlignToTruth(truth, model);
  nlohmann::ordered_json json = {{"bench", "reconstruction"},
                                 {"keyframes", index->map().keyframes.size()},
                                 {"pairs", pairs},
                                 {"export_s", export_s},
                                 {"mapper_s", mapper_s},
                                 {"models", models}};
  json.update(PoseErrorsOf(model, truth));
  json["queries"] = AskSecondHalf(folder, truth, model);
  std::cout << json.dump() << std::endl;
  return 0;
}

}  // namespace waystone::bench
