// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "builder/sources/source.h"
#include "core/features/features.h"

// Data with places that were seen twice, for which the right map images of each query are known.
namespace waystone::bench {

struct RecallSet {
  std::string name;
  std::vector<std::filesystem::path> map;      // images in their order: frame i is map[i]
  std::vector<std::filesystem::path> queries;  // of places that the map shows
  // Images of places that look like the map's but are elsewhere.
  std::vector<std::filesystem::path> look_alikes;
  // Whether the query may be answered with the map's frame.
  std::function<bool(int query, int frame)> is_right;
};

// The images of a set's map as a source; a new one each time.
std::unique_ptr<Source> OpenRecallMap(const RecallSet& set);

// corridor, kitchen, church, pavilion-midday, -sunset, -night, and tower-FLOOR for each floor:
// those that `data` has. Throws MapError(kFileUnreadable) where it has none.
std::vector<RecallSet> ReadRecallSets(const std::filesystem::path& data);

// Photos by the four level cameras of a rig at places some metres apart (OpenOrientedSet, with
// poses). The map has all photos of every second place, one camera after the other; queries are one
// photo of each other place, by the cameras in turn.
RecallSet ReadRigPhotos(const std::filesystem::path& folder);

// The set with its roles exchanged: a map of the queries, queried with at most `max_queries` of the
// images that the map was made from, every n-th.
RecallSet Exchanged(const RecallSet& set, int max_queries);

// The features of each image, extracted in parallel.
std::vector<Features> ExtractAll(const std::vector<std::filesystem::path>& images,
                                 const FeatureOptions& options);

// At most `count` of the queries of the sets of other places, every n-th.
std::vector<std::filesystem::path> ChooseForeign(const std::vector<RecallSet>& sets,
                                                 const RecallSet& own, int count);

}  // namespace waystone::bench
