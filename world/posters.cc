// SPDX-License-Identifier: Apache-2.0
#include "world/posters.h"

#include <algorithm>
#include <cmath>

#include "core/base/random.h"
#include "world/texture.h"

namespace waystone {
namespace {

// Seeds of different things must differ; these constants separate them.
constexpr uint64_t kPlaceSeed = 0x706C616365ULL;
constexpr uint64_t kPictureSeed = 0x7069637475ULL;
constexpr uint64_t kAlikeSeed = 0x616C696B65ULL;
constexpr uint64_t kRepeatedPicture = 0;
constexpr uint64_t kFirstLetter = 1;  // pictures 1 to 26 are the plan's letters
constexpr uint64_t kFirstUnique = 1000;
constexpr double kMiddleHeightM = 1.5;  // where people hang pictures: the middle at eye height

// Consecutive cells of a face, from `first` on, where the wall is complete from floor to ceiling.
struct Run {
  int first = 0;
  int count = 0;
  bool has_letter = false;
};

std::vector<Run> WholeRuns(const WorldFace& face) {
  std::vector<Run> runs;
  bool open = false;
  for (const FaceSpan& span : face.spans) {
    const bool whole = span.top_m <= 0.0 && span.bottom_m >= face.size_m.y();
    if (whole && !open) runs.push_back({span.cell, 0, false});
    open = whole;
    if (!whole) continue;
    ++runs.back().count;
    runs.back().has_letter = runs.back().has_letter || span.poster != 0;
  }
  return runs;
}

class Hanger {
 public:
  Hanger(const Geometry& geometry, const PlanOptions& size, const WorldOptions& options)
      : geometry_(geometry), size_(size), options_(options) {}

  std::vector<WorldPoster> Hang() {
    for (const WorldFace& face : geometry_.faces) {
      HangLetters(face);
      HangByChance(face);
    }
    return std::move(posters_);
  }

 private:
  double Snap(double metres) const {
    return std::round(metres / options_.texel_m) * options_.texel_m;
  }

  void Add(const WorldFace& face, uint64_t picture, double middle_m) {
    const double top = size_.wall_height_m - kMiddleHeightM - 0.5 * options_.poster_height_m;
    WorldPoster poster;
    poster.face = face.id;
    const uint64_t seed = HangsOnEveryStorey(picture) ? options_.seed : SeedOfStorey(options_);
    poster.picture = MixSeeds(MixSeeds(seed, kPictureSeed), picture);
    poster.top_left_m = {Snap(middle_m - 0.5 * options_.poster_width_m), Snap(std::max(top, 0.0))};
    poster.size_m = {Snap(options_.poster_width_m), Snap(options_.poster_height_m)};
    posters_.push_back(poster);
  }

  bool HangsOnEveryStorey(uint64_t picture) const {
    if (picture < kFirstUnique) return true;
    Random random(MixSeeds(MixSeeds(options_.seed, kAlikeSeed), picture));
    return random.Uniform() < options_.alike_share;
  }

  void HangLetters(const WorldFace& face) {
    for (const FaceSpan& span : face.spans) {
      if (span.poster == 0) continue;
      Add(face, kFirstLetter + static_cast<uint64_t>(span.poster - 'a'),
          (span.cell + 0.5) * geometry_.cell_m);
    }
  }

  void HangByChance(const WorldFace& face) {
    Random random(MixSeeds(MixSeeds(options_.seed, kPlaceSeed), static_cast<uint64_t>(face.id)));
    for (const Run& run : WholeRuns(face)) {
      const bool hangs = random.Uniform() < options_.poster_probability;
      const bool repeated = random.Uniform() < options_.repeat_poster;
      const double slack = run.count * geometry_.cell_m - options_.poster_width_m;
      const double left = run.first * geometry_.cell_m + slack * random.Uniform(0.15, 0.85);
      if (!hangs || run.has_letter || slack <= 0.0) continue;
      const uint64_t unique = kFirstUnique + posters_.size();
      Add(face, repeated ? kRepeatedPicture : unique, left + 0.5 * options_.poster_width_m);
    }
  }

  const Geometry& geometry_;
  const PlanOptions& size_;
  const WorldOptions& options_;
  std::vector<WorldPoster> posters_;
};

}  // namespace

std::vector<WorldPoster> HangPosters(const Geometry& geometry, const PlanOptions& size,
                                     const WorldOptions& options) {
  return Hanger(geometry, size, options).Hang();
}

}  // namespace waystone
