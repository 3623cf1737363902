// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "core/features/features.h"
#include "core/search/words.h"
#include "localizer/index/map_index.h"

namespace waystone {

// What the coarse index of a registry knows of a map: for each place, which is a keyframe or a
// panorama, codes of some features that were seen from there. Up to 801 bytes a place.
struct CoarseEntry {
  std::string map_version;  // "sha256:..." of the map's file
  FeatureType feature_type = FeatureType::kSift;
  int working_pixels = 0;         // of the largest keyframe; 0 for a map without
  int keyframes = 0;              // places that are keyframes; the others, behind, are panoramas
  std::vector<uint8_t> codes_of;  // how many codes each place has
  // Of the codes, place after place, each place's by word.
  std::vector<uint16_t> words;
  std::vector<uint64_t> signatures;

  int places() const { return static_cast<int>(codes_of.size()); }
  int codes() const { return static_cast<int>(words.size()); }
  bool operator==(const CoarseEntry&) const = default;
};

// At most so many codes a place, and places a map.
inline constexpr int kMaxPlaceCodes = 80;
inline constexpr int kMaxCoarsePlaces = 1'000'000;

// The entry of a map, from what its file holds. Landmarks and features of planes that most
// keyframes saw come first; a plane's features are dealt out to the keyframes that saw it, so that
// neighbours know different ones. Deterministic. Without codes for a map without features, and for
// one of a mirror's images, whose features don't look like those of photos.
CoarseEntry MakeCoarseEntry(const MapIndex& index);

// As a file, and back. Reading throws MapError(kFileUnreadable), whose message begins with `where`,
// for bytes that are no entry; the memory that it takes is bounded by the bytes.
std::string EncodeCoarseEntry(const CoarseEntry& entry);
CoarseEntry DecodeCoarseEntry(std::string_view bytes, const std::string& where);

// The largest file of an entry.
inline constexpr int64_t kMaxCoarseBytes = 512'000'000;

}  // namespace waystone
