// SPDX-License-Identifier: Apache-2.0
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "api/json.h"
#include "cli/commands/commands.h"
#include "cli/files/finite.h"
#include "cli/files/output_file.h"
#include "cli/files/trajectory_file.h"
#include "cli/output/trajectory_plot.h"
#include "core/base/error.h"
#include "schema/file/file_replacer.h"

namespace waystone {
namespace {

struct TrajectoryFlags {
  std::string estimate;
  std::string truth;
  std::string odometry;
  std::string plot;
  AssociationOptions association;
  bool force = false;
  bool json = false;
};

Json ErrorJson(const TrajectoryError& error) {
  const Similarity2& s = error.shape.truth_from_estimate;
  Json json = {{"pairs", error.pairs}, {"shape_difference", error.shape.mu},
               {"ate_m", error.ate_m}, {"ate_scaled_m", error.ate_scaled_m},
               {"scale", s.scale},     {"reflected", s.rotation.determinant() < 0}};
  json["rpe_m"] = error.rpe_m ? Json(*error.rpe_m) : Json(nullptr);
  json["rpe_rad"] = error.rpe_rad ? Json(*error.rpe_rad) : Json(nullptr);
  return json;
}

std::string Number(double value, const char* format) {
  char text[32];
  std::snprintf(text, sizeof(text), format, value);
  return text;
}

std::string ErrorText(const std::string& name, const TrajectoryError& error) {
  const Similarity2& s = error.shape.truth_from_estimate;
  std::string text = name + ": shape difference " + Number(error.shape.mu, "%.5f") + " over " +
                     std::to_string(error.pairs) + " poses (scale " + Number(s.scale, "%.4f") +
                     (s.rotation.determinant() < 0 ? ", reflected" : "") +
                     ")\n  absolute trajectory error " + Number(error.ate_m, "%.3f") +
                     " m, with scale correction " + Number(error.ate_scaled_m, "%.3f") + " m";
  if (error.rpe_m) {
    text += "; relative pose error " + Number(*error.rpe_m, "%.4f") + " m and " +
            Number(*error.rpe_rad, "%.4f") + " rad";
  }
  return text + '\n';
}

void WritePlot(const TrajectoryFlags& flags, const Trajectory& truth, const TrajectoryError& error,
               const std::optional<TrajectoryError>& odometry) {
  PlotLine trajectory{"ground truth", "#222222", {}};
  for (const Pose2& pose : truth.poses) trajectory.points.emplace_back(pose.x, pose.y);
  std::vector<PlotLine> lines = {trajectory};
  const auto label = [](const std::string& name, const TrajectoryError& of) {
    return name + ", aligned: shape difference " + Number(of.shape.mu, "%.4f");
  };
  if (odometry) lines.push_back({label("odometry", *odometry), "#e08214", odometry->shape.aligned});
  lines.push_back({label("estimate", error), "#2166ac", error.shape.aligned});
  FileReplacer file(flags.plot, flags.force);
  std::ofstream out(file.temporary(), std::ios::binary);
  out << PlotTrajectories(
      std::filesystem::path(flags.estimate).filename().string() + " and ground truth", lines);
  if (!out.flush()) throw UnwritableError(flags.plot, std::strerror(errno), 0);
  file.Commit();
}

int RunEvalTrajectory(const TrajectoryFlags& flags) {
  if (!flags.plot.empty()) {
    for (const std::string& input : {flags.estimate, flags.truth, flags.odometry}) {
      CheckIsNotInput(flags.plot, input, "a trajectory that is evaluated");
    }
    CheckReplacesNoMap(flags.plot);
  }
  const Trajectory truth = ReadTrajectory(flags.truth);
  const TrajectoryError error =
      CompareTrajectories(ReadTrajectory(flags.estimate), truth, flags.association);
  std::optional<TrajectoryError> odometry;
  if (!flags.odometry.empty()) {
    odometry = CompareTrajectories(ReadTrajectory(flags.odometry), truth, flags.association);
  }
  if (!flags.plot.empty()) WritePlot(flags, truth, error, odometry);
  if (flags.json) {
    Json json = ErrorJson(error);
    if (odometry) json["odometry"] = ErrorJson(*odometry);
    std::cout << Dump(json) << '\n';
  } else {
    std::cout << ErrorText("estimate", error);
    if (odometry) std::cout << ErrorText("odometry", *odometry);
  }
  return 0;
}

}  // namespace

void AddEvalTrajectory(CLI::App& eval, Run& run) {
  auto flags = std::make_shared<TrajectoryFlags>();
  CLI::App* command =
      eval.add_subcommand("trajectory", "Evaluate a trajectory against ground truth");
  command
      ->add_option("estimate", flags->estimate,
                   "Estimated trajectory: TUM file, or CSV with columns x and y")
      ->required();
  command->add_option("truth", flags->truth, "Ground-truth trajectory, in the same formats")
      ->required();
  command->add_option("odometry", flags->odometry, "Odometry for comparison, in the same formats");
  CLI::Option* plot =
      command->add_option("--plot", flags->plot, "Plot the aligned trajectories to this SVG file");
  command->add_flag("--force", flags->force, "--plot: overwrite an existing file")->needs(plot);
  command
      ->add_option("--max-difference", flags->association.max_difference_s,
                   "Maximum difference of associated time stamps, in seconds")
      ->check(Finite());
  command->add_flag("--json", flags->json, "Print one JSON object");
  command->footer(
      "Poses are associated by time stamp, or by order if a file has none.\n"
      "Example: waystone eval trajectory odometry.csv poses.csv --plot odometry.svg");
  command->callback([flags, &run] { run = [flags] { return RunEvalTrajectory(*flags); }; });
}

}  // namespace waystone
