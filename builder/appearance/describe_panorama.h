// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "builder/appearance/node_features.h"
#include "builder/frames/layer_builder.h"
#include "core/base/options.h"
#include "core/camera/panorama.h"
#include "core/panorama/fourier_signature.h"
#include "schema/layers/appearance/appearance_layer.h"

namespace waystone {

// What is taken from each panorama.
struct DescribeOptions {
  PanoramaOptions panorama;
  // Half of the default number of rows: features make better use of their share of a node's 20 KB.
  SignatureOptions signature{.rows = 32};
  int trajectory_rows = 64;
  // Features are taken only from whole spheres: a mirror's image or a rig without its upper and
  // lower face gives none.
  NodeFeatureOptions features;
  int image_width = 128;
  int image_quality = 50;

  static constexpr auto Fields(const auto& use) {
    return use(
        OptionField{
            "trajectory_rows", &DescribeOptions::trajectory_rows, Closed(2, 1024), "",
            "Number of rows of the signatures from which odometry and loops are estimated; they "
            "aren't stored in the map. More rows estimate headings and steps more accurately."},
        OptionGroup{"signature", &DescribeOptions::signature},
        OptionGroup{"panorama", &DescribeOptions::panorama},
        OptionGroup{"features", &DescribeOptions::features},
        OptionField{"image_width", &DescribeOptions::image_width, Closed(0, 4096), "px",
                    "Width of the thumbnail stored for each panorama; 0 stores none, otherwise at "
                    "least 16. Wider thumbnails make the map larger."},
        OptionField{
            "image_quality", &DescribeOptions::image_quality, Closed(1, 100), "",
            "WebP quality of that thumbnail. Higher values give clearer, but larger images."});
  }
  void Check() const;  // throws MapError(kBadOptions)
};

// A panorama as the layer needs it.
struct DescribedPanorama : Observation {
  FourierSignature signature;
  FourierSignature trajectory_signature;  // the same with trajectory_rows
  ElevationBand band;                     // that the signature's rows span
  std::optional<LayerMirror> mirror;      // by which the image was unwrapped
  BearingFeatures features;
  std::vector<uint8_t> picture;
};

// Describes one frame; one that isn't a usable panorama is returned with its error. Thread-safe.
std::unique_ptr<DescribedPanorama> DescribePanorama(const Frame& frame,
                                                    const DescribeOptions& options);

}  // namespace waystone
