// SPDX-License-Identifier: Apache-2.0
#include "schema/file/map_problems.h"

#include <string>

#include "core/base/error.h"
#include "schema/layers/layer_problems.h"
#include "schema/layers/layers.h"

namespace waystone {
namespace {

void FindSequenceProblems(const MapData& map, std::vector<MapProblem>& problems) {
  CheckIds("sequences", map.sequences, problems);
  for (const Sequence& sequence : map.sequences) {
    const std::string where = "sequences " + std::to_string(sequence.id.value);
    if (sequence.skipped < 0 || sequence.skipped > sequence.frames) {
      problems.push_back({where, std::to_string(sequence.skipped) + " of " +
                                     std::to_string(sequence.frames) + " frames skipped"});
    }
    if (!sequence.camera) continue;
    try {
      CheckCamera(*sequence.camera);
    } catch (const MapError& error) {
      problems.push_back({where, error.what()});
    }
  }
}

}  // namespace

std::vector<MapProblem> FindMapProblems(const MapData& map) {
  std::vector<MapProblem> problems;
  FindSequenceProblems(map, problems);
  for (const StoredLayer& layer : StoredLayers()) layer.find_problems(map, problems);
  return problems;
}

}  // namespace waystone
