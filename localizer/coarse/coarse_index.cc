// SPDX-License-Identifier: Apache-2.0
#include "localizer/coarse/coarse_index.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <span>
#include <utility>

#include "core/search/near_signatures.h"

namespace waystone {
namespace {

constexpr std::array kTypes{FeatureType::kSift, FeatureType::kOrb, FeatureType::kAkaze};

}  // namespace

void CoarseOptions::Check() const { CheckFields("coarse", *this); }

// The votes of each place, and the places with any votes.
struct CoarseIndex::Votes {
  explicit Votes(size_t places) : weights(places, 0) {}

  void Add(uint32_t place, double weight) {
    if (weights[place] == 0) touched.push_back(place);
    weights[place] += weight;
  }

  std::vector<double> weights;
  std::vector<uint32_t> touched;
};

// The places that one feature of the query finds, each by its nearest code.
class CoarseIndex::NearPlaces {
 public:
  struct Place {
    uint32_t place = 0;
    int distance = 0;
  };

  explicit NearPlaces(size_t places) : slot_of_(places, 0) {}

  void Clear() { found_.clear(); }
  void Add(uint32_t place, int distance) {
    // A slot left by an earlier feature may belong to another place.
    uint32_t& slot = slot_of_[place];
    if (slot < found_.size() && found_[slot].place == place) {
      found_[slot].distance = std::min(found_[slot].distance, distance);
      return;
    }
    slot = static_cast<uint32_t>(found_.size());
    found_.push_back({place, distance});
  }
  const std::vector<Place>& found() const { return found_; }

