// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstdio>
#include <iostream>
#include <numeric>

#include "bench/accuracy/common.h"
#include "bench/accuracy/oriented_set.h"
#include "bench/accuracy/stopwatch.h"
#include "bench/baseline/paper_directions.h"
#include "core/geometry/angle.h"
#include "core/manhattan/cube_rotations.h"
#include "core/manhattan/great_circles.h"
#include "core/manhattan/manhattan_frame.h"

namespace waystone::bench {
namespace {

constexpr double kWrong = 5;  // degrees

struct Measured {
  double worst_deg = 0;  // axis against the truth, best assignment
  double sigma_deg = 0;  // that the frame states
  double sigmas = 0;     // of the rotation, in those its covariance states
  double segments_ms = 0;
  double frame_ms = 0;
  double paper_worst_deg = 0;  // of the paper's method on the same lines
  double paper_ms = 0;
  FrameError error = FrameError::kNone;
};

// sqrt(w^T C^-1 w / 3) of the rotation w between the two.
double SigmasOf(const ManhattanFrame& frame, const Eigen::Matrix3d& truth) {
  const Eigen::AngleAxisd turn(truth * NearestOfCube(frame.rig_from_axes, truth).transpose());
  const Eigen::Vector3d w = turn.angle() * turn.axis();
  return std::sqrt(w.dot(frame.covariance.ldlt().solve(w)) / 3);
}

Measured Measure(const OrientedSet& set, int i, SegmentDetector detector) {
  const std::vector<cv::Mat> images = set.images(i);
  Measured measured;
  const Stopwatch of_segments;
  std::vector<GreatCircle> lines;
  for (size_t c = 0; c < images.size(); ++c) {
    const auto segments = DetectSegments(images[c], {.detector = detector});
    const auto found = FindGreatCircles(set.rig, static_cast<int>(c), segments);
    lines.insert(lines.end(), found.begin(), found.end());
  }
  measured.segments_ms = 1e3 * of_segments.cpu_s();
  const Stopwatch of_frame;
  const ManhattanFrame frame = FindManhattanFrame(lines);
  measured.frame_ms = 1e3 * of_frame.cpu_s();
  measured.worst_deg =
      kDegreesPerRadian * WorstAxisAngle(frame.rig_from_axes, set.rig_from_axes[i]);
  measured.sigma_deg = kDegreesPerRadian * frame.sigma_rad();
  measured.sigmas = SigmasOf(frame, set.rig_from_axes[i]);
  measured.error = frame.error;
  const Stopwatch of_paper;
  const auto by_votes = FindDirectionsByVotes(lines);
  measured.paper_ms = 1e3 * of_paper.cpu_s();
  measured.paper_worst_deg =
      kDegreesPerRadian *
      WorstAxisAngle(by_votes.value_or(Eigen::Matrix3d::Identity()), set.rig_from_axes[i]);
  return measured;
}

double ShareBelow(const std::vector<double>& errors, double bound) {
  const auto below = std::ranges::count_if(errors, [&](double error) { return error < bound; });
  return static_cast<double>(below) / static_cast<double>(errors.size());
}

// Area under the share of errors below t, for t from 0 to the bound, over the bound.
double RecallArea(const std::vector<double>& errors, double bound) {
  double sum = 0;
  for (const double error : errors) sum += std::max(0.0, bound - error) / bound;
  return sum / static_cast<double>(errors.size());
}

std::vector<double> Collect(const std::vector<Measured>& all, double Measured::*field) {
  std::vector<double> values;
  for (const Measured& measured : all) values.push_back(measured.*field);
  return values;
}

// The paper's method: the vanishing point with the most votes first.
nlohmann::ordered_json PaperSummary(const std::vector<Measured>& all) {
  const std::vector<double> errors = Collect(all, &Measured::paper_worst_deg);
  return {{"worst_axis_median_deg", Quantile(errors, 0.5)},
          {"worst_axis_max_deg", Quantile(errors, 1)},
          {"below_1_deg", ShareBelow(errors, 1)},
          {"below_2_deg", ShareBelow(errors, 2)},
          {"below_5_deg", ShareBelow(errors, kWrong)},
          {"frame_ms_median", Quantile(Collect(all, &Measured::paper_ms), 0.5)}};
}

nlohmann::ordered_json Summary(const OrientedSet& set, const std::vector<Measured>& all) {
  const std::vector<double> errors = Collect(all, &Measured::worst_deg);
  const auto unreliable =
      std::ranges::count_if(all, [](const Measured& m) { return m.error != FrameError::kNone; });
  const auto unnoticed = std::ranges::count_if(
      all, [](const Measured& m) { return m.error == FrameError::kNone && m.worst_deg >= kWrong; });
  return {{"set", set.name},
          {"photos", set.size()},
          {"worst_axis_median_deg", Quantile(errors, 0.5)},
          {"worst_axis_max_deg", Quantile(errors, 1)},
          {"below_1_deg", ShareBelow(errors, 1)},
          {"below_2_deg", ShareBelow(errors, 2)},
          {"below_5_deg", ShareBelow(errors, kWrong)},
          {"recall_area_3_deg", RecallArea(errors, 3)},
          {"recall_area_5_deg", RecallArea(errors, 5)},
          {"recall_area_10_deg", RecallArea(errors, 10)},
          {"unreliable", unreliable},
          {"reliable_above_5_deg", unnoticed},
          {"stated_sigma_median_deg", Quantile(Collect(all, &Measured::sigma_deg), 0.5)},
          {"deviations_median", Quantile(Collect(all, &Measured::sigmas), 0.5)},
          {"deviations_95", Quantile(Collect(all, &Measured::sigmas), 0.95)},
          {"segments_ms_median", Quantile(Collect(all, &Measured::segments_ms), 0.5)},
          {"frame_ms_median", Quantile(Collect(all, &Measured::frame_ms), 0.5)},
          {"paper", PaperSummary(all)}};
}

void PrintRow(const nlohmann::ordered_json& row) {
  const auto value = [&](const char* key) { return row[key].get<double>(); };
  std::printf("%-18s %6d %7.3f %7.2f %6.1f %6.1f %6.1f %6.1f %6.1f %6.1f %6d %6d %7.1f %7.1f\n",
              row["set"].get<std::string>().c_str(), row["photos"].get<int>(),
              value("worst_axis_median_deg"), value("worst_axis_max_deg"),
              100 * value("below_1_deg"), 100 * value("below_2_deg"), 100 * value("below_5_deg"),
              100 * value("recall_area_3_deg"), 100 * value("recall_area_5_deg"),
              100 * value("recall_area_10_deg"), row["unreliable"].get<int>(),
              row["reliable_above_5_deg"].get<int>(), value("segments_ms_median"),
              value("frame_ms_median"));
  const nlohmann::ordered_json& paper = row["paper"];
  std::printf("%-18s %6s %7.3f %7.2f %6.1f %6.1f %6.1f %54.1f\n", "  as in the paper", "",
              paper["worst_axis_median_deg"].get<double>(),
              paper["worst_axis_max_deg"].get<double>(), 100 * paper["below_1_deg"].get<double>(),
              100 * paper["below_2_deg"].get<double>(), 100 * paper["below_5_deg"].get<double>(),
              paper["frame_ms_median"].get<double>());
}

std::vector<Measured> MeasureAll(const OrientedSet& set, SegmentDetector detector, bool verbose) {
  std::vector<Measured> all(set.size());
  // One photo after the other: times are those of one core.
  for (int i = 0; i < set.size(); ++i) {
    all[i] = Measure(set, i, detector);
    if (!verbose) continue;
    std::printf("%-18s %-10s %8.3f deg, stated %.3f deg, %s\n", set.name.c_str(),
                set.names[i].c_str(), all[i].worst_deg, all[i].sigma_deg,
                std::string(NameOf(all[i].error)).c_str());
  }
  return all;
}

}  // namespace

int RunDirections(const Args& raw) {
  Args args = raw;
  const SegmentDetector detector =
      SegmentDetectorByName(TakeOption(args, "detector", "edge_drawing"));
  const bool verbose = std::erase(args, "--photos") > 0;
  std::vector<OrientedSet> sets;
  for (const std::string& folder : args) sets.push_back(OpenOrientedSet(folder));
  if (sets.empty()) {
    constexpr int kFrames = 100;
    for (const bool rig : {true, false}) sets.push_back(RenderedSet(rig, kFrames));
  }
  std::printf("%-18s %6s %7s %7s %6s %6s %6s %6s %6s %6s %6s %6s %7s %7s\n", "worst axis", "photos",
              "median", "max", "<1", "<2", "<5", "AUC 3", "AUC 5", "AUC 10", "unrel.", "missed",
              "seg ms", "frame");
  nlohmann::ordered_json rows = nlohmann::ordered_json::array();
  for (const OrientedSet& set : sets) {
    rows.push_back(Summary(set, MeasureAll(set, detector, verbose)));
    PrintRow(rows.back());
  }
  std::cout << nlohmann::ordered_json{{"bench", "directions"},
                                      {"detector", NameOf(detector)},
                                      {"sets", rows}}
                   .dump()
            << std::endl;
  return 0;
}

}  // namespace waystone::bench
