// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "builder/appearance/node_features.h"
#include "builder/sources/source.h"
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
struct DescribedFrame {
  FrameInfo info;
  FourierSignature signature;
  FourierSignature trajectory_signature;  // the same with way_rows
  ElevationBand band;                     // that the signature's rows span
  BearingFeatures features;
  std::vector<uint8_t> jpeg;
  std::string error;      // set when it can't be used; the rest is empty then
  double decode_s = 0;    // on its own thread
  double describe_s = 0;  // panorama, signature, features and picture
};

// Whether a source's frames look like panoramas: a rig, or images twice as wide as high (to 2 %).
// A mirror's images look like any others, so that one has to say that they are panoramas.
bool LooksPanoramic(const Source& source);

// Decodes a source's frames and describes them, several at a time on the threads of the calling
// task arena, with a bounded number in memory. `consume` gets them one at a time and in order, from
// any of these threads; no more frames are read once it returns false.
void DescribeFrames(Source& source, const DescribeOptions& options,
                    const std::function<bool(DescribedFrame)>& consume);

}  // namespace waystone
