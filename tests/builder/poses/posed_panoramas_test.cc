// SPDX-License-Identifier: Apache-2.0
// Maps of panoramas with the poses of their drive, asked for the panoramas between.
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <functional>
#include <string>

#include "builder/build_map.h"
#include "core/base/error.h"
#include "core/geometry/angle.h"
#include "core/geometry/rotation.h"
#include "core/robust/median.h"
#include "localizer/localizer.h"
#include "schema/file/map_problems.h"
#include "schema/file/map_store.h"
#include "schema/layers/poses/horizontal.h"
#include "tests/builder/appearance/drive.h"
#include "tests/builder/map/stage.h"

namespace waystone {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;
using PoseOfFrame = std::function<std::optional<Isometry3d>(int)>;

constexpr int kMappedEvery = 2;  // frames of the drive; those between are asked for

// As the drive rendered it.
Isometry3d DriveTruth(int frame) {
  const Pose2& pose = TheDrive().truth[frame];
  return WorldFromCamera({pose.x, pose.y, 1.2}, pose.theta_rad);
}

std::optional<Isometry3d> DrivePose(int frame) { return DriveTruth(frame); }

std::unique_ptr<Source> DriveSource() {
  MemorySequence sequence{.name = "drive", .frame_size = TheDrive().panoramas[0].size()};
  for (int i = 0; i < Drive::kFrames; i += kMappedEvery) {
    sequence.frames.emplace_back(FrameInfo{i, "image " + std::to_string(i), {}},
                                 [i] { return TheDrive().panoramas[i]; });
  }
  return std::make_unique<MemorySource>(std::move(sequence));
}

BuildOptions DriveOptions(int threads = 2) {
  BuildOptions options;
  options.threads = threads;
  options.images = false;
  options.appearance.loops.min_gap = 12;
  options.appearance_calibration.rendered_negatives = 2;
  return options;
}

GivenPoses InBuilding(const PoseOfFrame& poses) {
  GivenPoses given;
  given.frame = "building";
  given.unit = LengthUnit::kMetres;
  given.of_image = [poses](const Sequence&, const FrameInfo& image) { return poses(image.number); };
  return given;
}

BuildResult BuildDrive(const PoseOfFrame& poses, const BuildOptions& options = DriveOptions()) {
  std::vector<std::unique_ptr<Source>> sources;
  sources.push_back(DriveSource());
  return BuildMap(sources, options, {}, InBuilding(poses));
}

const BuildResult& PosedDrive() {
  static const BuildResult result = BuildDrive(DrivePose);
  return result;
}

std::string DriveRefusal(const PoseOfFrame& poses, const BuildOptions& options = DriveOptions()) {
  try {
    BuildDrive(poses, options);
  } catch (const MapError& error) {
    return error.what();
  }
  return "";
}

bool Says(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

// The squared error over that which the covariance expects.
double NormalisedError(const QueryPose& pose, const Isometry3d& truth) {
  Eigen::Matrix<double, 6, 1> error;
  error.head<3>() = truth.translation() - pose.frame_from_camera.translation();
  const Eigen::AngleAxisd turn(truth.linear() * pose.frame_from_camera.linear().transpose());
  error.tail<3>() = turn.angle() * turn.axis();
  return error.dot(pose.covariance.ldlt().solve(error)) / 6;
}

struct DriveErrors {
  std::vector<double> metres;
  std::vector<double> degrees;
  std::vector<double> normalised;
};

// Of the panoramas between, in a frame that the true one is turned into.
DriveErrors AskBetween(const MapData& map, const Isometry3d& frame_from_world) {
  const auto index = MapIndex::Build(map);
  DriveErrors errors;
  for (int i = 1; i < Drive::kFrames; i += kMappedEvery) {
    const Answer answer = LocalizeImage(*index, TheDrive().panoramas[i], {});
    if (!answer.pose) continue;
    EXPECT_EQ(answer.pose->frame, "building");
    const Isometry3d truth = frame_from_world * DriveTruth(i);
    const Isometry3d& pose = answer.pose->frame_from_camera;
    errors.metres.push_back((pose.translation() - truth.translation()).norm());
    errors.degrees.push_back(RotationAngle(pose.linear(), truth.linear()) * kDegreesPerRadian);
    errors.normalised.push_back(NormalisedError(*answer.pose, truth));
  }
  return errors;
}

TEST(PosedPanoramas, AreWhereTheirPosesAre) {
  const MapData& map = PosedDrive().map;
  const NodePoseReport& report = *PosedDrive().report.node_poses;
  ASSERT_TRUE(map.poses && map.appearance);
  EXPECT_EQ(report.posed, report.nodes);
  ASSERT_TRUE(report.consistent);
  EXPECT_GT(*report.consistent, 0.8);
  EXPECT_EQ(map.appearance->metres_per_unit, 1);
  EXPECT_TRUE(map.poses->keyframes.empty());
  ASSERT_EQ(map.poses->nodes.size(), map.appearance->nodes.size());
  for (const AppearanceNode& node : map.appearance->nodes) {
    const Pose2& truth = TheDrive().truth[node.frame];
    EXPECT_NEAR(node.pose.x, truth.x, 1e-9);
    EXPECT_NEAR(node.pose.y, truth.y, 1e-9);
    EXPECT_NEAR(WrappedAngle(node.pose.theta_rad - truth.theta_rad), 0, 1e-9);
    EXPECT_TRUE(map.poses->Find(node.id)->frame_from_camera().isApprox(DriveTruth(node.frame)));
  }
  // Measured steps are as long as true ones, roughly.
  std::vector<double> ratios;
  for (const AppearanceEdge& edge : map.appearance->edges) {
    if (edge.kind != AppearanceEdgeKind::kConsecutive) continue;
    const Pose2& a = map.appearance->nodes[edge.a.value - 1].pose;
    const Pose2& b = map.appearance->nodes[edge.b.value - 1].pose;
    ratios.push_back(std::hypot(edge.a_from_b.x, edge.a_from_b.y) /
                     std::hypot(a.x - b.x, a.y - b.y));
  }
  EXPECT_NEAR(Median(ratios), 1, 0.2);
  EXPECT_TRUE(FindMapProblems(map).empty());
}

TEST(PosedPanoramas, AreAnsweredWithTheirPoseAndItsUncertainty) {
  const DriveErrors errors = AskBetween(PosedDrive().map, Isometry3d::Identity());
  ASSERT_GT(errors.metres.size(), 15u);
  EXPECT_LT(Median(errors.metres), 0.1);
  EXPECT_LT(Median(errors.degrees), 2);
  // The drive is level and between its nodes a query is nearer than they are to each other, so that
  // errors are below what is measured on nodes; `waystone-bench poses` measures 0.5 and more.
  EXPECT_GT(Median(errors.normalised), 0.02);
  EXPECT_LT(Median(errors.normalised), 2);
}

// The frame of a reconstruction: y down, and turned about it. Nothing but the frame changes.
TEST(PosedPanoramas, InAFrameWithAnotherUpAreAnsweredInIt) {
  Isometry3d frame_from_world = Isometry3d::Identity();
  frame_from_world.linear() << 0, 1, 0, 0, 0, -1, -1, 0, 0;  // y is down
  frame_from_world.translation() = Vector3d(3, -7, 20);
  const BuildResult built =
      BuildDrive([&](int frame) { return std::optional(frame_from_world * DriveTruth(frame)); });
  EXPECT_TRUE(HorizontalOf(*built.map.poses).up.isApprox(-Vector3d::UnitY()));
  const DriveErrors errors = AskBetween(built.map, frame_from_world);
  const DriveErrors upright = AskBetween(PosedDrive().map, Isometry3d::Identity());
  ASSERT_EQ(errors.metres.size(), upright.metres.size());
  EXPECT_NEAR(Median(errors.metres), Median(upright.metres), 0.01);
  EXPECT_LT(Median(errors.degrees), 2);
}

TEST(PosedPanoramas, OfUnknownUnitHaveNoMetres) {
  std::vector<std::unique_ptr<Source>> sources;
  sources.push_back(DriveSource());
  GivenPoses given = InBuilding(DrivePose);
  given.unit = LengthUnit::kUnknown;
  const MapData map = BuildMap(sources, DriveOptions(), {}, given).map;
  EXPECT_FALSE(map.appearance->metres_per_unit);
  EXPECT_EQ(map.poses->unit, LengthUnit::kUnknown);
}

TEST(PosedPanoramas, AreTheSameOnAnyNumberOfThreadsAndInAFile) {
  EXPECT_TRUE(BuildDrive(DrivePose, DriveOptions(1)).map == PosedDrive().map);
}

// Nodes without a pose keep their place between those around them, and an answer at one has none.
TEST(PosedPanoramas, WithoutAPoseAreReportedAndGetNone) {
  const auto has_none = [](int frame) { return frame >= 10 && frame <= 20; };
  const BuildResult built = BuildDrive(
      [&](int frame) { return has_none(frame) ? std::nullopt : std::optional(DriveTruth(frame)); });
  const NodePoseReport& report = *built.report.node_poses;
  EXPECT_EQ(report.posed, report.nodes - 6);
  EXPECT_EQ(report.first_without, "image 10");
  for (const AppearanceNode& node : built.map.appearance->nodes) {
    EXPECT_EQ(built.map.poses->Find(node.id) == nullptr, has_none(node.frame));
    const Pose2& truth = TheDrive().truth[node.frame];
    EXPECT_LT(std::hypot(node.pose.x - truth.x, node.pose.y - truth.y), 0.4) << node.frame;
  }
  const auto index = MapIndex::Build(built.map);
  const Answer at_one = LocalizeImage(*index, TheDrive().panoramas[16], {});
  ASSERT_EQ(at_one.verdict, Verdict::kLocalized);
  EXPECT_FALSE(at_one.pose);
  EXPECT_TRUE(Says(at_one.pose_reason, "image 16, was mapped without a pose"))
      << at_one.pose_reason;
  const Answer elsewhere = LocalizeImage(*index, TheDrive().panoramas[36], {});
  EXPECT_TRUE(elsewhere.pose);
}

TEST(PosedPanoramas, OfTooFewImagesAreRefused) {
  const std::string refusal =
      DriveRefusal([](int frame) { return frame < 10 ? DrivePose(frame) : std::nullopt; });
  EXPECT_TRUE(Says(refusal, "only 5 of 24 panoramas have a pose (first without: image 10)"))
      << refusal;
  EXPECT_TRUE(Says(DriveRefusal([](int) { return std::nullopt; }), "only 0 of 24"));
}

TEST(PosedPanoramas, WithPosesThatContradictThemAreRefused) {
  const std::string shifted =
      DriveRefusal([](int frame) { return DrivePose((frame + 12) % Drive::kFrames); });
  EXPECT_TRUE(Says(shifted, "contradict the panoramas")) << shifted;
  EXPECT_TRUE(Says(shifted, "check that they are of this sequence")) << shifted;
  const std::string backward =
      DriveRefusal([](int frame) { return DrivePose(Drive::kFrames - 1 - frame); });
  EXPECT_TRUE(Says(backward, "contradict the panoramas")) << backward;
}

Isometry3d MirroredPose(int frame) {
  Isometry3d pose = DriveTruth(frame);
  pose.linear() = Vector3d(1, -1, 1).asDiagonal() * pose.linear() * Vector3d(-1, 1, 1).asDiagonal();
  pose.translation().y() *= -1;
  return pose;
}

TEST(PosedPanoramas, WithPosesInOtherConventionsAreNamed) {
  const std::string mirrored =
      DriveRefusal([](int frame) { return std::optional(MirroredPose(frame)); });
  EXPECT_TRUE(Says(mirrored, "mirrored")) << mirrored;
  const std::string inverse =
      DriveRefusal([](int frame) { return std::optional(DriveTruth(frame).inverse()); });
  EXPECT_TRUE(Says(inverse, "camera-from-world")) << inverse;
  const std::string opengl = DriveRefusal([](int frame) {
    Isometry3d pose = DriveTruth(frame);
    pose.linear() = pose.linear() * Vector3d(1, -1, -1).asDiagonal();
    return std::optional(pose);
  });
  EXPECT_TRUE(Says(opengl, "OpenGL")) << opengl;
}

// Without features the compass alone says how the camera turned.
TEST(PosedPanoramas, AreComparedByTheCompassWhereNodesKeepNoFeatures) {
  BuildOptions options = DriveOptions();
  options.appearance.describe.features.max_kept = 0;
  const BuildResult built = BuildDrive(DrivePose, options);
  ASSERT_TRUE(built.report.node_poses->consistent);
  EXPECT_GT(*built.report.node_poses->consistent, 0.8);
  const std::string mirrored =
      DriveRefusal([](int frame) { return std::optional(MirroredPose(frame)); }, options);
  EXPECT_TRUE(Says(mirrored, "mirrored")) << mirrored;
}

// Photos and panoramas of one frame in one map.
TEST(PosedPanoramas, AndPhotosShareAFrame) {
  std::vector<std::unique_ptr<Source>> sources;
  sources.push_back(DriveSource());
  sources.push_back(OpenStage(30, {}, TheStage().renderer.camera()));
  GivenPoses given = InBuilding({});
  given.of_image = [](const Sequence& sequence, const FrameInfo& image) {
    return std::optional(sequence.name == "drive"
                             ? DriveTruth(image.number)
                             : TheStage().walk.frames[image.number].world_from_camera);
  };
  const MapData map = BuildMap(sources, DriveOptions(), {}, given).map;
  EXPECT_EQ(map.poses->keyframes.size(), map.keyframes.size());
  EXPECT_EQ(map.poses->nodes.size(), map.appearance->nodes.size());
  EXPECT_TRUE(FindMapProblems(map).empty());
  EXPECT_LT(Median(AskBetween(map, Isometry3d::Identity()).metres), 0.1);
  const auto index = MapIndex::Build(map);
  LocalizeOptions options;
  options.camera = TheStage().renderer.camera();
  const Answer photo = LocalizeImage(*index, TheStage().frames[12], options);
  ASSERT_TRUE(photo.pose) << photo.pose_reason;
  EXPECT_LT((photo.pose->frame_from_camera.translation() -
             TheStage().walk.frames[12].world_from_camera.translation())
                .norm(),
            0.05);
}

// Keyframes alone have poses: the panoramas keep a frame of their own.
TEST(PosedPanoramas, WithoutAnyPoseBesidePosedPhotosStayAsTheyAre) {
  std::vector<std::unique_ptr<Source>> sources;
  sources.push_back(DriveSource());
  sources.push_back(OpenStage(30, {}, TheStage().renderer.camera()));
  GivenPoses given = InBuilding({});
  given.of_image = [](const Sequence& sequence, const FrameInfo& image) {
    return sequence.name == "drive"
               ? std::nullopt
               : std::optional(TheStage().walk.frames[image.number].world_from_camera);
  };
  const BuildResult built = BuildMap(sources, DriveOptions(), {}, given);
  EXPECT_EQ(built.report.node_poses->posed, 0);
  EXPECT_TRUE(built.map.poses->nodes.empty());
  EXPECT_FALSE(built.map.appearance->metres_per_unit);
  const Answer answer = LocalizeImage(*MapIndex::Build(built.map), TheDrive().panoramas[7], {});
  ASSERT_EQ(answer.verdict, Verdict::kLocalized);
  EXPECT_FALSE(answer.pose);
  EXPECT_TRUE(Says(answer.pose_reason, "poses of its photos alone")) << answer.pose_reason;
}

}  // namespace
}  // namespace waystone
