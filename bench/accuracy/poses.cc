// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <functional>
#include <iostream>
#include <map>

#include "bench/accuracy/common.h"
#include "bench/accuracy/rgbd_truth.h"
#include "bench/accuracy/world_source.h"
#include "builder/sources/memory_source.h"
#include "core/base/error.h"
#include "core/geometry/angle.h"
#include "core/geometry/rotation.h"
#include "core/image/decode.h"
#include "world/rig.h"

namespace waystone::bench {
namespace {

using Eigen::Isometry3d;
using Matrix6d = Eigen::Matrix<double, 6, 6>;

// The errors of the poses of one set of queries.
struct PoseErrors {
  int asked = 0;
  int localized = 0;
  std::vector<double> metres;
  std::vector<double> degrees;
  std::vector<double> nees;  // normalised error squared over its expectation, 6
  std::vector<double> ms;
  std::vector<double> inliers;
};

double ComputeNees(const QueryPose& pose, const Isometry3d& truth) {
  Eigen::Matrix<double, 6, 1> error;
  error.head<3>() = truth.translation() - pose.frame_from_camera.translation();
  const Eigen::AngleAxisd turn(truth.linear() * pose.frame_from_camera.linear().transpose());
  error.tail<3>() = turn.angle() * turn.axis();
  return error.dot(pose.covariance.ldlt().solve(error)) / 6;
}

void Ask(const MapIndex& index, const cv::Mat& grey, const Camera& camera, const Isometry3d& truth,
         const std::string& name, PoseErrors& errors) {
  LocalizeOptions options;
  options.camera = camera;
  const Answer answer = LocalizeImage(index, grey, options);
  ++errors.asked;
  errors.localized += answer.verdict == Verdict::kLocalized;
  if (!answer.pose) {
    std::printf("%s: %s %s\n", name.c_str(), NameOf(answer.verdict), answer.pose_reason.c_str());
    return;
  }
  const Isometry3d& pose = answer.pose->frame_from_camera;
  errors.metres.push_back((pose.translation() - truth.translation()).norm());
  errors.degrees.push_back(RotationAngle(pose.linear(), truth.linear()) * kDegreesPerRadian);
  errors.nees.push_back(ComputeNees(*answer.pose, truth));
  errors.ms.push_back(answer.timing.pose_ms);
  errors.inliers.push_back(answer.pose->inliers);
  std::printf("%s: %.4f m %.3f deg, nees/6 %.2f, %d inliers, %.2f ms\n", name.c_str(),
              errors.metres.back(), errors.degrees.back(), errors.nees.back(), answer.pose->inliers,
              errors.ms.back());
}

nlohmann::ordered_json Summarise(const std::string& name, const PoseErrors& errors) {
  const auto within = [&](double metres, double degrees) {
    int count = 0;
    for (size_t i = 0; i < errors.metres.size(); ++i) {
      count += errors.metres[i] <= metres && errors.degrees[i] <= degrees;
    }
    return count;
  };
  double mean_nees = 0;
  for (const double nees : errors.nees) mean_nees += nees / static_cast<double>(errors.nees.size());
  return {{"set", name},
          {"asked", errors.asked},
          {"localized", errors.localized},
          {"posed", errors.metres.size()},
          {"median_cm", 100 * Quantile(errors.metres, 0.5)},
          {"median_deg", Quantile(errors.degrees, 0.5)},
          {"p90_cm", 100 * Quantile(errors.metres, 0.9)},
          {"p90_deg", Quantile(errors.degrees, 0.9)},
          {"within_5cm_2deg", within(0.05, 2)},
          {"within_10cm_0.5deg", within(0.1, 0.5)},
          {"within_15cm_5deg", within(0.15, 5)},
          {"within_25cm_2deg", within(0.25, 2)},
          {"within_50cm_5deg", within(0.5, 5)},
          {"within_5m_10deg", within(5, 10)},
          {"median_nees", Quantile(errors.nees, 0.5)},
          {"mean_nees", mean_nees},
          {"median_inliers", Quantile(errors.inliers, 0.5)},
          {"median_pose_ms", Quantile(errors.ms, 0.5)},
          {"p90_pose_ms", Quantile(errors.ms, 0.9)}};
}

void PrintStructure(const BuildResult& built) {
  const PoseReport& report = built.report.poses.value();
  std::printf(
      "map: %d of %d keyframes posed, %d planes fitted of %zu, %d of %d features placed, "
      "%d contradict, %.1f %% of matches consistent, %.2f s of %.1f s\n"
      "pose noise %.4f, %.3f deg by %d of %d keyframes\n",
      report.posed, report.keyframes, report.planes, built.map.planes.size(), report.placed,
      report.features, report.contradicting, 100 * report.consistent, report.seconds,
      built.report.total_s, report.noise.noise.position_sigma,
      report.noise.noise.rotation_sigma_rad * kDegreesPerRadian, report.noise.measured,
      report.noise.asked);
}

GivenPoses PosesByFrame(std::function<Isometry3d(int)> of_frame) {
  return {
      .frame = "truth",
      .unit = LengthUnit::kMetres,
      .of_keyframe = [of_frame = std::move(of_frame)](const Sequence&, const Keyframe& keyframe) {
        return std::optional(of_frame(keyframe.frame));
      }};
}

BuildResult BuildPosed(std::unique_ptr<Source> source, const GivenPoses& poses) {
  std::vector<std::unique_ptr<Source>> sources;
  sources.push_back(std::move(source));
  BuildOptions options;
  options.images = false;
  return BuildMap(sources, options, {}, poses);
}

// A made building, asked from another walk through it.
nlohmann::ordered_json MeasureBuilding(uint64_t seed, int frames) {
  const World world(DemoPlan(), WorldOptions{.seed = seed, .texture_richness = 0.5});
  const Renderer renderer(PinholeCamera(640, 480, 1.1));
  Walk walk = DemoWalk(world.plan(), {.step_m = 0.1, .seed = seed});
  walk.frames.resize(std::min<size_t>(walk.frames.size(), frames));
  Walk other =
      DemoWalk(world.plan(), {.height_m = 1.4, .step_m = 0.1, .gaze_offset_rad = 0.15, .seed = 77});
  other.frames.resize(std::min<size_t>(other.frames.size(), frames));
  const BuildResult built =
      BuildPosed(std::make_unique<WorldSource>(world, renderer, walk),
                 PosesByFrame([&](int frame) { return walk.frames[frame].world_from_camera; }));
  PrintStructure(built);
  const auto index = MapIndex::Build(built.map);
  const WorldSource queries(world, renderer, other);
  PoseErrors errors;
  for (int q = 5; q < std::ssize(other.frames); q += 7) {
    Ask(*index, queries.Render(q).grey, renderer.camera(), other.frames[q].world_from_camera,
        "building " + std::to_string(seed) + " frame " + std::to_string(q), errors);
  }
  return Summarise("building " + std::to_string(seed), errors);
}

nlohmann::ordered_json MeasureKitchen(const std::filesystem::path& folder) {
  const RgbdTruth truth(folder);
  const auto pose_of = [&](int frame) { return truth.world_from_colour(frame); };
  SourceOptions options;
  options.to = 499;
  std::unique_ptr<Source> source = OpenSource(folder.string(), options);
  const Camera camera = source->camera().value();
  const BuildResult built = BuildPosed(std::move(source), PosesByFrame(pose_of));
  PrintStructure(built);
  const auto index = MapIndex::Build(built.map);
  PoseErrors errors;
  for (int q = 500; q < 1000; q += 10) {
    Ask(*index, DecodeGrey(ReadBytes(folder / truth.image(q))), camera, pose_of(q),
        "kitchen " + std::to_string(q), errors);
  }
  return Summarise("kitchen", errors);
}

struct PosedPhoto {
  std::filesystem::path path;
  Camera camera;
  Isometry3d pose = Isometry3d::Identity();
};

// The photos of a role in poses.csv: K, centre and rotation of each.
std::vector<PosedPhoto> ReadPosedPhotos(const std::filesystem::path& folder,
                                        const std::string& role) {
  std::vector<PosedPhoto> photos;
  for (const std::vector<std::string>& row : ReadCsv(folder / "poses.csv")) {
    if (row.at(0) != role) continue;
    const auto number = [&](int i) { return std::stod(row.at(i)); };
    PosedPhoto photo;
    photo.path = folder / role / row.at(1);
    const cv::Mat image = DecodeGrey(ReadBytes(photo.path));
    photo.camera = {CameraModel::kPinhole,
                    image.cols,
                    image.rows,
                    {number(2), number(3), number(4), number(5)}};
    photo.pose.translation() = Eigen::Vector3d(number(6), number(7), number(8));
    for (int i = 0; i < 9; ++i) photo.pose.linear()(i / 3, i % 3) = number(9 + i);
    photos.push_back(photo);
  }
  return photos;
}

nlohmann::ordered_json MeasureChurch(const std::filesystem::path& folder) {
  const std::vector<PosedPhoto> map = ReadPosedPhotos(folder, "map");
  MemorySequence sequence{.name = "church", .camera = map.at(0).camera};
  for (int i = 0; i < std::ssize(map); ++i) {
    sequence.frames.emplace_back(FrameInfo{i, map[i].path.filename().string(), {}},
                                 [&map, i] { return DecodeGrey(ReadBytes(map[i].path)); });
  }
  const BuildResult built = BuildPosed(std::make_unique<MemorySource>(std::move(sequence)),
                                       PosesByFrame([&](int frame) { return map[frame].pose; }));
  PrintStructure(built);
  const auto index = MapIndex::Build(built.map);
  PoseErrors errors;
  for (const PosedPhoto& photo : ReadPosedPhotos(folder, "query_P8")) {
    Ask(*index, DecodeGrey(ReadBytes(photo.path)), photo.camera, photo.pose,
        photo.path.filename().string(), errors);
  }
  return Summarise("church", errors);
}

}  // namespace

int RunPoses(const Args& raw) {
  Args args = raw;
  const int buildings = std::stoi(TakeOption(args, "buildings", "3"));
  const int frames = std::stoi(TakeOption(args, "frames", "150"));
  const std::string kitchen = TakeOption(args, "kitchen", "");
  const std::string church = TakeOption(args, "church", "");
  if (!args.empty()) {
    throw MapError(ErrorCode::kUsage,
                   "poses takes --buildings N, --frames N, --kitchen DIR and --church DIR");
  }
  nlohmann::ordered_json json = {{"bench", "poses"}, {"sets", nlohmann::ordered_json::array()}};
  for (int seed = 1; seed <= buildings; ++seed) {
    json["sets"].push_back(MeasureBuilding(seed, frames));
  }
  if (!kitchen.empty()) json["sets"].push_back(MeasureKitchen(kitchen));
  if (!church.empty()) json["sets"].push_back(MeasureChurch(church));
  std::cout << json.dump() << std::endl;
  return 0;
}

}  // namespace waystone::bench
