// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "core/base/options.h"
#include "localizer/coarse/coarse_entry.h"
#include "localizer/coarse/coarse_query.h"

namespace waystone {

struct CoarseOptions {
  int probes = 8;
  int max_distance = 22;
  int window = 4;

  static constexpr auto Fields(const auto& use) {
    using Self = CoarseOptions;
    return use(OptionField{"probes", &Self::probes, Closed(1, Vocabulary::kMaxProbes), "",
                           "Number of words in which a feature of the query is searched for. More "
                           "words find more features, but take longer."},
               OptionField{"max_distance", &Self::max_distance, Closed(0, 64), "bits",
                           "Maximum difference between signatures that count as the same feature."},
               OptionField{"window", &Self::window, Closed(0, 100), "places",
                           "Number of places before and after a place that also vote for it: "
                           "neighbours saw the same scene and have other features of it."});
  }
  void Check() const;  // throws MapError(kBadOptions)
};

// Which of many maps may show what an image shows, by a few codes per place and without opening any
// of them. Places are found by an inverted file over the words (core/search/words.h): a query
// visits only the lists of its words, a small part of all. Immutable: any number of threads may
// query it. The same entries give the same index and the same answers.
class CoarseIndex {
 public:
  struct Map {
    std::string name;
    std::shared_ptr<const CoarseEntry> entry;
  };
  // A candidate map: its index in maps(), and its score.
  struct Proposal {
    int map = 0;
    double score = 0;

    bool operator==(const Proposal&) const = default;
  };

  CoarseIndex() = default;
  // Orders the maps by name.
  explicit CoarseIndex(std::vector<Map> maps, const CoarseOptions& options = {});

  const std::vector<Map>& maps() const { return maps_; }
  int64_t places() const { return static_cast<int64_t>(map_of_place_.size()); }
  // Memory used, including the entries.
  int64_t bytes() const;
  // What DescribeForCoarse takes.
  std::vector<CoarseNeed> Needs() const;

  // The `count` maps with the highest scores, highest first, ties by name, for all images of one
  // place together; fewer where fewer have any. Maps i with left_out[i] are skipped; an empty
  // vector skips none.
  std::vector<Proposal> Propose(const std::vector<std::vector<CoarseDescriptors>>& images,
                                int count, const std::vector<bool>& left_out = {}) const;

 private:
  // Codes of one feature type, by word.
  struct Lists {
    std::vector<uint32_t> start;  // of each word's, and one more for the end; empty without codes
    std::vector<uint64_t> signatures;
    std::vector<uint32_t> places;
  };
  struct Votes;
  class NearPlaces;

  void Fill(FeatureType type);
  void Vote(const CoarseDescriptors& image, Votes& votes) const;
  void AddScores(const Votes& votes, std::vector<double>& scores) const;

  CoarseOptions options_;
  std::vector<Map> maps_;
  std::vector<uint32_t> map_of_place_;
  std::array<Lists, 3> lists_;  // by feature type
};

}  // namespace waystone
