// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <deque>
#include <vector>

#include "core/base/options.h"
#include "core/features/match.h"
#include "core/two_view/fundamental.h"
#include "schema/map_data.h"

namespace waystone {

struct LandmarkOptions {
  int max_kept = 100;
  int neighbours = 2;
  double on_plane_px = 3.0;
  int lone_per_found = 6;
  int cells = 6;
  double max_crowd = 2;
  MatchOptions match;
  EpipolarOptions epipolar{.max_error_px = 1.5};

  static constexpr auto Fields(const auto& use) {
    using Self = LandmarkOptions;
    return use(
        OptionField{"max_kept", &Self::max_kept, Closed(0, 10'000), "",
                    "Number of landmarks stored per keyframe, at 36 bytes each; more are stored "
                    "where few features are redetected (lone_per_found). More landmarks recognise "
                    "more places; 0 stores planes only."},
        OptionField{"neighbours", &Self::neighbours, Closed(1, 10), "",
                    "Number of keyframes before and after in which a landmark is searched for. "
                    "More keyframes select repeatable features more reliably, but take longer."},
        OptionField{
            "on_plane_px", &Self::on_plane_px, AtLeast(0), "px",
            "A feature within this distance of a plane's feature is not stored as a landmark."},
        OptionField{"lone_per_found", &Self::lone_per_found, Closed(0, 10), "",
                    "Where fewer features than max_kept were redetected, this many others are "
                    "stored for each missing one, since queries find fewer of these. Photos "
                    "without neighbouring photos have no others."},
        OptionField{
            "cells", &Self::cells, Closed(1, 100), "",
            "Number of cells along each side of the image, over which landmarks are spread.",
            OptionUse::kInternal},
        OptionField{"max_crowd", &Self::max_crowd, Closed(1, 1000), "",
                    "A cell is filled beyond this multiple of its even share only when the other "
                    "cells have no more landmarks.",
                    OptionUse::kInternal},
        OptionGroup{"match", &Self::match}, OptionGroup{"epipolar", &Self::epipolar});
  }
  void Check() const;  // throws MapError(kBadOptions)
};

// Chooses the landmarks of keyframes: features that no plane of the map has, spread over the image,
// first those that most of the keyframes before and after show again, consistently with the
// epipolar geometry, then, for each of these that is missing, several of the strongest others.
// Holds the features of a few keyframes and the candidates of all. Deterministic. Not thread-safe.
class LandmarkChooser {
 public:
  explicit LandmarkChooser(const LandmarkOptions& options);

  // The next keyframe. One that starts a stretch isn't compared with those before it.
  void Add(KeyframeId id, const Features& features, bool starts_stretch);

  // Gives the keyframes of a map their landmarks, once all are added and its planes are final.
  void Finish(MapData& map);

 private:
  // A keyframe whose neighbours are still to come.
  struct Recent {
    KeyframeId id;
    Features features;
    std::vector<int> found;  // of each feature: neighbours that show it as well
  };
  struct Candidate {
    Keypoint keypoint;
    int row = 0;  // in Candidates::codes
    int found = 0;
  };
  // What may become landmarks of a keyframe, best first.
  struct Candidates {
    KeyframeId id;
    std::vector<Candidate> ranked;
    Descriptors codes;
  };

  void Compare(Recent& before, Recent& now) const;
  void Retire();

  LandmarkOptions options_;
  std::deque<Recent> recent_;
  std::vector<Candidates> candidates_;  // by keyframe, ascending
};

}  // namespace waystone
