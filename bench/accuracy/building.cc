// SPDX-License-Identifier: Apache-2.0
#include <Eigen/SVD>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <functional>
#include <iostream>
#include <nlohmann/json.hpp>
#include <numbers>
#include <optional>

#include "bench/accuracy/common.h"
#include "bench/accuracy/panorama_places.h"
#include "bench/accuracy/rgbd_truth.h"
#include "bench/baseline/scenes.h"
#include "core/base/error.h"
#include "core/geometry/angle.h"
#include "core/geometry/pose2.h"
#include "core/geometry/rotation.h"
#include "core/image/decode.h"
#include "localizer/appearance/appearance.h"
#include "localizer/orientation/building.h"
#include "schema/layers/orientation/orientation_trajectory.h"

namespace waystone::bench {
namespace {

using Eigen::Matrix3d;
using Json = nlohmann::ordered_json;

constexpr double kRight_m = 2.5;      // a place nearer than this is right
constexpr double kRight_px = 20;      // a transfer of the inliers nearer than this is right
constexpr double kFarOff_rad = 0.35;  // a rotation off by more has another axis, or none

// What became of the answers' rotations (with panoramas: of all answers, believed or not) and of
// their axes as a gate. Rotations are judged at right places only.
struct Score {
  int asked = 0;
  int localized = 0;  // before the gate
  int right = 0;      // of the answers that were looked at
  int wrong = 0;
  int with_heading = 0;
  int refused = 0;  // by the gate
  std::vector<double> errors_rad;
  // Of all answers whose lines were clear, localized or not: those at a right and at a wrong place,
  // and how many of each disagree.
  int right_clear = 0;
  int right_disagree = 0;
  int wrong_clear = 0;
  int wrong_disagree = 0;
};

Json ToJson(const Score& s) {
  const auto far_off =
      std::ranges::count_if(s.errors_rad, [](double error) { return error > kFarOff_rad; });
  return {{"asked", s.asked},
          {"localized_before_gate", s.localized},
          {"right", s.right},
          {"wrong", s.wrong},
          {"with_heading", s.with_heading},
          {"median_error_deg", Quantile(s.errors_rad, 0.5) * kDegreesPerRadian},
          {"p90_error_deg", Quantile(s.errors_rad, 0.9) * kDegreesPerRadian},
          {"off_by_20_deg", far_off},
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
  ++(right ? score.right : score.wrong);
  if (!view.disagreement_rad) return;
  const bool disagrees = *view.disagreement_rad > options.max_disagreement_rad;
  ++(right ? score.right_clear : score.wrong_clear);
  (right ? score.right_disagree : score.wrong_disagree) += disagrees ? 1 : 0;
}

// The building's axes in the world of the data's poses, if the data doesn't know them: the one
// rotation on which the map's reliable frames agree. How far each is off shows in the queries'
// errors.
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

// By depth and poses; nothing where they don't say.
std::optional<bool> IsRightPhoto(const RgbdTruth& truth, const MapIndex& index, int frame,
                                 const Answer& answer) {
  if (answer.verdict != Verdict::kLocalized) return std::nullopt;
  const auto error_px = truth.MedianError(frame, SceneAnswerOf(index, answer));
  if (!error_px) return std::nullopt;
  return *error_px <= kRight_px;
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
    const bool refused = answer.decided_by == DecidedBy::kBuildingAxes;
    score.refused += refused;
    score.localized += refused || answer.verdict == Verdict::kLocalized;
    if (!answer.building) continue;
    // What the gate refused names no place any more: without the camera there is no gate.
    const bool stands = answer.verdict == Verdict::kLocalized;
    const std::optional<bool> right = IsRightPhoto(
        truth, *index, frame, stands ? answer : Localize(*index, bytes, truth.image(frame), {}));
    if (!right) continue;
    Count(*answer.building, *right, options.building, score);
    if (!*right || !answer.building->heading) continue;
    ++score.with_heading;
    score.errors_rad.push_back(
        RotationAngle(answer.building->building_from_query.toRotationMatrix(),
                      building_from_world * world_from_camera(frame)));
  }
  return score;
}

int FrameOf(const AppearanceLayer& layer, AppearanceNodeId id) {
  return std::ranges::find(layer.nodes, id, &AppearanceNode::id)->frame;
}

// Quarter turns from the world, whose axes are the building's, to the axes as the layer numbers
// them: one number for the whole layer, that of most of its reliable frames.
double LayerFromWorld(const OrientationLayer& layer, const std::vector<PanoramaPlace>& places) {
  constexpr double kQuarter_rad = std::numbers::pi / 2;
  std::array<int, 4> votes{};
  for (const OrientationFrame& frame : layer.frames) {
    const auto heading = frame.reliable ? HeadingOf(*frame.rotation) : std::nullopt;
    if (!heading) continue;
    const double turned = *heading - places[frame.frame].yaw_rad;
    ++votes[static_cast<size_t>(std::lround(turned / kQuarter_rad) + 400) % votes.size()];
  }
  const auto most = std::ranges::max_element(votes) - votes.begin();
  return kQuarter_rad * static_cast<double>(most);
}

// Panoramas queried against the map that a build makes of them, each without its own node.
Score AskPlaces(const std::string& folder) {
  const std::vector<PanoramaPlace> places = ReadPlaces(folder);
  std::vector<std::unique_ptr<Source>> sources;
  sources.push_back(OpenSource(folder + "/panorama", {}));
  BuildOptions build;
  build.appearance.redundancy.max_loss = 0;  // every place is queried
  const auto index = MapIndex::Build(BuildMap(sources, build, {}).map);
  const AppearanceLayer& layer = *index->map().appearance;
  const double layer_from_world = LayerFromWorld(*index->map().orientation, places);
  Score score;
  LocalizeOptions options;
  for (size_t i = 0; i < layer.nodes.size(); ++i) {
    const PanoramaPlace& place = places[layer.nodes[i].frame];
    std::vector<bool> left_out(layer.nodes.size());
    left_out[i] = true;
    const PanoramaQuery query = DescribeQuery(*index, place.grey, options.panorama);
    Answer answer = LocatePanorama(*index, query, options.panorama, left_out);
    ++score.asked;
    if (!answer.panorama) continue;
    const bool localized = answer.verdict == Verdict::kLocalized;
    const PanoramaPlace& found = places[FrameOf(layer, answer.panorama->node.id)];
    const bool right = (found.position_m - place.position_m).norm() <= kRight_m;
    // The guess through the place, whether it is believed or not.
    answer.heading = Heading{answer.panorama->pose.theta_rad, 0, HeadingFrame::kLayer};
    const auto guesses = GuessRotation(*index, answer, std::nullopt);
    const ManhattanFrame lines = DetectLines(place.grey, std::nullopt, options.building);
    answer.building = ViewBuilding(guesses, lines, options.building);
    Count(*answer.building, right, options.building, score);
    if (right && answer.building->heading) {
      ++score.with_heading;
      const double truth = place.yaw_rad + layer_from_world;
      score.errors_rad.push_back(std::abs(WrappedAngle(answer.building->heading->rad - truth)));
    }
    if (!localized) continue;
    ++score.localized;
    JudgeByAxes(CountChances(guesses, options.building.max_disagreement_rad),
                options.panorama.min_probability, options.building, answer);
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
