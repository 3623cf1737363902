// SPDX-License-Identifier: Apache-2.0
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <iostream>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <set>

#include "bench/accuracy/common.h"
#include "bench/accuracy/orientation_world.h"
#include "bench/accuracy/settings.h"
#include "bench/accuracy/stopwatch.h"
#include "builder/frames/frame_pipeline.h"
#include "builder/orientation/follow.h"
#include "builder/orientation/orientation_layer.h"
#include "builder/orientation/view.h"
#include "builder/sources/memory_source.h"
#include "core/base/error.h"
#include "core/geometry/rotation.h"
#include "core/manhattan/cube_rotations.h"
#include "world/rig.h"

namespace waystone::bench {
namespace {

using Json = nlohmann::ordered_json;
using RigFiles = std::vector<std::vector<std::vector<unsigned char>>>;  // frame, camera, bytes

// How near a turn has to be to its corner, as a share of the frames: the bend's half length.
constexpr double kTurnShare = 0.03;
constexpr double kLoopM = 1.0;       // places this near, with one heading, are a loop
constexpr double kFalseLoopM = 4.0;  // nodes farther apart aren't
constexpr double kSameHeading = 0.35;
constexpr double kApartShare = 0.2;  // of the frames, from a place to when it is seen again
constexpr double kMaxScale = 2.5;    // at which SIFT still matches
constexpr double kBroken = 0.5;      // common view below which a view counts as broken

struct Score {
  int frames = 0;
  int true_turns = 0;
  int turns_found = 0;
  int turns_invented = 0;
  int directions_right = 0;
  int aside_jumps = 0;  // false turns where the camera looked aside
  double corridor_least_overlap = 1;
  int corridors_invented = 0;
  int true_loops = 0;
  int loops_found = 0;
  int loop_edges = 0;
  int false_loops = 0;
  int nodes = 0;  // traversable, but for the first and last frame
  int nodes_where_view_holds = 0;
  double common_at_nodes = 0;  // median
  int reliable = 0;
  int wrong_rotations = 0;  // reliable ones off by more than 5 degrees
};

double TrueHeading(const OrientationWorld& made, int frame) {
  const Eigen::Vector3d gaze = made.walk.frames[frame].world_from_camera.linear().col(2);
  return std::atan2(gaze.y(), gaze.x());
}

double Distance(const OrientationWorld& made, int a, int b) {
  return (made.walk.frames[a].world_from_camera.translation() -
          made.walk.frames[b].world_from_camera.translation())
      .norm();
}

bool SameHeading(const OrientationWorld& made, int a, int b) {
  const double turned = TrueHeading(made, a) - TrueHeading(made, b);
  return std::abs(std::remainder(turned, 2 * M_PI)) < kSameHeading;
}

void ScoreTurns(const OrientationWorld& made, const OrientationLayer& layer, Score& score) {
  const double reach = kTurnShare * score.frames;
  std::set<size_t> used;
  for (const TrueTurn& turn : made.turns) {
    ++score.true_turns;
    for (size_t i = 0; i < layer.turns.size(); ++i) {
      const OrientationTurn& found = layer.turns[i];
      if (!found.confirmed || used.contains(i)) continue;
      if (std::abs(found.frame.value - 1 - turn.frame) > reach) continue;
      used.insert(i);
      ++score.turns_found;
      score.directions_right += found.direction == turn.direction ? 1 : 0;
      break;
    }
  }
  for (const OrientationTurn& turn : layer.turns) {
    const int64_t at = turn.frame.value - 1;
    const bool aside = at >= made.looked_aside.first && at <= made.looked_aside.last;
    score.aside_jumps += aside && !turn.confirmed ? 1 : 0;
    score.turns_invented += turn.confirmed ? 1 : 0;
  }
  score.turns_invented -= score.turns_found;
}

// Frames in both over frames in either.
double Overlap(const TrueStretch& truth, const Corridor& found) {
  const int64_t first = found.first.value - 1;
  const int64_t last = found.last.value - 1;
  const int64_t both = std::min<int64_t>(truth.last, last) - std::max<int64_t>(truth.first, first);
  const int64_t either =
      std::max<int64_t>(truth.last, last) - std::min<int64_t>(truth.first, first);
  return std::max(0.0, static_cast<double>(both + 1) / static_cast<double>(either + 1));
}

void ScoreCorridors(const OrientationWorld& made, const OrientationLayer& layer, Score& score) {
  for (const TrueStretch& truth : made.corridors) {
    double best = 0;
    for (const Corridor& found : layer.corridors) best = std::max(best, Overlap(truth, found));
    score.corridor_least_overlap = std::min(score.corridor_least_overlap, best);
  }
  for (const Corridor& found : layer.corridors) {
    // When the rig looks aside it is in the corridor all the same.
    const bool known = Overlap(made.looked_aside, found) > 0 ||
                       std::ranges::any_of(made.corridors, [&](const TrueStretch& truth) {
                         return Overlap(truth, found) > 0;
                       });
    score.corridors_invented += known ? 0 : 1;
  }
}

// Stretches of frames that return to where the walk was long before, looking the same way.
std::vector<TrueStretch> Revisits(const OrientationWorld& made) {
  const int frames = static_cast<int>(made.walk.frames.size());
  const int apart = static_cast<int>(kApartShare * frames);
  std::vector<TrueStretch> revisits;
  for (int b = 0; b < frames; ++b) {
    bool seen = false;
    for (int a = 0; a < b - apart && !seen; ++a) {
      seen = Distance(made, a, b) < kLoopM && SameHeading(made, a, b);
    }
    if (!seen) continue;
    if (revisits.empty() || b > revisits.back().last + apart / 4) revisits.push_back({b, b});
    revisits.back().last = b;
  }
  return revisits;
}

void ScoreLoops(const OrientationWorld& made, const OrientationLayer& layer, int step,
                Score& score) {
  std::vector<int> ends;
  for (const OrientationEdge& edge : layer.edges) {
    if (edge.kind != OrientationEdgeKind::kLoop) continue;
    ++score.loop_edges;
    const auto a = static_cast<int>(edge.a.value - 1);
    const auto b = static_cast<int>(edge.b.value - 1);
    const bool wrong = Distance(made, a, b) > kFalseLoopM || !SameHeading(made, a, b);
    score.false_loops += wrong ? 1 : 0;
    if (!wrong) ends.push_back(b);
  }
  for (const TrueStretch& revisit : Revisits(made)) {
    ++score.true_loops;
    score.loops_found += std::ranges::any_of(
        ends, [&](int b) { return b >= revisit.first - step && b <= revisit.last + step; });
  }
}

void ScoreNodes(const OrientationWorld& made, const Rig& rig, const OrientationLayer& layer,
                Score& score) {
  std::vector<double> common;
  int from = 0;
  for (const OrientationNode& node : layer.nodes) {
    const auto at = static_cast<int>(node.frame.value - 1);
    if (node.kind == OrientationNodeKind::kTurn || at == 0 || at + 1 == score.frames) continue;
    common.push_back(CommonView(made, rig, from, at, kMaxScale));
    score.nodes_where_view_holds += common.back() > kBroken ? 1 : 0;
    from = at;
  }
  score.nodes = static_cast<int>(common.size());
  score.common_at_nodes = Quantile(common, 0.5);
}

// The building's x is the trajectory's first direction, up to quarter turns.
void ScoreRotations(const OrientationWorld& made, const OrientationLayer& layer, Score& score) {
  constexpr double kWrong = 5 * M_PI / 180;
  std::optional<Eigen::Matrix3d> world_from_building;
  for (size_t i = 0; i < layer.frames.size(); ++i) {
    const OrientationFrame& frame = layer.frames[i];
    if (!frame.reliable) continue;
    ++score.reliable;
    const Eigen::Matrix3d world_from_rig = made.walk.frames[i].world_from_camera.linear();
    const Eigen::Matrix3d building_from_rig = frame.rotation->building_from_rig.toRotationMatrix();
    if (!world_from_building) {
      const Eigen::Matrix3d raw = world_from_rig * building_from_rig.transpose();
      world_from_building = raw.array().round().matrix();
    }
    const double off = RotationAngle(*world_from_building * building_from_rig, world_from_rig);
    score.wrong_rotations += off > kWrong ? 1 : 0;
  }
}

Score ScoreOf(const OrientationWorld& made, const Rig& rig, const OrientationLayer& layer) {
  Score score;
  score.frames = static_cast<int>(layer.frames.size());
  ScoreTurns(made, layer, score);
  ScoreCorridors(made, layer, score);
  ScoreLoops(made, layer, 2 * layer.step, score);
  ScoreNodes(made, rig, layer, score);
  ScoreRotations(made, layer, score);
  return score;
}

RigFiles RenderAll(const OrientationWorld& made, const Rig& rig) {
  std::vector<Renderer> renderers;
  for (const RigCamera& camera : rig.cameras) renderers.emplace_back(camera.camera);
  RigFiles files(made.walk.frames.size());
  tbb::parallel_for(size_t{0}, files.size(), [&](size_t i) {
    files[i] = RenderRig(made, rig, renderers, static_cast<int>(i));
  });
  return files;
}

MemorySequence RigSequenceInMemory(const Rig& rig, const RigFiles& files) {
  MemorySequence sequence{.name = "rig", .faces = rig};
  for (size_t i = 0; i < files.size(); ++i) {
    const auto load = [&faces = files[i]] {
      std::vector<cv::Mat> images;
      for (const auto& face : faces) images.push_back(cv::imdecode(face, cv::IMREAD_GRAYSCALE));
      return images;
    };
    const auto first = [](const std::vector<cv::Mat>& images) { return images.front(); };
    const FrameInfo info{static_cast<int>(i), std::to_string(i), {}};
    sequence.frames.emplace_back(info, load, first);
  }
  return sequence;
}

// CPU seconds per frame for lines and features only.
double ObserveSeconds(const Rig& rig, const RigFiles& files, const OrientationOptions& options) {
  constexpr size_t kMost = 100;
  const size_t every = std::max<size_t>(1, files.size() / kMost);
  const std::vector<EncodedFrame> frames = RigSequenceInMemory(rig, files).frames;
  const Stopwatch watch;
  int observed = 0;
  for (size_t i = 0; i < frames.size(); i += every) {
    ObserveOrientation(rig, frames[i].info(), frames[i].Load(), options);
    ++observed;
  }
  return watch.cpu_s() / observed;
}

Json ToJson(const Score& s) {
  return {{"frames", s.frames},
          {"true_turns", s.true_turns},
          {"turns_found", s.turns_found},
          {"turns_invented", s.turns_invented},
          {"directions_right", s.directions_right},
          {"false_turns_told_apart", s.aside_jumps},
          {"corridor_least_overlap", s.corridor_least_overlap},
          {"corridors_invented", s.corridors_invented},
          {"true_loops", s.true_loops},
          {"loops_found", s.loops_found},
          {"loop_edges", s.loop_edges},
          {"false_loops", s.false_loops},
          {"nodes", s.nodes},
          {"nodes_where_view_holds", s.nodes_where_view_holds},
          {"common_view_at_nodes_median", s.common_at_nodes},
          {"reliable", s.reliable},
          {"reliable_off_by_5_deg", s.wrong_rotations}};
}

void PrintLines(const OrientationLayer& layer, const TrueStretch& stretch) {
  std::array<int, 3> sums{};
  for (int i = stretch.first; i <= stretch.last; ++i) {
    const OrientationFrame& frame = layer.frames[i];
    if (!frame.reliable) continue;
    for (int axis = 0; axis < 2; ++axis) sums[axis] += frame.lines[axis];
    ++sums[2];
  }
  std::printf(" %d:%d (%d)", sums[0], sums[1], sums[2]);
}

// What was found where, for people.
void PrintLayer(const OrientationWorld& made, const OrientationLayer& layer) {
  std::printf("  corners");
  for (const TrueTurn& turn : made.turns) {
    std::printf(" %d%s", turn.frame, turn.direction > 0 ? "L" : "R");
  }
  std::printf("; aside %d-%d, skewed %d-%d\n  turns", made.looked_aside.first,
              made.looked_aside.last, made.skewed.first, made.skewed.last);
  for (const OrientationTurn& turn : layer.turns) {
    std::printf(turn.confirmed ? " %d%s" : " (%d%s)", static_cast<int>(turn.frame.value - 1),
                turn.direction > 0 ? "L" : "R");
  }
  std::printf("\n  true corridors");
  for (const TrueStretch& s : made.corridors) std::printf(" %d-%d", s.first, s.last);
  std::printf("; found");
  for (const Corridor& c : layer.corridors) {
    std::printf(" %d-%d", static_cast<int>(c.first.value - 1), static_cast<int>(c.last.value - 1));
  }
  std::printf("\n  lines along x and y, reliable frames, of each");
  for (const TrueStretch& corridor : made.corridors) PrintLines(layer, corridor);
  std::printf("; between the room's corners");
  for (size_t i = 0; i + 1 < made.turns.size() && i < 3; ++i) {
    PrintLines(layer, {made.turns[i].frame, made.turns[i + 1].frame});
  }
  std::printf("\n  nodes");
  for (const OrientationNode& node : layer.nodes) {
    std::printf(" %d", static_cast<int>(node.frame.value - 1));
  }
  std::printf("\n");
}

// What to run, but for the building and the camera.
struct Runs {
  int frames = 1000;
  bool trim = true;
  double scale = 1;  // of the pictures
  OrientationOptions options;
};

Json RunOne(int building, bool rig_wanted, const Runs& runs) {
  const auto pixels = [&](double full) { return static_cast<int>(std::lround(full * runs.scale)); };
  const Rig rig =
      rig_wanted ? CubeRig(pixels(320)) : RigOfOne(PinholeCamera(pixels(640), pixels(480), 1.1));
  const OrientationWorld made = MakeOrientationWorld(building, runs.frames, runs.trim);
  const RigFiles files = RenderAll(made, rig);
  const double look_s = ObserveSeconds(rig, files, runs.options);
  MemorySource source(RigSequenceInMemory(rig, files));
  const Stopwatch watch;
  OrientationLayerBuilder builder(runs.options);
  const MapData map = BuildLayer({&source}, builder);
  const OrientationLayer& layer = map.orientation.value();
  const double cpu_s = watch.cpu_s();
  const double wall_s = watch.wall_s();
  const Score score = ScoreOf(made, rig, layer);
  std::printf(
      "%s, %s: turns %d of %d, %d invented, %d directions right; corridors %.2f; loops %d of "
      "%d, %d false; nodes %d, %d of them in view\n",
      made.name.c_str(), rig_wanted ? "rig" : "pinhole", score.turns_found, score.true_turns,
      score.turns_invented, score.directions_right, score.corridor_least_overlap, score.loops_found,
      score.true_loops, score.false_loops, score.nodes, score.nodes_where_view_holds);
  PrintLayer(made, layer);
  Json json = {{"building", made.name},
               {"camera", rig_wanted ? "rig" : "pinhole"},
               {"trim", runs.trim},
               {"scale", runs.scale}};
  json.update(ToJson(score));
  json["frames_per_s"] = score.frames / wall_s;
  json["cpu_ms_per_frame"] = 1000 * cpu_s / score.frames;
  json["cpu_ms_per_frame_lines_and_features"] = 1000 * look_s;
  json["cost_ratio"] = cpu_s / score.frames / look_s;
  return json;
}

}  // namespace

int RunOrientation(const Args& all) {
  Args args = all;
  const int buildings = std::stoi(TakeOption(args, "buildings", "3"));
  const int first = std::stoi(TakeOption(args, "first", "0"));
  Runs runs;
  runs.options = TakeBuildSettings(args).orientation;
  runs.frames = std::stoi(TakeOption(args, "frames", "1000"));
  runs.trim = TakeOption(args, "trim", "yes") != "no";
  runs.scale = std::stod(TakeOption(args, "scale", "1"));
  const std::string camera = TakeOption(args, "camera", "both");
  if (!args.empty() || buildings < 1 || first < 0 || first + buildings > 3 || runs.frames < 100 ||
      runs.scale < 0.25 || runs.scale > 4) {
    throw MapError(ErrorCode::kUsage,
                   "orientation takes --buildings 1 to 3, --first 0 to 2, --frames of 100 or "
                   "more, --camera rig, pinhole or both, --trim yes or no, --scale 0.25 to 4, "
                   "--set NAME=VALUE");
  }
  Json results = Json::array();
  for (int building = first; building < first + buildings; ++building) {
    for (const bool rig : {true, false}) {
      if (camera == (rig ? "pinhole" : "rig")) continue;
      results.push_back(RunOne(building, rig, runs));
      std::cout << results.back().dump() << std::endl;
    }
  }
  std::cout << Json{{"bench", "orientation"}, {"runs", results}}.dump() << std::endl;
  return 0;
}

}  // namespace waystone::bench
