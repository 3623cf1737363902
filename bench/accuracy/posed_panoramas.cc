// SPDX-License-Identifier: Apache-2.0
#include "bench/accuracy/posed_panoramas.h"

#include <cstdio>
#include <string>
#include <vector>

#include "bench/accuracy/common.h"
#include "bench/accuracy/panorama_places.h"
#include "bench/accuracy/posed_queries.h"
#include "core/geometry/angle.h"
#include "core/trajectory/shape_difference.h"

namespace waystone::bench {
namespace {

// Errors of answers in the appearance layer's own frame.
struct OwnErrors {
  int localized = 0;
  std::vector<double> metres;
  std::vector<double> degrees;
};

void AskOwnFrame(const MapIndex& index, const SplitPlaces& split, OwnErrors& errors) {
  const std::vector<AppearanceNode>& nodes = index.map().appearance->nodes;
  Points2 truth;
  Points2 own;
  for (const AppearanceNode& node : nodes) {
    truth.push_back(split.mapped[node.frame].position_m);
    own.emplace_back(node.pose.x, node.pose.y);
  }
  const Similarity2 world_from_layer = Align(truth, own, {.scale = true, .reflect = false});
  const double turn = std::atan2(world_from_layer.rotation(1, 0), world_from_layer.rotation(0, 0));
  for (const PanoramaPlace& place : split.asked) {
    const Answer answer = LocalizeImage(index, place.grey, {});
    if (answer.verdict != Verdict::kLocalized) continue;
    ++errors.localized;
    const Pose2& pose = answer.panorama->pose;
    const Eigen::Vector2d at = world_from_layer * Eigen::Vector2d(pose.x, pose.y);
    errors.metres.push_back((at - place.position_m).norm());
    errors.degrees.push_back(std::abs(WrappedAngle(pose.theta_rad + turn - place.yaw_rad)) *
                             kDegreesPerRadian);
  }
}

void Measure(const std::string& name, std::vector<PanoramaPlace> places,
             const BuildOptions& options, PoseErrors& posed, OwnErrors& own) {
  const SplitPlaces split = Split(InWalkOrder(std::move(places)));
  const BuildResult built = BuildPosed(
      PanoramaSource(split.mapped, 0, split.mapped.size(), "panoramas"),
      PosesByFrame([&](int frame) { return split.mapped[frame].world_from_camera; }), options);
  const auto index = MapIndex::Build(built.map);
  for (const PanoramaPlace& place : split.asked) {
    AskPose(*index, place.grey, std::nullopt, place.world_from_camera, name + " " + place.name,
            posed);
  }
  AskOwnFrame(
      *MapIndex::Build(BuildPosed(PanoramaSource(split.mapped, 0, split.mapped.size(), "panoramas"),
                                  std::nullopt, options)
                           .map),
      split, own);
}

nlohmann::ordered_json Summarise(const std::string& name, const PoseErrors& posed,
                                 const OwnErrors& own) {
  nlohmann::ordered_json json = SummarisePoses(name, posed);
  json["own_frame_localized"] = own.localized;
  json["own_frame_median_cm"] = 100 * Quantile(own.metres, 0.5);
  json["own_frame_median_deg"] = Quantile(own.degrees, 0.5);
  json["own_frame_p90_cm"] = 100 * Quantile(own.metres, 0.9);
  json["own_frame_p90_deg"] = Quantile(own.degrees, 0.9);
  return json;
}

}  // namespace

nlohmann::ordered_json MeasurePosedFlats(uint64_t first_seed, int flats,
                                         const BuildOptions& options) {
  PoseErrors posed;
  OwnErrors own;
  for (uint64_t seed = first_seed; seed < first_seed + static_cast<uint64_t>(flats); ++seed) {
    Measure("flat", RenderFlatPlaces(seed), options, posed, own);
  }
  return Summarise("flats", posed, own);
}

nlohmann::ordered_json MeasurePosedPlaces(const std::filesystem::path& folder,
                                          const BuildOptions& options) {
  PoseErrors posed;
  OwnErrors own;
  Measure("place", ReadPlaces(folder), options, posed, own);
  return Summarise("dealership", posed, own);
}

}  // namespace waystone::bench
