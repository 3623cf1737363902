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

// What the coarse index of a registry knows about a map: for each place, which is a keyframe or a
// panorama, codes of some features that were seen from there. Up to 801 bytes per place.
struct CoarseEntry {
  std::string map_version;  // "sha256:..." of the map's file
  FeatureType feature_type = FeatureType::kSift;
  int working_pixels = 0;         // of the largest keyframe; 0 for a map without
  int keyframes = 0;              // places that are keyframes; those after them are panoramas
  std::vector<uint8_t> codes_of;  // how many codes each place has
  // The codes, place after place, each place's by word.
  std::vector<uint16_t> words;
  std::vector<uint64_t> signatures;

  int places() const { return static_cast<int>(codes_of.size()); }
  int codes() const { return static_cast<int>(words.size()); }
  bool operator==(const CoarseEntry&) const = default;
};

// The largest number of codes per place, and of places per map.
inline constexpr int kMaxPlaceCodes = 80;
inline constexpr int kMaxCoarsePlaces = 1'000'000;

// The entry of a map, from what its file holds. Landmarks and features of planes that most
// keyframes saw come first; a plane's features are distributed among the keyframes that saw it, so
// that neighbours have different ones. Deterministic; thread-safe. Without codes for a map without
// features, and for one of a mirror's images, whose features don't look like those of photos.
CoarseEntry MakeCoarseEntry(const MapIndex& index);

// To and from the bytes of a file. Decoding throws MapError(kFileUnreadable), whose message begins
// with `where`, for bytes that aren't an entry; the memory that it takes is bounded by the bytes.
// Thread-safe.
std::string EncodeCoarseEntry(const CoarseEntry& entry);
CoarseEntry DecodeCoarseEntry(std::string_view bytes, const std::string& where);

// The largest file of an entry.
inline constexpr int64_t kMaxCoarseBytes = 512'000'000;

}  // namespace waystone
