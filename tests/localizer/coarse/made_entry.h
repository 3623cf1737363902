// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <string>
#include <vector>

#include "localizer/coarse/coarse_entry.h"
#include "tests/core/features/made_descriptors.h"

namespace waystone {

// Descriptors of a place as a map holds them, and as a query sees them: a little different.
struct MadePlace {
  Descriptors rows;
};

// Places of random features near the words' prototypes.
inline std::vector<MadePlace> MadePlaces(FeatureType type, int places, uint64_t seed) {
  Random random(seed);
  const Descriptors prototypes = WordPrototypes(type);
  const int cut = Vocabulary::FirstHalf(type);
  std::vector<MadePlace> made;
  for (int p = 0; p < places; ++p) {
    MadePlace place{Descriptors(prototypes.bytes())};
    for (int i = 0; i < 40; ++i) {
      const uint8_t* first = prototypes.row(random.Below(Vocabulary::kPrototypes));
      const uint8_t* second = prototypes.row(random.Below(Vocabulary::kPrototypes));
      std::vector<uint8_t> row(prototypes.bytes());
      for (int b = 0; b < prototypes.bytes(); ++b) {
        row[b] = (b < cut ? first : second)[b];
        if (type == FeatureType::kSift) {
          row[b] = static_cast<uint8_t>(std::clamp(row[b] + random.Below(17) - 8, 0, 127));
        } else if (random.Below(3) == 0) {
          row[b] ^= static_cast<uint8_t>(1 << random.Below(8));
        }
      }
      place.rows.Append(row.data());
    }
    made.push_back(std::move(place));
  }
  return made;
}

inline CoarseEntry EntryOf(FeatureType type, const std::vector<MadePlace>& places) {
  CoarseEntry entry;
  entry.map_version = "sha256:" + std::string(64, 'a');
  entry.feature_type = type;
  entry.working_pixels = 640 * 480;
  entry.keyframes = static_cast<int>(places.size());
  for (const MadePlace& place : places) {
    entry.codes_of.push_back(static_cast<uint8_t>(place.rows.rows()));
    for (int i = 0; i < place.rows.rows(); ++i) {
      const WordCode code = Vocabulary::Of(type).Encode(place.rows.row(i));
      entry.words.push_back(code.word);
      entry.signatures.push_back(code.signature);
    }
  }
  return entry;
}

}  // namespace waystone
