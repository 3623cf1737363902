// SPDX-License-Identifier: Apache-2.0
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iostream>

#include "bench/accuracy/common.h"
#include "bench/accuracy/heat_map.h"
#include "bench/accuracy/panorama_walks.h"
#include "bench/baseline/paper_odometry.h"
#include "builder/appearance/visual_odometry.h"
#include "core/base/clock.h"
#include "core/base/error.h"
#include "world/setting.h"

namespace waystone::bench {
namespace {

const std::vector<int> kMagnitudes = {2, 4, 8, 16, 32, 64};  // k1
const std::vector<int> kPhases = {4, 8, 16, 32, 64};         // k2
constexpr int kMostSteps = 4;

// What the paper's figures 8 to 11 show of one setting.
struct Study {
  HeatMap shapes;
  HeatMap seconds;
};

// Each panorama only against the one before it, with the paper's compass and steps straight ahead
// (baseline/paper_odometry.h), or with ours.
enum class Method { kPaper, kOurs };

template <class T>
std::vector<T> Every(const std::vector<T>& all, int step) {
  std::vector<T> some;
  for (size_t i = 0; i < all.size(); i += step) some.push_back(all[i]);
  return some;
}

std::vector<FourierSignature> WithPhases(std::vector<FourierSignature> signatures, int k2) {
  for (FourierSignature& signature : signatures) {
    signature.phases = HalfMatrix(signature.phases.leftCols(k2));
  }
  return signatures;
}

// Our odometry from the steps only: `trajectory` has k1 of all magnitudes; a smaller one changes
// only the lengths of the steps.
std::vector<Pose2> WithLengths(const std::vector<FourierSignature>& signatures,
                               const VisualOdometry& trajectory, int k1) {
  std::vector<Pose2> poses(1);
  for (const PanoramaRelation& step : trajectory.steps) {
    const double length = SignatureDistance(signatures[step.a], signatures[step.b], k1);
    Pose2 scaled = step.a_from_b;
    if (step.distance > 0) {
      scaled.x *= length / step.distance;
      scaled.y *= length / step.distance;
    }
    poses.push_back(poses.back() * scaled);
  }
  return poses;
}

// The whole way for each k1.
using Trajectories = std::vector<std::vector<Pose2>>;

Trajectories FollowOurs(const std::vector<FourierSignature>& signatures,
                        std::vector<double>& seconds) {
  VisualOdometryOptions options;
  options.max_span = 1;
  const Clock::time_point start = Clock::now();
  const VisualOdometry trajectory = FollowPanoramas(signatures, options.compass.band, options);
  const double of_headings = SecondsSince(start);
  Trajectories all;
  for (const int k1 : kMagnitudes) {
    const Clock::time_point lengths = Clock::now();
    all.push_back(WithLengths(signatures, trajectory, k1));
    seconds.push_back(of_headings + SecondsSince(lengths));
  }
  return all;
}

Trajectories FollowPaper(const std::vector<FourierSignature>& signatures,
                         std::vector<double>& seconds) {
  Trajectories all;
  for (const int k1 : kMagnitudes) {
    const Clock::time_point start = Clock::now();
    all.push_back(FollowByPaper(signatures, k1));
    seconds.push_back(SecondsSince(start));
  }
  return all;
}

void AddStep(const std::vector<FourierSignature>& all, const std::vector<Pose2>& truth, int step,
             Method method, Study& study) {
  const std::string title = "step " + std::to_string(step);
  HeatPanel shapes{title, kPhases, kMagnitudes, {}};
  HeatPanel seconds = shapes;
  const Points2 places = PlacesOf(Every(truth, step));
  for (const int k2 : kPhases) {
    const std::vector<FourierSignature> signatures = WithPhases(Every(all, step), k2);
    seconds.values.emplace_back();
    const Trajectories ways = method == Method::kOurs
                                  ? FollowOurs(signatures, seconds.values.back())
                                  : FollowPaper(signatures, seconds.values.back());
    shapes.values.emplace_back();
    for (const std::vector<Pose2>& poses : ways) {
      shapes.values.back().push_back(CompareShapes(places, PlacesOf(poses)).mu);
    }
  }
  study.shapes.panels.push_back(std::move(shapes));
  study.seconds.panels.push_back(std::move(seconds));
}

Study StudyOf(const PanoramaWalk& walk, const std::vector<FourierSignature>& signatures,
              Method method) {
  const std::string title = walk.name + (method == Method::kOurs ? ", ours" : ", the paper's");
  Study study{{title + ": shape difference", "k2", "k1", 4, {}},
              {title + ": seconds for the whole way", "k2", "k1", 2, {}}};
  for (int step = 1; step <= kMostSteps; ++step) {
    AddStep(signatures, GroundPoses(walk.walk), step, method, study);
  }
  return study;
}

void Print(const HeatMap& map) {
  std::printf("\n%s\n", map.title.c_str());
  for (const HeatPanel& panel : map.panels) {
    std::printf("%s  k2\\k1", panel.title.c_str());
    for (const int k1 : panel.columns) std::printf("%9d", k1);
    for (size_t r = 0; r < panel.rows.size(); ++r) {
      std::printf("\n%13d", panel.rows[r]);
      for (const double value : panel.values[r]) std::printf("%9.*f", map.decimals, value);
    }
    std::printf("\n");
  }
}

nlohmann::json Json(const HeatMap& map) {
  nlohmann::json panels;
  for (const HeatPanel& panel : map.panels) panels[panel.title] = panel.values;
  return panels;
}

void Write(const std::filesystem::path& path, const std::string& text) {
  std::ofstream out(path, std::ios::binary);
  out << text;
  out.close();
  if (!out) throw MapError(ErrorCode::kFileUnwritable, path.string() + " can't be written");
}

void WriteTable(const std::filesystem::path& path, const HeatMap& map) {
  std::string csv = "step,k2,k1,value\n";
  for (size_t p = 0; p < map.panels.size(); ++p) {
    const HeatPanel& panel = map.panels[p];
    for (size_t r = 0; r < panel.rows.size(); ++r) {
      for (size_t c = 0; c < panel.columns.size(); ++c) {
        csv += std::to_string(p + 1) + ',' + std::to_string(panel.rows[r]) + ',' +
               std::to_string(panel.columns[c]) + ',' + std::to_string(panel.values[r][c]) + '\n';
      }
    }
  }
  Write(path, csv);
}

}  // namespace

int RunStudy(const Args& raw) {
  Args args = raw;
  const std::filesystem::path out = TakeOption(args, "out", "");
  if (!args.empty()) throw MapError(ErrorCode::kUsage, "study takes --out DIR alone");
  if (!out.empty()) std::filesystem::create_directories(out);
  nlohmann::json json = {{"bench", "study"}, {"k1", kMagnitudes}, {"k2", kPhases}};
  for (const std::string name : {"office", "laboratory"}) {
    const PanoramaWalk walk = PanoramaWalkByName(name);
    const std::vector<FourierSignature> signatures = DescribeWalk(walk);
    for (const Method method : {Method::kPaper, Method::kOurs}) {
      const std::string by = method == Method::kOurs ? "ours" : "paper";
      const Study study = StudyOf(walk, signatures, method);
      for (const auto& [what, map] :
           {std::pair("shape", &study.shapes), std::pair("seconds", &study.seconds)}) {
        Print(*map);
        json[name][by][what] = Json(*map);
        if (out.empty()) continue;
        const std::string file = name + "-" + by + "-" + what;
        Write(out / (file + ".svg"), HeatMapSvg(*map));
        WriteTable(out / (file + ".csv"), *map);
      }
    }
  }
  std::cout << json.dump() << std::endl;
  return 0;
}

}  // namespace waystone::bench
