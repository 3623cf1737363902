// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "core/base/ids.h"

// Which of a map's features later walks looked for: how often each should have been in their
// images, and how often it was. FORMAT.md says how each field is stored.
namespace waystone {

// The largest count for one feature in one sequence.
inline constexpr int kMaxLooks = 255;

// Images of a sequence that a feature should have been found in, and those in which it was.
struct FeatureLooks {
  uint8_t looked = 0;
  uint8_t found = 0;  // at most looked

  bool operator==(const FeatureLooks&) const = default;
};

// Looks for the features of a plane in the images of one sequence.
struct PlaneLooks {
  PlaneId plane;
  SequenceId sequence;
  std::vector<FeatureLooks> features;  // as many as the plane has

  bool operator==(const PlaneLooks&) const = default;
};

// Looks for the landmarks of a keyframe in the images of another sequence.
struct LandmarkLooks {
  KeyframeId keyframe;
  SequenceId sequence;
  std::vector<FeatureLooks> landmarks;  // as many as the keyframe has

  bool operator==(const LandmarkLooks&) const = default;
};

struct Looks {
  std::vector<PlaneLooks> planes;        // ordered by plane and sequence, each pair once
  std::vector<LandmarkLooks> landmarks;  // ordered by keyframe and sequence, each pair once

  bool empty() const { return planes.empty() && landmarks.empty(); }
  bool operator==(const Looks&) const = default;
};

}  // namespace waystone
