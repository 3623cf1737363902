// SPDX-License-Identifier: Apache-2.0
#include "cli/files/panorama_file.h"

#include "cli/files/finite.h"
#include "cli/files/map_file.h"
#include "core/base/error.h"
#include "core/camera/cube_faces.h"
#include "core/geometry/angle.h"
#include "core/image/decode.h"
#include "core/image/extensions.h"

namespace waystone {
namespace {

namespace fs = std::filesystem;

ElevationBand BandOfDegrees(const std::vector<double>& top_and_bottom) {
  return {top_and_bottom[0] * kDegree, top_and_bottom[1] * kDegree};
}

// The face's image in a rig's folder; empty when there is none.
cv::Mat ReadFace(const fs::path& folder, CubeFace face) {
  for (const std::string_view extension : ImageExtensions()) {
    const fs::path path = folder / (std::string(NameOf(face)).append(extension));
    if (fs::exists(path)) return DecodeGrey(ReadBytes(path));
  }
  return {};
}

Panorama ReadRig(const fs::path& folder, const PanoramaOptions& options) {
  FaceImages faces;
  for (int i = 0; i < kCubeFaces; ++i) faces[i] = ReadFace(folder, static_cast<CubeFace>(i));
  return FromFaces(faces, options);
}

}  // namespace

void AddPanoramaFlags(CLI::App& command, PanoramaFlags& flags) {
  command
      .add_option("--mirror", flags.mirror,
                  "Catadioptric (mirror) images: centre x and y, inner and outer radius in pixels "
                  "(detected if no values are given)")
      ->expected(4)
      ->check(Finite());
  command
      .add_option(
          "--mirror-band", flags.mirror_band,
          "Elevation at the outer and inner radius of the mirror image in degrees (default 20 -52)")
      ->expected(2)
      ->check(Finite());
  command.add_flag("--counter-clockwise", flags.counter_clockwise,
                   "Mirror images run counter-clockwise");
  command
      .add_option("--band", flags.band,
                  "Range of elevations to use, top and bottom, in degrees (default 34 -34)")
      ->expected(2)
      ->check(Finite());
}

PanoramaOptions PanoramaOptionsOf(const PanoramaFlags& flags) {
  PanoramaOptions options;
  if (!flags.mirror.empty()) {
    options.mirror = {{flags.mirror[0], flags.mirror[1]}, flags.mirror[2], flags.mirror[3]};
  }
  if (!flags.mirror_band.empty()) options.mirror_band = BandOfDegrees(flags.mirror_band);
  options.mirror_clockwise = !flags.counter_clockwise;
  options.Check();
  return options;
}

SignatureOptions SignatureOptionsOf(const PanoramaFlags& flags) {
  SignatureOptions options;
  if (!flags.band.empty()) options.band = BandOfDegrees(flags.band);
  options.Check();
  return options;
}

Panorama ReadPanorama(const fs::path& path, const PanoramaOptions& options) {
  try {
    if (fs::is_directory(path)) return ReadRig(path, options);
    return ToPanorama(DecodeGrey(ReadBytes(path)), options);
  } catch (const MapError& error) {
    if (std::string(error.what()).starts_with(path.string())) throw;
    throw MapError(error.code(), path.string() + ": " + error.what());
  }
}

}  // namespace waystone
