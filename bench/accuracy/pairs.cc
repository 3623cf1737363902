// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <numeric>
#include <sstream>

#include "bench/accuracy/common.h"
#include "bench/accuracy/misclassification.h"
#include "bench/accuracy/plane_labels.h"
#include "bench/accuracy/settings.h"
#include "bench/accuracy/stopwatch.h"
#include "core/base/error.h"

namespace waystone::bench {
namespace {

namespace fs = std::filesystem;

constexpr int kRuns = 5;  // whose median time is printed

struct LabelledPair {
  std::string name;
  MatchedPoints points;
  std::vector<int> truth;  // plane of each match, 0 for none
};

// matches.csv: a heading, then x1,y1,x2,y2,plane in pixels.
LabelledPair ReadPair(const fs::path& folder) {
  const fs::path path = folder / "matches.csv";
  std::ifstream in(path);
  if (!in) throw MapError(ErrorCode::kFileUnreadable, path.string() + " can't be read");
  LabelledPair pair;
  pair.name = fs::canonical(folder).filename();
  std::string line;
  std::getline(in, line);
  for (int number = 2; std::getline(in, line); ++number) {
    std::replace(line.begin(), line.end(), ',', ' ');
    std::istringstream fields(line);
    Eigen::Vector2d a;
    Eigen::Vector2d b;
    int plane = 0;
    if (!(fields >> a.x() >> a.y() >> b.x() >> b.y() >> plane)) {
      throw MapError(
          ErrorCode::kFileUnreadable,
          path.string() + ", line " + std::to_string(number) + ": wants x1,y1,x2,y2,plane");
    }
    pair.points.from.push_back(a);
    pair.points.to.push_back(b);
    pair.truth.push_back(plane);
  }
  return pair;
}

double MedianMilliseconds(const MatchedPoints& points, const PlaneLayerOptions& options) {
  std::vector<double> times;
  for (int run = 0; run < kRuns; ++run) {
    const Stopwatch watch;
    LabelPlanes(points, options);
    times.push_back(1e3 * watch.cpu_s());
  }
  return Quantile(times, 0.5);
}

void WriteLabels(const fs::path& folder, const std::string& name, const std::vector<int>& labels) {
  fs::create_directories(folder);
  std::ofstream out(folder / (name + ".txt"));
  for (int label : labels) out << label << "\n";
  if (!out.flush())
    throw MapError(ErrorCode::kFileUnwritable, folder.string() + " can't be written");
}

}  // namespace

int RunPairs(const Args& raw) {
  Args args = raw;
  const PlaneLayerOptions options = TakeBuildSettings(args).planes;
  const std::string labels_folder = TakeOption(args, "labels", "");
  if (args.empty()) throw MapError(ErrorCode::kUsage, "pairs wants folders with a matches.csv");
  std::vector<double> errors;
  std::vector<double> times;
  std::vector<double> times_per_300;
  nlohmann::ordered_json each = nlohmann::ordered_json::object();
  std::printf("%-14s %8s %7s %7s %8s %9s\n", "pair", "matches", "planes", "found", "error", "ms");
  for (const std::string& folder : args) {
    const LabelledPair pair = ReadPair(folder);
    const std::vector<int> labels = LabelPlanes(pair.points, options);
    const double error = Misclassification(pair.truth, labels);
    const double ms = MedianMilliseconds(pair.points, options);
    if (!labels_folder.empty()) WriteLabels(labels_folder, pair.name, labels);
    std::printf("%-14s %8d %7d %7d %7.1f%% %9.1f\n", pair.name.c_str(), pair.points.size(),
                *std::max_element(pair.truth.begin(), pair.truth.end()),
                *std::max_element(labels.begin(), labels.end()), 100 * error, ms);
    errors.push_back(error);
    times.push_back(ms);
    times_per_300.push_back(ms * 300 / pair.points.size());
    each[pair.name] = {{"error", error}, {"ms", ms}};
  }
  const double mean = std::accumulate(errors.begin(), errors.end(), 0.0) / errors.size();
  const nlohmann::ordered_json json = {
      {"bench", "pairs"},
      {"error_mean", mean},
      {"error_median", Quantile(errors, 0.5)},
      {"error_max", *std::max_element(errors.begin(), errors.end())},
      {"ms_median", Quantile(times, 0.5)},
      {"ms_max", *std::max_element(times.begin(), times.end())},
      {"ms_per_300_matches_max", *std::max_element(times_per_300.begin(), times_per_300.end())},
      {"pairs", each}};
  std::cout << json.dump() << std::endl;
  return 0;
}

}  // namespace waystone::bench
