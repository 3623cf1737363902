// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "core/features/features.h"
#include "localizer/coarse/coarse_entry.h"
#include "localizer/coarse/coarse_query.h"

// Maps with queries whose right places in the map are known, for the coarse index.
namespace waystone::bench {

struct CollectionQuery {
  std::vector<CoarseDescriptors> descriptors;
  std::vector<int> places;  // of the scene's entry, that show what the query shows
  bool localized = false;   // by the map itself; others are lost whatever is proposed
};

struct CollectionScene {
  std::string name;
  std::string kind;  // "rendered", "panoramas", "photos"
  CoarseEntry entry;
  Descriptors pool;  // descriptors of the map, from which others are made
  std::vector<CollectionQuery> queries;
};

// A rendered building with a map of a walk through it, queried from steps aside, half of the time
// under other light; an odd seed's storey above is a map, too, without queries.
std::vector<CollectionScene> RenderBuilding(int seed, FeatureType type);

// A rendered flat with a map of panoramas of one visit, queried with those of another one.
CollectionScene RenderFlatScene(int seed, FeatureType type);

// Photos of real places (ReadRecallSets), those of one map together.
std::vector<CollectionScene> ReadRealScenes(const std::filesystem::path& data, FeatureType type);

// All features of rendered buildings and flats, others than above, from which words are learned.
Descriptors RenderedDescriptors(FeatureType type, int scenes);

// A part of an entry as an entry.
CoarseEntry PlacesOf(const CoarseEntry& entry, int from, int to);

}  // namespace waystone::bench
