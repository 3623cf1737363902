// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <string>

#include "builder/planes/keyframe_selector.h"
#include "builder/sources/source.h"
#include "core/features/features.h"

namespace waystone {

// A frame after the parallel part of a build.
struct WorkedFrame {
  ExtractedFrame frame;
  std::string error;     // set when it could not be decoded; it has no features then
  double decode_s = 0;   // on its own thread
  double extract_s = 0;  // features and the smaller picture
};

// What is taken from each frame.
struct ExtractFramesOptions {
  FeatureOptions features;
  int thumbnail_width = 0;  // px; 0 leaves the smaller pictures out
};

// Decodes a source's frames and extracts their features, several frames at a time on the threads of
// the calling task arena, with a bounded number of frames in memory. `consume` gets them one at a
// time, in order, from any of these threads, while others are being worked on; no more frames are
// read once it returns false. What it throws leaves this function.
void ExtractFrames(Source& source, const ExtractFramesOptions& options,
                   const std::function<bool(WorkedFrame)>& consume);

}  // namespace waystone
