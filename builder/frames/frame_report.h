// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "builder/sources/source.h"

namespace waystone {

// How many of a map's own images it finds again.
struct OwnImages {
  int asked = 0;
  int found = 0;

  // 99 % of them.
  bool AreFound() const { return 100 * found >= 99 * asked; }
};

// What became of the frames that a layer observed. Not thread-safe.
struct FrameReport {
  int frames = 0;
  int skipped = 0;                         // of them, those that the layer can't use
  std::vector<std::string> skipped_names;  // "rgb/000120.jpg: cause", the first 20 of them
  double decode_s = 0;                     // summed over threads
  double observe_s = 0;                    // summed over threads
  double add_s = 0;                        // of the sequential part
  OwnImages own;                           // of a sample; set by BuildMap

  // One more frame; `error` is empty for one that can be used.
  void Count(const FrameInfo& info, const std::string& error);
  // The frames of another sequence.
  void Append(const FrameReport& other);
};

}  // namespace waystone
