// SPDX-License-Identifier: Apache-2.0
#include <tbb/global_control.h>

#include <cstdio>
#include <functional>
#include <iostream>
#include <opencv2/core.hpp>
#include <sstream>

#include "bench/accuracy/common.h"
#include "bench/accuracy/recall_sets.h"
#include "bench/accuracy/settings.h"
#include "bench/accuracy/stopwatch.h"
#include "bench/baseline/vote_search.h"
#include "core/base/error.h"
#include "core/image/decode.h"
#include "localizer/planes/locate.h"

namespace waystone::bench {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

// Finds the map's frame that shows what a query shows; nothing if there is none.
using Finder = std::function<std::optional<int>(const Features& query)>;

// What all methods get: the queries' features, and what these cost.
struct PeerQueries {
  std::vector<Features> own;
  std::vector<Features> look_alikes;
  std::vector<Features> foreign;
  std::vector<double> decode_ms;  // of the own ones, as is the next
  std::vector<double> extract_ms;
};

struct PeerArgs {
  fs::path data;
  std::vector<std::string> only;  // names of sets; empty for all
  std::vector<FeatureType> types;
  int foreign = 84;
  int landmarks = LandmarkOptions{}.max_kept;
};

double Median(const std::vector<double>& values) {
  return values.empty() ? 0 : Quantile(values, 0.5);
}

Features Extract(const fs::path& image, const FeatureOptions& options, PeerQueries* times) {
  const std::vector<uint8_t> bytes = ReadBytes(image);
  const Stopwatch decoding;
  const cv::Mat grey = DecodeGrey(bytes);
  const double decode_ms = 1000 * decoding.cpu_s();
  const Stopwatch extracting;
  Features features = ExtractFeatures(grey, options);
  if (times != nullptr) {
    times->decode_ms.push_back(decode_ms);
    times->extract_ms.push_back(1000 * extracting.cpu_s());
  }
  return features;
}

PeerQueries ExtractQueries(const RecallSet& set, const std::vector<fs::path>& foreign,
                           const FeatureOptions& options) {
  PeerQueries queries;
  for (const fs::path& image : set.queries) {
    queries.own.push_back(Extract(image, options, &queries));
  }
  for (const fs::path& image : set.look_alikes) {
    queries.look_alikes.push_back(Extract(image, options, nullptr));
  }
  for (const fs::path& image : foreign) {
    queries.foreign.push_back(Extract(image, options, nullptr));
  }
  return queries;
}

int CountFound(const Finder& find, const std::vector<Features>& queries) {
  return static_cast<int>(std::ranges::count_if(
      queries, [&](const Features& query) { return find(query).has_value(); }));
}

// Asks one method all queries and prints a row.
Json AskPeer(const std::string& name, const RecallSet& set, const PeerQueries& queries,
             int64_t bytes, const Finder& find) {
  int found = 0;
  int right = 0;
  std::vector<double> find_ms;
  for (size_t q = 0; q < queries.own.size(); ++q) {
    const Stopwatch watch;
    const std::optional<int> frame = find(queries.own[q]);
    find_ms.push_back(1000 * watch.cpu_s());
    found += frame.has_value();
    right += frame && set.is_right(static_cast<int>(q), *frame);
  }
  const int look_alikes = CountFound(find, queries.look_alikes);
  const int foreign = CountFound(find, queries.foreign);
  std::printf(
      "%-22s found %3d of %3zu, %3d right; look-alikes %3d of %3zu, foreign %2d of %3zu; %5.1f ms "
      "decoding, %6.1f features, %6.1f search; %.2f MB\n",
      name.c_str(), found, queries.own.size(), right, look_alikes, queries.look_alikes.size(),
      foreign, queries.foreign.size(), Median(queries.decode_ms), Median(queries.extract_ms),
      Median(find_ms), 1e-6 * static_cast<double>(bytes));
  (void)std::fflush(stdout);
  return {{"name", name},
          {"asked", queries.own.size()},
          {"found", found},
          {"right", right},
          {"look_alikes", queries.look_alikes.size()},
          {"look_alikes_localized", look_alikes},
          {"foreign", queries.foreign.size()},
          {"foreign_localized", foreign},
          {"decode_ms", Median(queries.decode_ms)},
          {"features_ms", Median(queries.extract_ms)},
          {"search_ms", Median(find_ms)},
          {"bytes", bytes}};
}

struct PeerMap {
  std::shared_ptr<const MapIndex> index;
  int64_t bytes = 0;  // of its file without images, which no query needs
};

PeerMap BuildPeerMap(const RecallSet& set, const FeatureOptions& features, int landmarks) {
  std::vector<std::unique_ptr<Source>> sources;
  sources.push_back(OpenRecallMap(set));
  BuildOptions options;
  options.features = features;
  options.planes.landmarks.max_kept = landmarks;
  options.images = false;
  BuildResult built = BuildMap(sources, options, {});
  const int64_t bytes = CountFileBytes(built.map);
  return {MapIndex::Build(std::move(built.map)), bytes};
}

Json ComparePeers(const RecallSet& set, const std::vector<fs::path>& foreign, FeatureType type,
                  int landmarks) {
  const FeatureOptions features = BuildOptionsFor(type).features;
  const PeerMap map = BuildPeerMap(set, features, landmarks);
  std::vector<int> frames;
  std::vector<Features> images;
  for (const Keyframe& keyframe : map.index->map().keyframes) {
    frames.push_back(keyframe.frame);
    images.push_back(Extract(set.map[keyframe.frame], features, nullptr));
  }
  // From here on as on a single core: building isn't timed.
  const tbb::global_control one_thread(tbb::global_control::max_allowed_parallelism, 1);
  const PeerQueries queries = ExtractQueries(set, foreign, QueryFeatureOptions(*map.index, {}));
  const std::string kind(NameOf(type));
  Json rows = Json::array();
  rows.push_back(AskPeer("waystone-" + kind, set, queries, map.bytes,
                         [&](const Features& query) -> std::optional<int> {
                           const Answer answer = LocalizeFeatures(*map.index, query, {});
                           if (answer.verdict != Verdict::kLocalized) return std::nullopt;
                           return map.index->FindKeyframe(answer.planes.keyframe->id)->frame;
                         }));
  for (const int probes : {0, 64}) {
    const VoteSearch search(images, probes);
    rows.push_back(AskPeer((probes == 0 ? "exact-" : "lists-") + kind, set, queries,
                           search.CountBytes(), [&](const Features& query) -> std::optional<int> {
                             const auto found = search.Find(query);
                             if (!found) return std::nullopt;
                             return frames[found->image];
                           }));
  }
  return rows;
}

std::vector<std::string> SplitByCommas(const std::string& text) {
  std::vector<std::string> words;
  std::istringstream stream(text);
  for (std::string word; std::getline(stream, word, ',');) words.push_back(word);
  return words;
}

PeerArgs ParsePeerArgs(const Args& raw) {
  Args args = raw;
  PeerArgs parsed;
  parsed.only = SplitByCommas(TakeOption(args, "only", ""));
  parsed.foreign = std::stoi(TakeOption(args, "foreign", "84"));
  parsed.landmarks =
      std::stoi(TakeOption(args, "landmarks", std::to_string(LandmarkOptions{}.max_kept)));
  for (const std::string& name : SplitByCommas(TakeOption(args, "features", "sift,orb,akaze"))) {
    parsed.types.push_back(FeatureTypeByName(name));
  }
  if (args.size() > 1 || parsed.types.empty()) {
    throw MapError(ErrorCode::kUsage,
                   "peers takes a folder with data, --only NAME,NAME, --features TYPE,TYPE, "
                   "--landmarks N and --foreign N");
  }
  parsed.data = args.empty() ? fs::path(WAYSTONE_SOURCE_DIR) / "../shared/data" : fs::path(args[0]);
  return parsed;
}

}  // namespace

int RunPeers(const Args& raw) {
  const PeerArgs args = ParsePeerArgs(raw);
  cv::setNumThreads(1);
  const std::vector<RecallSet> sets = ReadRecallSets(args.data);
  Json json{{"bench", "peers"}, {"sets", Json::array()}};
  for (const RecallSet& set : sets) {
    if (!args.only.empty() && std::ranges::find(args.only, set.name) == args.only.end()) continue;
    std::printf("%s\n", set.name.c_str());
    const std::vector<fs::path> foreign = ChooseForeign(sets, set, args.foreign);
    Json rows = Json::array();
    for (const FeatureType type : args.types) {
      for (Json& row : ComparePeers(set, foreign, type, args.landmarks)) {
        rows.push_back(std::move(row));
      }
    }
    json["sets"].push_back({{"name", set.name}, {"rows", rows}});
  }
  std::cout << json.dump() << std::endl;
  return 0;
}

}  // namespace waystone::bench
