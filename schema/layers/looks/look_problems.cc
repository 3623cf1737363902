// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <optional>
#include <string>
#include <utility>

#include "schema/layers/layer_problems.h"

namespace waystone {
namespace {

// The rules that hold for both kinds of rows. `size` is that of what the features belong to;
// nothing where it isn't in the map.
void FindRowProblems(const MapData& map, const std::string& where, const std::string& owner,
                     std::optional<size_t> size, SequenceId sequence,
                     const std::vector<FeatureLooks>& looks, std::vector<MapProblem>& problems) {
  if (!HasSequence(map, sequence)) {
    problems.push_back({where, "there is no sequence " + std::to_string(sequence.value)});
  }
  if (!size) {
    problems.push_back({where, "there is no " + owner});
  } else if (*size != looks.size()) {
    problems.push_back({where, std::to_string(looks.size()) + " features; the " + owner + " has " +
                                   std::to_string(*size)});
  }
  const bool too_many =
      std::ranges::any_of(looks, [](const FeatureLooks& one) { return one.found > one.looked; });
  if (too_many) problems.push_back({where, "a feature was found more often than looked for"});
}

template <class Rows, class IdType>
const typename Rows::value_type* FindById(const Rows& rows, IdType id) {
  const auto found = std::ranges::lower_bound(rows, id, {}, &Rows::value_type::id);
  return found != rows.end() && found->id == id ? &*found : nullptr;
}

std::string Where(const char* table, int64_t of, SequenceId sequence) {
  return std::string(table) + " " + std::to_string(of) + "/" + std::to_string(sequence.value);
}

}  // namespace

void FindLookProblems(const MapData& map, std::vector<MapProblem>& problems) {
  std::pair<PlaneId, SequenceId> last_plane;
  for (const PlaneLooks& one : map.looks.planes) {
    const std::string where = Where("plane_looks", one.plane.value, one.sequence);
    const std::pair now(one.plane, one.sequence);
    if (!(last_plane < now)) {
      problems.push_back({where, "rows must be unique and sorted by (plane, sequence)"});
    }
    last_plane = now;
    const Plane* plane = FindById(map.planes, one.plane);
    FindRowProblems(map, where, "plane " + std::to_string(one.plane.value),
                    plane ? std::optional(plane->features.size()) : std::nullopt, one.sequence,
                    one.features, problems);
  }
  std::pair<KeyframeId, SequenceId> last_keyframe;
  for (const LandmarkLooks& one : map.looks.landmarks) {
    const std::string where = Where("landmark_looks", one.keyframe.value, one.sequence);
    const std::pair now(one.keyframe, one.sequence);
    if (!(last_keyframe < now)) {
      problems.push_back({where, "rows must be unique and sorted by (keyframe, sequence)"});
    }
    last_keyframe = now;
    const Keyframe* keyframe = FindById(map.keyframes, one.keyframe);
    FindRowProblems(map, where, "keyframe " + std::to_string(one.keyframe.value),
                    keyframe ? std::optional(keyframe->landmarks.positions.size()) : std::nullopt,
                    one.sequence, one.landmarks, problems);
  }
}

}  // namespace waystone
