// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>

#include "schema/map_data.h"

namespace waystone {

// Appends the contents of `from` to `to`: sequences, keyframes and planes keep their order and get
// the ids after those of `to`, and the numbering of stretches continues. Sessions, named places and
// poses are added, too; places with the same name become one, and poses are of one frame
// (JoinFrames), as are panoramas (JoinAppearance), which are described alike
// (CheckLayersAreJoinable). Floor plans are added to a map that has none. Of `to`, the name, the
// options and all ids stay; the index and the verdicts of layers that both have no longer hold and
// are removed. Both have the same feature type (WS_CHECK). Throws MapError(kMapDamaged) where the
// ids of `to` leave no room. Thread-safe for different maps, as all here.
void AppendMap(MapData from, MapData& to);

// The ids that sequences of `from` get by AppendMap. Throws as it does.
std::map<SequenceId, SequenceId> AppendedSequences(const MapData& from, const MapData& to);

// Recomputes the poses of panoramas in the map's frame as seen from above: which way is up depends
// on all poses that the map has.
void PutNodesIntoFrame(MapData& map);

}  // namespace waystone
