// SPDX-License-Identifier: Apache-2.0
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <iostream>
#include <optional>

#include "bench/accuracy/common.h"
#include "bench/accuracy/oriented_set.h"
#include "bench/accuracy/stopwatch.h"
#include "bench/baseline/paper_motion.h"
#include "core/base/error.h"
#include "core/geometry/angle.h"
#include "core/geometry/rotation.h"
#include "core/manhattan/cube_rotations.h"
#include "core/manhattan/great_circles.h"
#include "core/manhattan/manhattan_frame.h"
#include "core/two_view/relative_rotation.h"

namespace waystone::bench {
namespace {

constexpr double kWrong = 5;      // degrees off the truth
constexpr double kCongruent = 5;  // degrees between the two rotations of a traversable pair
// How many places the pairs are apart whose verdict is compared with what is visible.
constexpr std::array kApart{1, 3, 10, 30};

struct Place {
  BearingFeatures features;
  ManhattanFrame frame;
};

Place LookAt(const OrientedSet& set, int i) {
  const std::vector<cv::Mat> images = set.images(i);
  std::vector<GreatCircle> lines;
  for (size_t c = 0; c < images.size(); ++c) {
    const auto found = FindGreatCircles(set.rig, static_cast<int>(c), DetectSegments(images[c]));
    lines.insert(lines.end(), found.begin(), found.end());
  }
  return {ExtractBearings(set.rig, images), FindManhattanFrame(lines)};
}

struct Pair {
  int a = 0;
  int b = 0;
  int apart = 0;
  bool accepted = false;
  bool traversable = false;
  bool visible = false;
  double rotation_deg = 0;   // off the truth
  double direction_deg = 0;  // of the motion, off the truth
  double sigmas = 0;         // of the rotation, in those its covariance states
  double inliers = 0;
  std::optional<double> paper_rotation_deg = {};  // of the paper's method, where it accepts
  double paper_direction_deg = 0;
};

double DirectionError(const Eigen::Vector3d& direction, const Eigen::Vector3d& truth) {
  return kDegreesPerRadian * std::atan2(truth.cross(direction).norm(), truth.dot(direction));
}

Pair Judge(const OrientedSet& set, const std::vector<Place>& places, int a, int apart) {
  Pair pair{.a = a, .b = a + apart, .apart = apart};
  const Place& from = places[pair.a];
  const Place& to = places[pair.b];
  const RelativePose pose = FindRelativePose(MatchBearings(from.features, to.features));
  pair.accepted = pose.accepted();
  pair.inliers = static_cast<double>(pose.inliers.size());
  const Eigen::Isometry3d truth = set.world_from_rig[pair.b].inverse() * set.world_from_rig[pair.a];
  pair.rotation_deg = kDegreesPerRadian * RotationAngle(pose.b_from_a, truth.linear());
  const Eigen::Vector3d direction = truth.translation().normalized();
  pair.direction_deg = DirectionError(pose.translation, direction);
  if (pair.accepted) {
    const Eigen::AngleAxisd turn(truth.linear() * pose.b_from_a.transpose());
    const Eigen::Vector3d w = turn.angle() * turn.axis();
    pair.sigmas = std::sqrt(w.dot(pose.covariance.ldlt().solve(w)) / 3);
  }
  // R_c = R_1 R_2^T, with the axes numbered to bring it closest to the essential matrix's.
  const Eigen::Matrix3d b_from_axes =
      NearestOfCube(to.frame.rig_from_axes, pose.b_from_a * from.frame.rig_from_axes);
  const Eigen::Matrix3d from_axes = b_from_axes * from.frame.rig_from_axes.transpose();
  pair.traversable = pair.accepted && from.frame.reliable() && to.frame.reliable() &&
                     kDegreesPerRadian * RotationAngle(from_axes, pose.b_from_a) < kCongruent;
  pair.visible = !set.visible.empty() &&
                 (set.visible[pair.a].contains(pair.b) || set.visible[pair.b].contains(pair.a));
  return pair;
}

// The same pair by the paper's method, on the same matches.
void AddPaper(const OrientedSet& set, const std::vector<Place>& places, Pair& pair) {
  const auto found =
      FindMotionByEightPoints(MatchBearings(places[pair.a].features, places[pair.b].features));
  if (!found) return;
  const Eigen::Isometry3d truth = set.world_from_rig[pair.b].inverse() * set.world_from_rig[pair.a];
  pair.paper_rotation_deg =
      kDegreesPerRadian * RotationAngle(found->motion.b_from_a, truth.linear());
  pair.paper_direction_deg =
      DirectionError(found->motion.translation, truth.translation().normalized());
}

// The paper's method: eight points, and ten inliers are enough.
nlohmann::ordered_json PaperSummary(const std::vector<Pair>& pairs) {
  std::vector<double> rotation;
  std::vector<double> direction;
  for (const Pair& pair : pairs) {
    if (!pair.paper_rotation_deg) continue;
    rotation.push_back(*pair.paper_rotation_deg);
    direction.push_back(pair.paper_direction_deg);
  }
  return {{"accepted", rotation.size()},
          {"rotation_median_deg", Quantile(rotation, 0.5)},
          {"rotation_95_deg", Quantile(rotation, 0.95)},
          {"rotation_max_deg", Quantile(rotation, 1)},
          {"direction_median_deg", Quantile(direction, 0.5)},
          {"accepted_above_5_deg",
           std::ranges::count_if(rotation, [](double deg) { return deg > kWrong; })}};
}

nlohmann::ordered_json RotationSummary(const std::vector<Pair>& pairs) {
  std::vector<double> rotation;
  std::vector<double> direction;
  std::vector<double> sigmas;
  for (const Pair& pair : pairs) {
    if (!pair.accepted) continue;
    rotation.push_back(pair.rotation_deg);
    direction.push_back(pair.direction_deg);
    sigmas.push_back(pair.sigmas);
  }
  return {{"pairs", pairs.size()},
          {"accepted", rotation.size()},
          {"rotation_median_deg", Quantile(rotation, 0.5)},
          {"rotation_95_deg", Quantile(rotation, 0.95)},
          {"rotation_max_deg", Quantile(rotation, 1)},
          {"direction_median_deg", Quantile(direction, 0.5)},
          {"deviations_median", Quantile(sigmas, 0.5)},
          {"accepted_above_5_deg",
           std::ranges::count_if(rotation, [](double deg) { return deg > kWrong; })},
          {"paper", PaperSummary(pairs)}};
}

nlohmann::ordered_json VerdictSummary(const std::vector<Pair>& pairs) {
  int traversable = 0;
  int visible = 0;
  int both = 0;
  for (const Pair& pair : pairs) {
    traversable += pair.traversable ? 1 : 0;
    visible += pair.visible ? 1 : 0;
    both += pair.traversable && pair.visible ? 1 : 0;
  }
  return {{"pairs", pairs.size()},
          {"traversable", traversable},
          {"visible", visible},
          {"precision", traversable > 0 ? static_cast<double>(both) / traversable : 0},
          {"recall", visible > 0 ? static_cast<double>(both) / visible : 0}};
}

void Print(const char* title, const std::vector<Pair>& pairs, bool visibility) {
  const auto rotation = RotationSummary(pairs);
  const auto verdict = VerdictSummary(pairs);
  std::printf("%-8s %5zu %8d %7.3f %7.3f %7.2f %7.2f %6d %6d", title, pairs.size(),
              rotation["accepted"].get<int>(), rotation["rotation_median_deg"].get<double>(),
              rotation["rotation_95_deg"].get<double>(), rotation["rotation_max_deg"].get<double>(),
              rotation["direction_median_deg"].get<double>(),
              rotation["accepted_above_5_deg"].get<int>(), verdict["traversable"].get<int>());
  if (visibility) {
    std::printf(" %8d %9.3f %7.3f", verdict["visible"].get<int>(),
                verdict["precision"].get<double>(), verdict["recall"].get<double>());
  }
  std::printf("\n");
  const auto& paper = rotation["paper"];
  std::printf("%-14s %8d %7.3f %7.3f %7.2f %7.2f %6d\n", "  eight points",
              paper["accepted"].get<int>(), paper["rotation_median_deg"].get<double>(),
              paper["rotation_95_deg"].get<double>(), paper["rotation_max_deg"].get<double>(),
              paper["direction_median_deg"].get<double>(),
              paper["accepted_above_5_deg"].get<int>());
}

std::vector<Pair> OfDistance(const std::vector<Pair>& pairs, int apart) {
  std::vector<Pair> some;
  std::ranges::copy_if(pairs, std::back_inserter(some),
                       [&](const Pair& pair) { return pair.apart == apart; });
  return some;
}

// Those of places that aren't consecutive.
std::vector<Pair> ApartPairs(const std::vector<Pair>& pairs) {
  std::vector<Pair> some;
  std::ranges::copy_if(pairs, std::back_inserter(some),
                       [](const Pair& pair) { return pair.apart > 1; });
  return some;
}

}  // namespace

int RunRelative(const Args& args) {
  constexpr int kFrames = 120;
  if (args.size() > 1) throw MapError(ErrorCode::kUsage, "relative takes one folder, or none");
  const OrientedSet set = args.empty() ? RenderedSet(true, kFrames) : OpenOrientedSet(args[0]);
  if (set.world_from_rig.empty()) throw MapError(ErrorCode::kUsage, "relative wants poses");
  std::vector<Place> places(set.size());
  tbb::parallel_for(0, set.size(), [&](int i) { places[i] = LookAt(set, i); });
  std::vector<std::pair<int, int>> wanted;
  for (const int apart : kApart) {
    for (int a = 0; a + apart < set.size(); ++a) wanted.emplace_back(a, apart);
  }
  std::vector<Pair> pairs(wanted.size());
  const Stopwatch watch;
  tbb::parallel_for(size_t{0}, wanted.size(), [&](size_t i) {
    pairs[i] = Judge(set, places, wanted[i].first, wanted[i].second);
  });
  const double ms_per_pair = 1000 * watch.cpu_s() / static_cast<double>(pairs.size());
  tbb::parallel_for(size_t{0}, pairs.size(), [&](size_t i) { AddPaper(set, places, pairs[i]); });
  const bool visibility = !set.visible.empty();
  std::printf("%-8s %5s %8s %7s %7s %7s %7s %6s %6s%s\n", "apart", "pairs", "accepted", "median",
              "95 %", "max", "direct.", "wrong", "trav.",
              visibility ? "  visible precision  recall" : "");
  for (const int apart : kApart) {
    Print(std::to_string(apart).c_str(), OfDistance(pairs, apart), visibility);
  }
  Print("all", pairs, visibility);
  nlohmann::ordered_json json = {{"bench", "relative"},
                                 {"set", set.name},
                                 {"consecutive", RotationSummary(OfDistance(pairs, 1))},
                                 {"apart", RotationSummary(ApartPairs(pairs))},
                                 {"all", RotationSummary(pairs)},
                                 {"cpu_ms_per_pair", ms_per_pair}};
  if (visibility) {
    json["traversability"] = {{"consecutive", VerdictSummary(OfDistance(pairs, 1))},
                              {"all", VerdictSummary(pairs)}};
  }
  std::cout << json.dump() << std::endl;
  return 0;
}

}  // namespace waystone::bench
