// SPDX-License-Identifier: Apache-2.0
#include <Eigen/SVD>
#include <cmath>
#include <cstdio>
#include <functional>
#include <iostream>
#include <nlohmann/json.hpp>
#include <numbers>

#include "bench/accuracy/common.h"
#include "bench/accuracy/panorama_places.h"
#include "bench/accuracy/rgbd_truth.h"
#include "core/base/error.h"
#include "core/geometry/angle.h"
#include "core/geometry/rotation.h"
#include "core/image/decode.h"
#include "core/manhattan/cube_rotations.h"
#include "localizer/appearance/appearance.h"
#include "localizer/orientation/building.h"
#include "schema/layers/orientation/orientation_trajectory.h"

namespace waystone::bench {
namespace {

using Eigen::Matrix3d;
using Json = nlohmann::ordered_json;

constexpr double kRight_m = 2.5;  // a place nearer than this is right

// What came of the answers' rotations (of panoramas: of all answers of a right place, believed or
// not) and of their axes as a gate.
struct Score {
  int asked = 0;
  int localized = 0;  // before the gate
  int with_heading = 0;
  int refused = 0;  // by the gate
  std::vector<double> errors_rad;
  // Of all answers whose lines were clear, localized or not: those of a right place and of a wrong
  // one, and how many of either disagree.
  int right_clear = 0;
  int right_disagree = 0;
  int wrong_clear = 0;
  int wrong_disagree = 0;
};

Json ToJson(const Score& s) {
  return {{"asked", s.asked},
          {"localized_before_gate", s.localized},
          {"with_heading", s.with_heading},
          {"median_error_deg", Quantile(s.errors_rad, 0.5) * kDegreesPerRadian},
          {"p90_error_deg", Quantile(s.errors_rad, 0.9) * kDegreesPerRadian},
          {"refused_by_axes", s.refused},
          {"right_with_clear_lines", s.right_clear},
          {"right_disagreeing", s.right_disagree},
          {"wrong_with_clear_lines", s.wrong_clear},
          {"wrong_disagreeing", s.wrong_disagree}};
}

void Print(const std::string& name, const Score& s) {
  std::printf(
      "%s: %d of %d localized, %d with a rotation, median %.2f deg off, 90 %% within %.2f; %d "
      "refused; clear lines disagree at %d of %d right places and %d of %d wrong ones\n",
      name.c_str(), s.localized, s.asked, s.with_heading,
      Quantile(s.errors_rad, 0.5) * kDegreesPerRadian,
      Quantile(s.errors_rad, 0.9) * kDegreesPerRadian, s.refused, s.right_disagree, s.right_clear,
      s.wrong_disagree, s.wrong_clear);
}

void Count(const BuildingView& view, bool right, const BuildingOptions& options, Score& score) {
  if (!view.disagreement_rad) return;
  const bool disagrees = *view.disagreement_rad > options.max_disagreement_rad;
  ++(right ? score.right_clear : score.wrong_clear);
  (right ? score.right_disagree : score.wrong_disagree) += disagrees ? 1 : 0;
}

// The rotation that most of building_from_camera world_from_camera^T agree on.
Matrix3d BuildingFromWorld(const OrientationLayer& layer,
                           const std::function<Matrix3d(int)>& world_from_camera) {
  Matrix3d sum = Matrix3d::Zero();
  for (const OrientationFrame& frame : layer.frames) {
    if (!frame.reliable) continue;
    sum += frame.rotation->building_from_rig.toRotationMatrix() *
           world_from_camera(frame.frame).transpose();
  }
  const Eigen::JacobiSVD<Matrix3d> svd(sum, Eigen::ComputeFullU | Eigen::ComputeFullV);
  return svd.matrixU() * svd.matrixV().transpose();
}

// Photos of the kitchen's other half, whose poses are good to some degrees.
Score AskKitchen(const std::string& folder) {
  const Range map_range = ParseRange("0:499");
  SourceOptions source_options;
  source_options.from = map_range.from;
  source_options.to = map_range.to;
  std::vector<std::unique_ptr<Source>> sources;
  sources.push_back(OpenSource(folder, source_options));
  BuildOptions build;
  build.layers = LayerChoiceByNames("planes,orientation");
  const std::optional<Camera> camera = sources.front()->camera();
  const auto index = MapIndex::Build(BuildMap(sources, build, {}).map);
  const RgbdTruth truth(folder);
  const auto world_from_camera = [&](int frame) -> Matrix3d {
    return truth.world_from_camera(frame).linear();
  };
  const Matrix3d building_from_world =
      BuildingFromWorld(*index->map().orientation, world_from_camera);
  Score score;
  LocalizeOptions options;
  options.camera = camera;
  for (int frame = 500; frame < 1000; frame += 10) {
    const auto bytes = ReadBytes(std::filesystem::path(folder) / truth.image(frame));
    const Answer answer = Localize(*index, bytes, truth.image(frame), options);
    ++score.asked;
    score.refused += answer.decided_by == DecidedBy::kBuildingAxes ? 1 : 0;
    if (!answer.building) continue;
    ++score.localized;
    Count(*answer.building, true, options.building, score);
    if (!answer.building->heading) continue;
    ++score.with_heading;
    score.errors_rad.push_back(
        RotationAngle(answer.building->building_from_query.toRotationMatrix(),
                      building_from_world * world_from_camera(frame)));
  }
  return score;
}

// Panoramas asked of a map of the others, at their true places.
Score AskPlaces(const std::string& folder) {
  const std::vector<PanoramaPlace> places = ReadPlaces(folder);
  std::vector<std::unique_ptr<Source>> sources;
  sources.push_back(OpenSource(folder + "/panorama", {}));
  BuildOptions build;
  build.appearance.redundancy.max_loss = 0;  // every place is asked for
  MapData map = BuildMap(sources, build, {}).map;
  for (AppearanceNode& node : map.appearance->nodes) {
    const PanoramaPlace& place = places[node.frame];
    node.pose = {place.position_m.x(), place.position_m.y(), place.yaw_rad};
  }
  const auto index = MapIndex::Build(std::move(map));
  const AppearanceLayer& layer = *index->map().appearance;
  const auto turned = [&](const OrientationFrame& frame) {
    return HeadingOf(*frame.rotation).value_or(0) - places[frame.frame].yaw_rad;
  };
  Score score;
  LocalizeOptions options;
  for (size_t i = 0; i < layer.nodes.size(); ++i) {
    const PanoramaPlace& place = places[layer.nodes[i].frame];
    const OrientationFrame* own = index->FindFrame(layer.nodes[i].sequence, layer.nodes[i].frame);
    std::vector<bool> left_out(layer.nodes.size());
    left_out[i] = true;
    const PanoramaQuery query = DescribeQuery(*index, place.grey, options.panorama);
    Answer answer = LocatePanorama(*index, query, options.panorama, left_out);
    ++score.asked;
    if (!answer.panorama) continue;
    const bool localized = answer.verdict == Verdict::kLocalized;
    const Eigen::Vector2d at(answer.panorama->pose.x, answer.panorama->pose.y);
    const bool right = (at - place.position_m).norm() <= kRight_m;
    // The guess through the place, whether it is believed or not.
    answer.heading = Heading{answer.panorama->pose.theta_rad, 0, HeadingFrame::kLayer};
    const auto guesses = GuessRotation(*index, answer, std::nullopt);
    const ManhattanFrame lines = DetectLines(place.grey, std::nullopt, options.building);
    answer.building = ViewBuilding(guesses, lines, options.building);
    Count(*answer.building, right, options.building, score);
    if (right && answer.building->heading && own && own->reliable) {
      ++score.with_heading;
      // Both are of one layer, whose axes may be turned by quarters against the world's.
      const double truth = place.yaw_rad + turned(*own);
      score.errors_rad.push_back(
          std::abs(std::remainder(answer.building->heading->rad - truth, 2 * std::numbers::pi)));
    }
    if (!localized) continue;
    ++score.localized;
    JudgeByAxes(static_cast<int>(guesses.size()), options.panorama.min_probability,
                options.building, answer);
    score.refused += answer.verdict == Verdict::kLocalized ? 0 : 1;
  }
  return score;
}

}  // namespace

int RunBuilding(const Args& args) {
  if (args.size() != 2) {
    throw MapError(ErrorCode::kUsage, "building takes two folders: kitchen and dealership");
  }
  const Score kitchen = AskKitchen(args[0]);
  Print("photos", kitchen);
  const Score places = AskPlaces(args[1]);
  Print("panoramas", places);
  std::cout << Json{{"bench", "building"},
                    {"photos", ToJson(kitchen)},
                    {"panoramas", ToJson(places)}}
                   .dump()
            << std::endl;
  return 0;
}

}  // namespace waystone::bench
