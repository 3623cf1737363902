// SPDX-License-Identifier: Apache-2.0
#include <cstdio>
#include <iostream>
#include <memory>

#include "api/json.h"
#include "cli/commands/commands.h"
#include "cli/files/panorama_file.h"
#include "core/base/error.h"
#include "core/base/text.h"
#include "core/geometry/angle.h"
#include "core/panorama/visual_compass.h"

namespace waystone {
namespace {

struct CompassFlags {
  std::vector<std::string> images;
  bool json = false;
  PanoramaFlags panorama;
};

Json HeadingJson(const std::string& image, const std::string& first,
                 const CompassHeading& heading) {
  Json json = {{"image", image},
               {"against", first},
               {"heading_deg", heading.heading_rad * kDegreesPerRadian},
               {"deviation_deg", heading.sigma_rad * kDegreesPerRadian},
               {"sharpness", heading.sharpness},
               {"runner_up_deg", heading.runner_up_rad * kDegreesPerRadian},
               {"motion", nullptr}};
  if (heading.motion) {
    json["motion"] = {{"direction_deg", heading.motion->direction_rad * kDegreesPerRadian},
                      {"deviation_deg", heading.motion->sigma_rad * kDegreesPerRadian}};
  }
  return json;
}

// "b.jpg: +12.30 deg +- 0.40 (runner-up -170, sharpness 0.210), moved towards +31 +- 5"
std::string HumanLine(const std::string& image, const CompassHeading& heading) {
  char text[200];
  std::snprintf(text, sizeof(text), "%+.2f deg +- %.2f (runner-up %+.0f, sharpness %.3f)",
                heading.heading_rad * kDegreesPerRadian, heading.sigma_rad * kDegreesPerRadian,
                heading.runner_up_rad * kDegreesPerRadian, heading.sharpness);
  std::string line = Printable(image) + ": " + text;
  if (!heading.motion) return line;
  std::snprintf(text, sizeof(text), ", moved towards %+.0f +- %.0f",
                heading.motion->direction_rad * kDegreesPerRadian,
                heading.motion->sigma_rad * kDegreesPerRadian);
  return line + text;
}

void CheckSameBand(const std::string& image, const ElevationBand& band,
                   const ElevationBand& first) {
  if (band == first) return;
  throw MapError(ErrorCode::kBadImage,
                 image + " covers elevations from " +
                     std::to_string(band.top_rad * kDegreesPerRadian) + " to " +
                     std::to_string(band.bottom_rad * kDegreesPerRadian) +
                     " degrees, unlike the first panorama; set --band to a range covered by both");
}

int RunCompass(const CompassFlags& flags) {
  if (flags.images.size() < 2) {
    throw MapError(ErrorCode::kUsage, "1 panorama given; the compass needs at least 2");
  }
  const PanoramaOptions options = PanoramaOptionsOf(flags.panorama);
  const SignatureOptions signature = SignatureOptionsOf(flags.panorama);
  CompassOptions compass;
  const Panorama reference = ReadPanorama(flags.images[0], options);
  compass.band = UsedBand(reference, signature);
  const FourierSignature first = Signature(reference, signature);
  for (size_t i = 1; i < flags.images.size(); ++i) {
    const std::string& image = flags.images[i];
    const Panorama panorama = ReadPanorama(image, options);
    CheckSameBand(image, UsedBand(panorama, signature), compass.band);
    const FourierSignature other = Signature(panorama, signature);
    const CompassHeading heading = RelativeHeading(first, other, compass);
    std::cout << (flags.json ? Dump(HeadingJson(image, flags.images[0], heading))
                             : HumanLine(image, heading))
              << std::endl;
  }
  return 0;
}

}  // namespace

void AddCompass(CLI::App& app, Run& run) {
  auto flags = std::make_shared<CompassFlags>();
  CLI::App* command =
      app.add_subcommand("compass", "Estimate each panorama's heading relative to the first");
  command->add_option("images", flags->images, "Panoramas, mirror images or rig folders")
      ->required();
  command->add_flag("--json", flags->json, "Print one JSON object per panorama");
  AddPanoramaFlags(*command, flags->panorama);
  command->footer(
      "Headings and directions are in degrees, counter-clockwise seen from above. Directions are\n"
      "relative to the forward direction of the first panorama (its middle column).\n"
      "Example: waystone compass a.jpg b.jpg c.jpg --json");
  command->callback([flags, &run] { run = [flags] { return RunCompass(*flags); }; });
}

}  // namespace waystone
