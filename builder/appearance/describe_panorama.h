// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "builder/appearance/node_features.h"
#include "builder/frames/layer_builder.h"
#include "core/camera/panorama.h"
#include "core/panorama/fourier_signature.h"

namespace waystone {

// What is taken from each panorama.
struct DescribeOptions {
  PanoramaOptions panorama;
  // Half of the rows that a signature has by itself: what they take of a node's 20 KB, features use
  // better.
  SignatureOptions signature{.rows = 32};
  // Rows of the signatures that odometry and loops are measured by, 1 to 1024; the map doesn't keep
  // them. More measure headings and steps more finely.
  int trajectory_rows = 64;
  // Features are taken from whole spheres alone: a mirror's image or a rig without its upper and
  // lower face gives none.
  NodeFeatureOptions features;
  // Width of the smaller picture that is kept for people, px, 16 to 4096; 0 keeps none. Wider ones
  // make the map larger.
  int image_width = 128;
  // JPEG quality of that picture, 1 to 100. More is clearer and larger.
  int image_quality = 50;

  void Check() const;  // throws MapError(kBadOptions)
};

// A panorama as the layer needs it.
struct DescribedPanorama : Observation {
  FourierSignature signature;
  FourierSignature trajectory_signature;  // the same with trajectory_rows
  ElevationBand band;                     // that the signature's rows span
  BearingFeatures features;
  std::vector<uint8_t> jpeg;
};

// Describes one frame; one that is no usable panorama comes with its error. Thread-safe.
std::unique_ptr<DescribedPanorama> DescribePanorama(const Frame& frame,
                                                    const DescribeOptions& options);

}  // namespace waystone
