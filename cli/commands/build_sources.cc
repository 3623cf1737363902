// SPDX-License-Identifier: Apache-2.0
#include "cli/commands/build_sources.h"

#include <algorithm>
#include <iostream>

#include "builder/layer_choice.h"
#include "cli/files/finite.h"
#include "cli/output/printable_output.h"
#include "cli/output/progress.h"
#include "cli/system/signals.h"
#include "core/base/text.h"

namespace waystone {
namespace {

// Appended to an announcement; empty for the plane layer.
std::string LayerText(const Source& source, const LayerChoice& layers) {
  std::string text;
  for (const LayerKind layer : ChooseLayers(source, layers)) {
    if (layer == LayerKind::kAppearance) text += ", panoramas (appearance layer)";
    if (layer == LayerKind::kOrientation) text += ", calibrated (orientation layer)";
  }
  return text;
}

}  // namespace

void AddSourceFlags(CLI::App& command, const std::string& kinds, SourceFlags& flags) {
  command.add_option("sources", flags.paths, kinds)->required();
  command.add_option("--every", flags.options.every, "Use every N-th frame")->capture_default_str();
  command.add_option("--from", flags.options.from, "Index of the first frame, starting at 0")
      ->capture_default_str();
  command.add_option("--to", flags.to, "Index of the last frame, inclusive")
      ->check(CLI::NonNegativeNumber);
  command.add_option("--camera", flags.camera,
                     "Camera calibration: OpenCV, ROS, Kalibr or COLMAP file; required by the "
                     "orientation layer");
}

void AddThreadsFlag(CLI::App& command, int& threads) {
  command
      .add_option("--threads", threads,
                  "Number of threads, 0 for one per core; does not affect the map")
      ->capture_default_str();
}

void AddPoseFlags(CLI::App& command, PoseFlags& flags) {
  command.add_option(
      "--poses", flags.file,
      "Poses of the images: TUM, KITTI, EuRoC, COLMAP (images.txt, images.bin), g2o, "
      "nav_msgs/Odometry as CSV, or CSV; with --camera, queries are answered with their pose");
  command.add_option("--frame", flags.frame, "Name of the frame of the poses")
      ->needs("--poses")
      ->capture_default_str();
  command.add_option("--unit", flags.unit, "Unit of the poses: metres or unknown")
      ->needs("--poses")
      ->capture_default_str();
  command
      .add_option("--scale-by", flags.scale_by,
                  "Two images and the distance of their cameras in metres: A B METRES. Scales "
                  "poses of unknown unit")
      ->needs("--poses")
      ->expected(3);
  command
      .add_option("--body-from-camera", flags.body_from_camera,
                  "Pose of the camera on the body that the poses refer to: \"x y z qx qy qz qw\"")
      ->needs("--poses");
  command
      .add_option("--max-pose-gap", flags.max_gap_s,
                  "Longest gap between two poses to interpolate across, in seconds")
      ->needs("--poses")
      ->check(Finite())
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
}

void AddBuildOutputFlags(CLI::App& command, BuildOutputFlags& flags) {
  command.add_flag("--json", flags.json, "Print the summary as one JSON object");
  command.add_flag("--quiet", flags.quiet, "Print errors only");
  command.add_option("--progress", flags.progress, "Progress on stderr: auto, none or json")
      ->capture_default_str();
}

SourceOptions SourceOptionsOf(const SourceFlags& flags) {
  SourceOptions options = flags.options;
  if (flags.to >= 0) options.to = flags.to;
  if (!flags.camera.empty()) options.camera_file = flags.camera;
  options.Check();
  return options;
}

std::vector<std::unique_ptr<Source>> OpenSources(const SourceFlags& flags,
                                                 const LayerChoice& layers, bool quiet) {
  const SourceOptions options = SourceOptionsOf(flags);
  std::vector<std::unique_ptr<Source>> sources;
  for (const std::string& path : flags.paths) {
    sources.push_back(OpenSource(path, options));
    if (quiet) continue;
    std::cerr << Printable(path) << ": " << sources.back()->Announcement()
              << LayerText(*sources.back(), layers) << '\n';
  }
  return sources;
}

BuildResult BuildWithProgress(const std::vector<std::unique_ptr<Source>>& sources,
                              const BuildOptions& options, const BuildOutputFlags& flags,
                              const std::optional<GivenPoses>& poses, BuiltFeatures features) {
  ProgressMeter meter(RawErrors(), ProgressStyleByName(flags.progress, flags.quiet),
                      ColoursWelcome());
  const auto show = [&meter](const BuildProgress& now) {
    meter.Update({now.stage, now.done, now.total,
                  now.panoramas > 0 ? std::to_string(now.panoramas) + " panoramas"
                                    : std::to_string(now.keyframes) + " keyframes, " +
                                          std::to_string(now.planes) + " planes"});
    return !Interrupted();
  };
  return BuildMap(sources, options, show, poses, features);
}

bool HasPlanesOrLandmarks(const MapData& map) {
  return !map.planes.empty() || std::ranges::any_of(map.keyframes, [](const Keyframe& keyframe) {
    return keyframe.landmarks.size() > 0;
  });
}

std::string NoPlanesText(const MapData& map) {
  return "no plane or landmark found in " + std::to_string(map.keyframes.size()) +
         " keyframes; nothing was written. Record textured walls or floors while moving sideways, "
         "or try --set features.max_features=2000";
}

int ReportNoPlanes(const MapData& map) {
  std::cerr << "waystone: " << NoPlanesText(map) << '\n';
  return kBelowQualityGate;
}

}  // namespace waystone
