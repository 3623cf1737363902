// SPDX-License-Identifier: Apache-2.0
#include "cli/commands/build_flags.h"

#include <algorithm>

#include "cli/commands/commands.h"
#include "cli/commands/settings.h"
#include "core/base/error.h"
#include "core/base/text.h"

namespace waystone {
namespace {

// BuildOptions has the size for SIFT, which also looks at an image of twice the size where the
// plain one yields too few features; ORB and AKAZE don't, and find fewer in so few pixels
// (docs/design.md).
int DefaultWorkingPixels(FeatureType type) {
  const int of_sift = BuildOptions{}.features.working_pixels;
  return type == FeatureType::kSift ? of_sift : 2 * of_sift;
}

}  // namespace

void AddBuildFlags(CLI::App& command, BuildFlags& flags) {
  AddPoseFlags(command, flags.poses);
  command.add_option("--features", flags.features, "Feature type: sift, orb or akaze")
      ->capture_default_str();
  command
      .add_option("--max-features", flags.build.features.max_features, "Maximum features per image")
      ->capture_default_str();
  command
      .add_option(
          "--landmarks", flags.build.planes.landmarks.max_kept,
          "Features per keyframe beside the planes, more where few were found again; 0 keeps "
          "planes only")
      ->capture_default_str();
  command
      .add_option("--layers", flags.layers,
                  "Comma-separated layers: planes, appearance (panoramas), orientation (rigs, "
                  "panoramas, calibrated cameras); auto chooses by the type of the source, with "
                  "orientation for rigs and panoramas only")
      ->capture_default_str();
  command
      .add_option(
          "--max-loss", flags.build.appearance.redundancy.max_loss,
          "Drop redundant panoramas whose loss of information is at most this share, 0 to 1")
      ->capture_default_str();
  command
      .add_option(
          "--node-features", flags.build.appearance.describe.features.max_kept,
          "Features stored per panorama, 36 bytes each, for verification and for localizing "
          "photos; 0 stores none")
      ->capture_default_str();
  AddPanoramaFlags(command, flags.panorama);
  command.add_flag("--no-images", flags.no_images, "Do not store keyframe images in the map");
  AddSetFlag(command, flags.settings);
}

BuildOptions MakeBuildOptions(const BuildFlags& flags, const std::string& map_name) {
  BuildOptions options = flags.build;
  options.map_name = map_name;
  options.features.type = FeatureTypeByName(flags.features);
  options.images = !flags.no_images;
  options.layers = LayerChoiceByNames(flags.layers);
  options.appearance.describe.panorama = PanoramaOptionsOf(flags.panorama);
  options.appearance.describe.signature.band = SignatureOptionsOf(flags.panorama).band;
  ApplySettings(flags.settings, options);
  const bool sized = std::ranges::any_of(flags.settings, [](const std::string& setting) {
    return setting.starts_with("features.working_pixels=");
  });
  if (!sized) options.features.working_pixels = DefaultWorkingPixels(options.features.type);
  options.Check();
  return options;
}

std::optional<GivenPoses> PosesOf(const BuildFlags& flags) {
  if (flags.poses.file.empty()) return std::nullopt;
  return ReadGivenPoses(flags.poses, static_cast<int>(flags.sources.paths.size()));
}

bool CanAnswer(const BuildResult& result) {
  const bool directions_alone = result.map.orientation && !result.report.planes;
  return HasPlanesOrLandmarks(result.map) || result.map.appearance || directions_alone;
}

std::vector<std::string> GivenOptions(const std::vector<const CLI::Option*>& known) {
  std::vector<std::string> given;
  for (const CLI::Option* option : known) {
    if (option->count() == 0) continue;
    const std::string name = option->get_name();
    const bool several = option->get_items_expected_min() > 1;
    if (option->get_items_expected_max() > 0 && !several) {
      for (const std::string& value : option->results()) given.push_back(name + "=" + value);
      continue;
    }
    given.push_back(name);
    if (several) given.insert(given.end(), option->results().begin(), option->results().end());
  }
  return given;
}

BuildFlags ParseBuildFlags(const std::vector<std::string>& sources,
                           const std::vector<std::string>& options) {
  BuildFlags flags;
  CLI::App app("", "build");
  AddSourceFlags(app, kBuildSources, flags.sources);
  AddBuildFlags(app, flags);
  std::vector<std::string> words = options;
  words.emplace_back("--");
  words.insert(words.end(), sources.begin(), sources.end());
  std::ranges::reverse(words);  // the order that CLI11 expects
  try {
    app.parse(std::move(words));
  } catch (const CLI::Error& error) {
    throw MapError(ErrorCode::kUsage, "the job has options that waystone build does not accept: " +
                                          Printable(error.what()));
  }
  return flags;
}

}  // namespace waystone
