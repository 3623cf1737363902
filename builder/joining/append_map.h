// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>

#include "schema/map_data.h"

namespace waystone {

// Adds what `from` holds to `to`, behind it: sequences, keyframes and planes keep their order and
// get the ids after those of `to`, and stretches count on. Sessions, named places and poses are
// added, too; places of one name become one, and poses are of one frame (JoinFrames), as are
// panoramas (JoinAppearance), which are described alike (CheckLayersAreJoinable). Floor plans are
// added to a map that has none. Of `to`, the name, the options and all ids stay; the index and the
// verdicts of layers that both have no longer hold and go. Both are of one feature type (WS_CHECK).
// Throws MapError(kMapDamaged) where the ids of `to` leave no room.
void AppendMap(MapData from, MapData& to);

// The ids that sequences of `from` get by AppendMap. Throws as it does.
std::map<SequenceId, SequenceId> AppendedSequences(const MapData& from, const MapData& to);

// Gives panoramas their poses in the map's frame as seen from above: which way is up there depends
// on all poses that the map has.
void PutNodesIntoFrame(MapData& map);

}  // namespace waystone
