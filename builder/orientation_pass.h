// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "builder/build_map.h"
#include "builder/orientation/looked_at_source.h"
#include "builder/orientation/orientation_layer.h"

namespace waystone {

// The orientation layer of a build: looks at the frames of the other layers while these read them,
// and reads those that belong to no other. Sequences are read in the order of their ids. Runs on
// the threads of the calling task arena; not thread-safe.
class OrientationPass {
 public:
  // Both must outlive it.
  OrientationPass(const BuildOptions& options,
                  const std::function<bool(const BuildProgress&)>& progress);

  // Puts sources that look at their frames on the way in the place of the calibrated ones; `first`
  // is the id of the first one's sequence. The sources must outlive the pass.
  void Watch(int64_t first, std::vector<Source*>& sources);
  // Reads a source for this layer alone, as the sequence behind those of the map.
  Sequence Read(const MapData& map, Source& source);
  // Whether there is nothing to look at.
  bool empty() const { return watched_.empty() && !read_; }
  // Adds the layer and its report, if there is anything to look at.
  void Finish(BuildResult& result);

 private:
  const LayerChoice& layers_;
  const std::function<bool(const BuildProgress&)>& progress_;
  OrientationOptions options_;
  OrientationBuilder builder_;
  std::vector<std::unique_ptr<LookedAtSource>> watched_;
  bool read_ = false;
  double look_s_ = 0;
};

// Calibrated sources that belong to no other layer.
std::vector<Source*> DirectionsAlone(const std::vector<std::unique_ptr<Source>>& sources,
                                     const LayerChoice& layers);

// Throws MapError(kBadCamera): the layer was asked for, and nothing is calibrated.
[[noreturn]] void RefuseUncalibrated(size_t sources);

}  // namespace waystone
