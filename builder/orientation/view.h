// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "builder/orientation/options.h"
#include "builder/sources/rig_source.h"
#include "builder/sources/source.h"
#include "core/base/ids.h"

namespace waystone {

// One moment of a calibrated sequence before its images are read.
struct OrientationMoment {
  FrameInfo info;
  // The images, one a camera of the rig (CV_8UC1). Any thread; throws MapError.
  std::function<std::vector<cv::Mat>()> load;
};

// A calibrated sequence: a rig, a panorama or one camera.
struct OrientationSequence {
  SequenceId id;
  Rig rig;
  // The next moment, nothing at the end. One thread at a time.
  std::function<std::optional<OrientationMoment>()> next;
};

// The rig that takes a source's frames.
struct SourceRig {
  Rig rig;
  bool panorama = false;  // frames are whole panoramas, which become the rig's faces

  // The rig's images of what EncodedFrame::Load gave.
  std::vector<cv::Mat> ImagesOf(const std::vector<cv::Mat>& loaded) const;
};

// The faces of a rig; six faces, a quarter as wide, of panoramas (an equirectangular camera, or
// none and exactly twice as wide as high); or the one camera. Nothing for a source without a
// calibration.
std::optional<SourceRig> RigOfSource(const Source& source);

// All moments of a rig's folder. The sequence is copied.
OrientationSequence SequenceOf(SequenceId id, RigSequence sequence);
// All frames of a calibrated source; the source must outlive what it gives. Throws
// MapError(kBadCamera) for a source without a calibration.
OrientationSequence SequenceOf(SequenceId id, Source& source);

// What the images of one moment give: the part of the work that needs no other frame.
struct OrientationView {
  FrameInfo info;
  std::string error;  // set when an image could not be read; nothing was found then
  std::vector<GreatCircle> lines;
  ManhattanFrame frame;  // axes numbered anyhow until they are followed
  BearingFeatures features;
  cv::Mat thumbnail;  // of the first camera; empty when none is wanted
};

using OrientationViewPtr = std::shared_ptr<const OrientationView>;

// Reads and looks. Bad images are told in `error`. Deterministic; thread-safe.
OrientationView LookAt(const Rig& rig, const OrientationMoment& moment,
                       const OrientationOptions& options);
// The same for images that are read already. Throws MapError(kBadImage) for one that hasn't its
// camera's size.
OrientationView LookAt(const Rig& rig, const FrameInfo& info, std::span<const cv::Mat> images,
                       const OrientationOptions& options);

}  // namespace waystone
