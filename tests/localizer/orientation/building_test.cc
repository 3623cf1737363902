// SPDX-License-Identifier: Apache-2.0
#include "localizer/orientation/building.h"
#include "core/geometry/rotation.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "core/base/clock.h"
#include "core/base/error.h"
#include "core/camera/image_plane.h"
#include "core/geometry/angle.h"
#include "core/manhattan/cube_rotations.h"
#include "localizer/localizer.h"
#include "tests/localizer/made_map.h"
#include "tests/world/test_worlds.h"

namespace waystone {
namespace {

using Eigen::AngleAxisd;
using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

Camera MadeCamera() { return {CameraModel::kPinhole, 640, 480, {500, 500, 319.5, 239.5}}; }

// The building as keyframe 1 sees it: looking along x, a little up, turned by 20 degrees.
Matrix3d BuildingFromWorld() {
  Matrix3d upright;
  upright << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  return AngleAxisd(20 * kDegree, Vector3d::UnitZ()) * upright *
         AngleAxisd(0.05, Vector3d::UnitX());
}

Matrix3d Truth(const MadePose& pose) { return BuildingFromWorld() * pose.r.transpose(); }

// The made map with a camera and, for each keyframe, its rotation in the building.
MapData OrientedMap() {
  MapData map = MadeMap();
  map.sequences[0].camera = MadeCamera();
  map.orientation.emplace();
  for (const Keyframe& keyframe : map.keyframes) {
    OrientationFrame frame;
    frame.id = OrientationFrameId{keyframe.id.value};
    frame.sequence = keyframe.sequence;
    frame.frame = keyframe.frame;
    frame.reliable = true;
    const Eigen::Quaterniond q(Truth(PoseOf(static_cast<double>(keyframe.id.value))));
    frame.rotation = BuildingRotation{q, 1e-6 * Matrix3d::Identity()};
    map.orientation->frames.push_back(frame);
  }
  return map;
}

Answer Asked(const MapIndex& index, const MapData& map, const MadePose& pose) {
  Answer answer = LocalizeFeatures(index, QueryOf(map, {1, 2}, pose, 20, 7), {});
  EXPECT_EQ(answer.verdict, Verdict::kLocalized);
  return answer;
}

// A frame of lines that can be relied on.
ManhattanFrame ClearLines(const Matrix3d& building_from_query) {
  ManhattanFrame lines;
  lines.rig_from_axes = building_from_query.transpose() * CubeRotations()[17];
  lines.covariance = 1e-6 * Matrix3d::Identity();
  lines.lines = {20, 20, 20};
  lines.rival = 0.3;
  lines.error = FrameError::kNone;
  return lines;
}

TEST(Building, OneGuessOfEachPlaneIsTheTruth) {
  const MapData map = OrientedMap();
  const auto index = MapIndex::Build(map);
  const MadePose pose = PoseOf(2.5);
  const Answer answer = Asked(*index, map, pose);
  ASSERT_EQ(answer.planes.recognised.size(), 2u);
  const auto guesses = GuessRotation(*index, answer, MadeCamera());
  ASSERT_GE(guesses.size(), 2u);
  EXPECT_LE(guesses.size(), 4u) << "a homography allows two";
  int near = 0;
  for (const BuildingGuess& guess : guesses) {
    const double off = RotationAngle(guess.building_from_query, Truth(pose));
    near += off < 1.5 * kDegree ? 1 : 0;
    EXPECT_GT(guess.sigma_rad, 0);
  }
  EXPECT_GE(near, 2) << "one of each plane";
  EXPECT_TRUE(GuessRotation(*index, answer, std::nullopt).empty()) << "takes a camera";
}

TEST(Building, PlanesThatAgreeTellWithoutLines) {
  const MapData map = OrientedMap();
  const auto index = MapIndex::Build(map);
  const MadePose pose = PoseOf(2.5);
  const auto guesses = GuessRotation(*index, Asked(*index, map, pose), MadeCamera());
  const BuildingView view = ViewBuilding(guesses, {}, {});
  ASSERT_TRUE(view.heading.has_value());
  EXPECT_LT(RotationAngle(view.building_from_query.toRotationMatrix(), Truth(pose)), 2 * kDegree);
  EXPECT_FALSE(view.disagreement_rad.has_value()) << "no lines, no say";
}

// The keyframe is nearer to the wall and looks along it, so that the point of the wall in the
// middle of the query is behind it.
TEST(Building, WhatTheQueryLooksAtMayBeBehindTheKeyframe) {
  MapData map = OrientedMap();
  const double f = 320 / std::tan(40 * kDegree);
  const Camera camera{CameraModel::kPinhole, 640, 480, {f, f, 319.5, 239.5}};
  map.sequences[0].camera = camera;
  const Matrix3d reference_from_query =
      AngleAxisd(-50 * kDegree, Vector3d::UnitY()).toRotationMatrix();
  const Vector3d reference(1, 0, 1.5);  // in the query's frame
  RecognisedPlane plane;
  plane.reference.id = KeyframeId{1};
  plane.inliers = 49;
  const auto pixel = [f](const Vector3d& x) {
    EXPECT_GT(x.z(), 0);
    return Vector2d(f * x.x() / x.z() + 319.5, f * x.y() / x.z() + 239.5);
  };
  for (int i = 0; i < 49; ++i) {
    const int column = i % 7, row = i / 7;
    const Vector3d x(1.15 + 0.06 * column, -0.3 + 0.1 * row, 2);  // on a wall 2 m ahead
    plane.query_points.push_back(pixel(x));
    plane.reference_points.push_back(pixel(reference_from_query * (x - reference)));
  }
  Answer answer;
  answer.verdict = Verdict::kLocalized;
  answer.planes.recognised.push_back(plane);
  const auto guesses = GuessRotation(*MapIndex::Build(map), answer, camera);
  const Matrix3d truth = Truth(PoseOf(1)) * reference_from_query;
  double nearest = 180;
  for (const BuildingGuess& guess : guesses) {
    nearest = std::min(nearest, RotationAngle(guess.building_from_query, truth) / kDegree);
  }
  EXPECT_LT(nearest, 0.1);
}

TEST(Building, PhotosThatArentTheCamerasGoWithout) {
  const MapData map = OrientedMap();
  const auto index = MapIndex::Build(map);
  Answer answer = Asked(*index, map, PoseOf(2.5));
  const BuildingQuery query{.camera = MadeCamera()};
  AddBuilding(*index, cv::Mat(240, 320, CV_8UC1, cv::Scalar(90)), query, {}, answer);
  EXPECT_FALSE(answer.building.has_value());
  EXPECT_EQ(answer.verdict, Verdict::kLocalized);
}

// Twice as wide as high, but no panorama: the planes answered.
TEST(Building, WidePhotosHaveACameraToo) {
  const MapData map = OrientedMap();
  const auto index = MapIndex::Build(map);
  const MadePose pose = PoseOf(2.5);
  Answer answer = Asked(*index, map, pose);
  BuildingQuery query{.camera = MadeCamera()};
  query.camera->height = 320;
  AddBuilding(*index, cv::Mat(320, 640, CV_8UC1, cv::Scalar(90)), query, {}, answer);
  ASSERT_TRUE(answer.building.has_value());
  EXPECT_LT(RotationAngle(answer.building->building_from_query.toRotationMatrix(), Truth(pose)),
            2 * kDegree);
}

TEST(Building, LinesSettleTheRotationUpToItsQuarterTurn) {
  const Matrix3d truth = Truth(PoseOf(2));
  const Matrix3d near = AngleAxisd(3 * kDegree, Vector3d::UnitZ()) * truth;
  const Matrix3d rival = AngleAxisd(30 * kDegree, Vector3d::UnitZ()) * truth;
  const BuildingView view =
      ViewBuilding({{rival, 0.01, 90}, {near, 0.01, 90}}, ClearLines(truth), {});
  ASSERT_TRUE(view.heading.has_value());
  EXPECT_LT(RotationAngle(view.building_from_query.toRotationMatrix(), truth), 1e-6);
  const Vector3d ahead = truth * Vector3d::UnitZ();
  EXPECT_NEAR(view.heading->rad, std::atan2(ahead.y(), ahead.x()), 1e-6);
  EXPECT_NEAR(view.heading->sigma_rad, 1e-3, 1e-4);
  EXPECT_EQ(view.heading->frame, HeadingFrame::kBuilding);
  EXPECT_NEAR(*view.disagreement_rad, 3 * kDegree, 1e-6);
  EXPECT_EQ(view.lines[0] + view.lines[1] + view.lines[2], 60);
}

TEST(Building, TwoMotionsOfOnePlaneStayOpen) {
  const Matrix3d one = Truth(PoseOf(2));
  const Matrix3d other = AngleAxisd(25 * kDegree, Vector3d::UnitZ()) * one;
  EXPECT_FALSE(ViewBuilding({{one, 0.01, 90}, {other, 0.01, 90}}, {}, {}).heading.has_value());
  EXPECT_TRUE(ViewBuilding({{one, 0.01, 90}, {other, 0.01, 90}, {one, 0.01, 40}}, {}, {})
                  .heading.has_value());
}

Answer Localized(double probability, double disagreement_rad) {
  Answer answer;
  answer.verdict = Verdict::kLocalized;
  answer.probability = probability;
  answer.planes.keyframe.emplace();
  answer.building.emplace();
  answer.building->disagreement_rad = disagreement_rad;
  return answer;
}

TEST(BuildingAxes, RefuseWhatIsNotSureEnoughToDisagree) {
  Answer agreeing = Localized(0.95, 0.05);
  JudgeByAxes(1, 0.9, {}, agreeing);
  EXPECT_EQ(agreeing.verdict, Verdict::kLocalized);
  EXPECT_EQ(agreeing.probability, 0.95);
  Answer disagreeing = Localized(0.95, 0.4);
  JudgeByAxes(1, 0.9, {}, disagreeing);
  EXPECT_EQ(disagreeing.verdict, Verdict::kNotInMap);
  EXPECT_EQ(disagreeing.decided_by, DecidedBy::kBuildingAxes);
  EXPECT_LT(disagreeing.probability, 0.9);
  EXPECT_FALSE(disagreeing.planes.keyframe.has_value());
  EXPECT_FALSE(disagreeing.message.empty());
  Answer sure = Localized(0.9999, 0.4);
  JudgeByAxes(1, 0.9, {}, sure);
  EXPECT_EQ(sure.verdict, Verdict::kLocalized) << "lines are wrong at times, too";
  EXPECT_LT(sure.probability, 0.9999);
}

TEST(BuildingAxes, SpeakAgainstAPlaceHoweverManyGuessesDisagree) {
  double last = 0;
  for (const int guesses : {1, 2, 5, 8, 12}) {
    Answer answer = Localized(0.95, 0.4);
    JudgeByAxes(guesses, 0, {}, answer);
    EXPECT_LT(answer.probability, 0.95) << guesses;
    EXPECT_GT(answer.probability, last) << "more chances to agree, less surprise";
    last = answer.probability;
  }
  for (const int guesses : {20, 1000}) {
    Answer answer = Localized(0.95, 0.4);
    JudgeByAxes(guesses, 0, {}, answer);
    EXPECT_EQ(answer.probability, 0.95) << guesses;
  }
  Answer refused = Localized(0.95, 0.4);
  JudgeByAxes(5, 0.9, {}, refused);
  EXPECT_EQ(refused.verdict, Verdict::kNotInMap);
}

// Eight planes of one view: each has the true motion and another one, some alike.
TEST(BuildingAxes, GuessesThatAreAlikeAreOneChance) {
  const Matrix3d truth = Truth(PoseOf(2));
  std::vector<BuildingGuess> guesses;
  for (int plane = 0; plane < 8; ++plane) {
    const Matrix3d near = AngleAxisd(0.005 * plane, Vector3d::UnitZ()) * truth;
    const Matrix3d rival = AngleAxisd((plane % 2 == 0 ? 25 : 65) * kDegree, Vector3d::UnitX()) *
                           AngleAxisd(0.01 * plane, Vector3d::UnitY()) * truth;
    guesses.push_back({near, 0.01, 60});
    guesses.push_back({rival, 0.01, 60});
  }
  EXPECT_EQ(CountChances(guesses, 0.17), 3);
  EXPECT_EQ(CountChances({}, 0.17), 0);
  const Matrix3d quarter = AngleAxisd(90 * kDegree, Vector3d::UnitZ()) * truth;
  EXPECT_EQ(CountChances({{truth, 0.01, 60}, {quarter, 0.01, 60}}, 0.17), 1) << "axes can't tell";
}

// Of a room as builders leave it, seen by one camera and all around.
TEST(Building, LinesOfRenderedImages) {
  WorldOptions look = TestOptions();
  look.trim = true;
  const World world(TwoRooms(), look);
  const Eigen::Isometry3d pose = WorldFromCamera({1.5, 2.0, 1.4}, 0.5, 0.1, 0.02);
  const Camera camera = PinholeCamera(480, 360, 1.2);
  const cv::Mat photo = Render(world, camera, pose).grey;
  const Camera around{CameraModel::kEquirectangular, 960, 480, {}};
  const cv::Mat panorama = Render(world, around, pose).grey;
  const Matrix3d truth = pose.linear().transpose();
  const ManhattanFrame of_photo = DetectLines(photo, camera, {});
  EXPECT_LT(CubeAngle(of_photo.rig_from_axes, truth), 1 * kDegree);
  const ManhattanFrame of_panorama = DetectLines(panorama, std::nullopt, {});
  EXPECT_LT(CubeAngle(of_panorama.rig_from_axes, truth), 1 * kDegree);
}

// Of 44 megapixels, which took seconds and a gigabyte.
TEST(Building, LinesOfLargePhotosAreDetectedInSmallerOnes) {
  WorldOptions look = TestOptions();
  look.trim = true;
  const World world(TwoRooms(), look);
  const Eigen::Isometry3d pose = WorldFromCamera({1.5, 2.0, 1.4}, 0.5, 0.1, 0.02);
  const Camera camera = PinholeCamera(480, 360, 1.2);
  const Camera large = ScaledCamera(camera, 7680);
  cv::Mat photo;
  cv::resize(Render(world, camera, pose).grey, photo, {large.width, large.height}, 0, 0,
             cv::INTER_CUBIC);
  BuildingOptions whole;
  whole.working_pixels = 50'000'000;
  Clock::time_point start = Clock::now();
  DetectLines(photo, large, whole);
  const double whole_s = SecondsSince(start);
  start = Clock::now();
  const ManhattanFrame lines = DetectLines(photo, large, {});
  EXPECT_LT(SecondsSince(start), 0.5 * whole_s);
  EXPECT_LT(CubeAngle(lines.rig_from_axes, pose.linear().transpose()), 1 * kDegree);
}

TEST(Building, OptionsOutOfRangeAreRefused) {
  BuildingOptions options;
  options.max_disagreement_rad = 1;
  EXPECT_THROW(options.Check(), MapError);
}

}  // namespace
}  // namespace waystone