 private:
  std::vector<uint32_t> slot_of_;
  std::vector<Place> found_;
};

CoarseIndex::CoarseIndex(std::vector<Map> maps, const CoarseOptions& options)
    : options_((options.Check(), options)), maps_(std::move(maps)) {
  std::ranges::sort(maps_, {}, &Map::name);
  for (size_t map = 0; map < maps_.size(); ++map) {
    map_of_place_.insert(map_of_place_.end(), maps_[map].entry->places(),
                         static_cast<uint32_t>(map));
  }
  for (const FeatureType type : kTypes) Fill(type);
}

// A counting sort: entries come by map and place, so each list is ordered by place.
void CoarseIndex::Fill(FeatureType type) {
  Lists& lists = lists_[static_cast<size_t>(type)];
  std::vector<uint32_t> start(Vocabulary::kCount + 1, 0);
  for (const Map& map : maps_) {
    if (map.entry->feature_type != type) continue;
    for (const uint16_t word : map.entry->words) ++start[word + 1];
  }
  std::partial_sum(start.begin(), start.end(), start.begin());
  if (start.back() == 0) return;
  lists.signatures.resize(start.back());
  lists.places.resize(start.back());
  std::vector<uint32_t> next(start.begin(), start.end() - 1);
  uint32_t place = 0;
  for (const Map& map : maps_) {
    const CoarseEntry& entry = *map.entry;
    size_t code = 0;
    for (const uint8_t count : entry.codes_of) {
      for (int i = 0; i < count && entry.feature_type == type; ++i, ++code) {
        const uint32_t slot = next[entry.words[code]]++;
        lists.signatures[slot] = entry.signatures[code];
        lists.places[slot] = place;
      }
      ++place;
    }
  }
  lists.start = std::move(start);
}

int64_t CoarseIndex::bytes() const {
  size_t bytes = map_of_place_.size() * sizeof(map_of_place_[0]);
  for (const Lists& lists : lists_) {
    bytes += lists.start.size() * sizeof(uint32_t) +
             lists.signatures.size() * (sizeof(uint64_t) + sizeof(uint32_t));
  }
  for (const Map& map : maps_) {
    bytes += sizeof(Map) + sizeof(CoarseEntry) + map.name.size() + map.entry->codes_of.size() +
             map.entry->words.size() * (sizeof(uint16_t) + sizeof(uint64_t));
  }
  return static_cast<int64_t>(bytes);
}

std::vector<CoarseNeed> CoarseIndex::Needs() const {
  std::vector<CoarseNeed> needs;
  for (const FeatureType type : kTypes) {
    if (lists_[static_cast<size_t>(type)].start.empty()) continue;
    CoarseNeed need{type, 0, false};
    for (const Map& map : maps_) {
      if (map.entry->feature_type != type) continue;
      need.working_pixels = std::max(need.working_pixels, map.entry->working_pixels);
      need.panoramas |= map.entry->places() > map.entry->keyframes;
    }
    needs.push_back(need);
  }
  return needs;
}

// Each feature votes once per place, by its nearest code there: more, the nearer the code is, and
// less, the more places the feature finds (bursts: Jegou, Douze and Schmid, CVPR 2009).
void CoarseIndex::Vote(const CoarseDescriptors& image, Votes& votes) const {
  const Lists& lists = lists_[static_cast<size_t>(image.type)];
  if (lists.start.empty()) return;
  const Vocabulary& words = Vocabulary::Of(image.type);
  NearPlaces places(map_of_place_.size());
  std::vector<NearSignature> near;
  for (int q = 0; q < image.rows.rows(); ++q) {
    places.Clear();
    for (const WordCode& probe : words.Probe(image.rows.row(q), options_.probes)) {
      const uint32_t start = lists.start[probe.word];
      const size_t count = lists.start[probe.word + 1] - start;
      near.clear();
      AppendNear(std::span(lists.signatures).subspan(start, count), probe.signature,
                 options_.max_distance, near);
      for (const NearSignature& one : near) {
        places.Add(lists.places[start + one.index], one.distance);
      }
    }
    const double share = 1 / std::sqrt(static_cast<double>(places.found().size()));
    for (const NearPlaces::Place& one : places.found()) {
      votes.Add(one.place, share * (options_.max_distance + 1 - one.distance));
    }
  }
}

// A map's score is that of its best place with its neighbours.
void CoarseIndex::AddScores(const Votes& votes, std::vector<double>& scores) const {
  std::vector<double> best(maps_.size(), 0);
  const auto last = static_cast<int64_t>(map_of_place_.size()) - 1;
  for (const uint32_t place : votes.touched) {
    const uint32_t map = map_of_place_[place];
    double sum = 0;
    for (int64_t near = std::max<int64_t>(0, int64_t{place} - options_.window);
         near <= std::min<int64_t>(last, int64_t{place} + options_.window); ++near) {
      if (map_of_place_[near] == map) sum += votes.weights[near];
    }
    best[map] = std::max(best[map], sum);
  }
  for (size_t map = 0; map < best.size(); ++map) scores[map] += best[map];
}

std::vector<CoarseIndex::Proposal> CoarseIndex::Propose(
    const std::vector<std::vector<CoarseDescriptors>>& images, int count,
    const std::vector<bool>& left_out) const {
  std::vector<double> scores(maps_.size(), 0);
  for (const std::vector<CoarseDescriptors>& image : images) {
    Votes votes(map_of_place_.size());
    for (const CoarseDescriptors& one : image) Vote(one, votes);
    AddScores(votes, scores);
  }
  std::vector<Proposal> proposals;
  for (size_t map = 0; map < scores.size(); ++map) {
    const bool passed_over = !left_out.empty() && left_out[map];
    if (scores[map] > 0 && !passed_over) {
      proposals.push_back({static_cast<int>(map), scores[map]});
    }
  }
  const size_t kept = std::min(proposals.size(), static_cast<size_t>(std::max(0, count)));
  const auto better = [](const Proposal& a, const Proposal& b) {
    return a.score != b.score ? a.score > b.score : a.map < b.map;
  };
  std::ranges::partial_sort(proposals, proposals.begin() + static_cast<ptrdiff_t>(kept), better);
  proposals.resize(kept);
  return proposals;
}

}  // namespace waystone
