// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <string>
#include <vector>

#include "core/camera/panorama.h"
#include "core/panorama/fourier_signature.h"

namespace waystone {

// What commands that take panoramas ask about them; angles in degrees, as people enter them.
struct PanoramaFlags {
  std::vector<double> mirror;       // x, y, inner and outer radius, px; empty: detected
  std::vector<double> mirror_band;  // elevations at the outer and the inner radius
  std::vector<double> band;         // elevations of the signature's band, top and bottom
  bool counter_clockwise = false;   // azimuth in the mirror's image
};

// Adds --mirror, --mirror-band, --band and --counter-clockwise.
void AddPanoramaFlags(CLI::App& command, PanoramaFlags& flags);

PanoramaOptions PanoramaOptionsOf(const PanoramaFlags& flags);
SignatureOptions SignatureOptionsOf(const PanoramaFlags& flags);

// A panorama from a file (equirectangular, a strip of it, or a mirror image) or from a folder with
// the faces of a rig: front, right, back, left and, if present, up and down, in any format. Throws
// MapError, whose message begins with the path.
Panorama ReadPanorama(const std::filesystem::path& path, const PanoramaOptions& options);

}  // namespace waystone
