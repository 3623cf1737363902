// SPDX-License-Identifier: Apache-2.0
#include <tbb/parallel_for.h>

#include <chrono>
#include <cstdio>
#include <filesystem>
#include <iostream>

#include "bench/accuracy/common.h"
#include "bench/accuracy/print_evidence.h"
#include "bench/accuracy/recall_sets.h"
#include "bench/accuracy/settings.h"
#include "bench/accuracy/stopwatch.h"
#include "bench/baseline/image_search.h"
#include "core/base/error.h"
#include "core/image/decode.h"
#include "localizer/planes/locate.h"
#include "schema/layers/planes/index_features.h"

namespace waystone::bench {
namespace {

namespace fs = std::filesystem;

// Median CPU time of finding the features of an image.
double TimeExtraction(const std::vector<fs::path>& images, const FeatureOptions& options) {
  constexpr size_t kTimed = 10;
  std::vector<double> ms;
  for (size_t i = 0; i < std::min(kTimed, images.size()); ++i) {
    const cv::Mat grey = DecodeGrey(ReadBytes(images[i]));
    const Stopwatch extracting;
    ExtractFeatures(grey, options);
    ms.push_back(1000 * extracting.cpu_s());
  }
  return Quantile(ms, 0.5);
}

// How often a method named a place, and how often the right one.
struct Found {
  int asked = 0;
  int localized = 0;
  int right = 0;
  int look_alikes = 0;            // asked, of places elsewhere
  int look_alikes_localized = 0;  // each of them wrongly
  int foreign = 0;
  int foreign_localized = 0;
  int64_t features = 0;   // kept
  int64_t map_bytes = 0;  // of the file
  std::vector<double> query_ms;

  nlohmann::ordered_json ToJson() const {
    nlohmann::ordered_json json{{"asked", asked},
                                {"localized", localized},
                                {"right", right},
                                {"wrong", localized - right},
                                {"look_alikes", look_alikes},
                                {"look_alikes_localized", look_alikes_localized},
                                {"foreign", foreign},
                                {"foreign_localized", foreign_localized},
                                {"features", features}};
    if (map_bytes > 0) json["map_bytes"] = map_bytes;
    if (!query_ms.empty()) json["median_query_ms"] = Quantile(query_ms, 0.5);
    return json;
  }
};

struct RecallArgs {
  fs::path data;
  std::string only;  // part of the sets' names
  std::vector<int> budgets;
  int foreign = 40;
  BuildOptions build;
  LocalizeOptions localize;
  bool search = true;
  bool exchanged = false;  // queries are mapped, and mapped images asked for
  bool verbose = false;
};

struct Asked {
  std::vector<Features> queries;
  std::vector<Features> look_alikes;
  std::vector<Features> foreign;
};

struct RecallMap {
  int budget = 0;
  std::shared_ptr<const MapIndex> index;
  int64_t features = 0;  // kept
  int64_t bytes = 0;     // of the file
};

RecallMap BuildRecallMap(const RecallSet& set, int budget, const RecallArgs& args) {
  std::vector<std::unique_ptr<Source>> sources;
  sources.push_back(OpenRecallMap(set));
  BuildOptions options = args.build;
  options.planes.landmarks.max_kept = budget;
  BuildResult built = BuildMap(sources, options, {});
  const int64_t features = CountFeatures(built.map);
  const int64_t bytes = CountFileBytes(built.map);
  std::printf("%s, %d landmarks: %zu keyframes, %zu planes, %lld features, %lld bytes\n",
              set.name.c_str(), budget, built.map.keyframes.size(), built.map.planes.size(),
              static_cast<long long>(features), static_cast<long long>(bytes));
  return {budget, MapIndex::Build(std::move(built.map)), features, bytes};
}

Found AskWaystone(const RecallSet& set, const Asked& asked, const RecallMap& map,
                  const RecallArgs& args) {
  const MapIndex* const index = map.index.get();
  Found found;
  found.features = map.features;
  found.map_bytes = map.bytes;
  const auto ask = [&](const Features& query) {
    return LocalizeFeatures(*index, query, args.localize);
  };
  for (size_t q = 0; q < asked.queries.size(); ++q) {
    const Answer answer = ask(asked.queries[q]);
    ++found.asked;
    found.query_ms.push_back(answer.timing.total_ms);
    const bool localized = answer.verdict == Verdict::kLocalized;
    const bool right =
        localized &&
        set.is_right(static_cast<int>(q), index->FindKeyframe(answer.planes.keyframe->id)->frame);
    found.localized += localized;
    found.right += right;
    if (args.verbose) PrintEvidence("query", static_cast<int>(q), answer, right);
  }
  for (size_t q = 0; q < asked.look_alikes.size(); ++q) {
    const Answer answer = ask(asked.look_alikes[q]);
    ++found.look_alikes;
    found.look_alikes_localized += answer.verdict == Verdict::kLocalized;
    if (args.verbose) PrintEvidence("look-alike", static_cast<int>(q), answer, false);
  }
  for (const Features& query : asked.foreign) {
    const Answer answer = ask(query);
    ++found.foreign;
    found.foreign_localized += answer.verdict == Verdict::kLocalized;
  }
  return found;
}

Found AskImageSearch(const RecallSet& set, const Asked& asked, int kept,
                     const FeatureOptions& features) {
  const ImageSearch search(ExtractAll(set.map, features), kept);
  Found found;
  found.features = search.CountFeatures();
  const auto count = [&](const std::vector<Features>& queries, auto&& each) {
    std::vector<std::optional<FoundImage>> best(queries.size());
    tbb::parallel_for(size_t{0}, queries.size(),
                      [&](size_t q) { best[q] = search.Find(queries[q]); });
    for (size_t q = 0; q < best.size(); ++q) each(static_cast<int>(q), best[q]);
  };
  count(asked.queries, [&](int q, const std::optional<FoundImage>& best) {
    ++found.asked;
    found.localized += best.has_value();
    found.right += best && set.is_right(q, best->image);
  });
  count(asked.look_alikes, [&](int, const std::optional<FoundImage>& best) {
    ++found.look_alikes;
    found.look_alikes_localized += best.has_value();
  });
  count(asked.foreign, [&](int, const std::optional<FoundImage>& best) {
    ++found.foreign;
    found.foreign_localized += best.has_value();
  });
  return found;
}

RecallArgs ParseRecallArgs(const Args& raw) {
  Args args = raw;
  RecallArgs parsed;
  parsed.only = TakeOption(args, "only", "");
  parsed.budgets = ParseNumbers(TakeOption(args, "landmarks", "0,100"), ',');
  parsed.build = TakeBuildSettings(args);
  parsed.foreign = std::stoi(TakeOption(args, "foreign", "40"));
  parsed.search = TakeOption(args, "search", "yes") == "yes";
  parsed.exchanged = TakeOption(args, "exchanged", "no") == "yes";
  parsed.verbose = TakeOption(args, "each", "no") == "yes";
  parsed.localize.explain = parsed.verbose;
  parsed.localize.planes.max_keyframes = std::stoi(TakeOption(args, "keyframes", "4"));
  if (args.size() > 1 || parsed.budgets.empty()) {
    throw MapError(ErrorCode::kUsage,
                   "recall takes a folder with data, --only NAME, --landmarks N,N,..., --foreign "
                   "N, --keyframes N, --search yes|no, --exchanged yes|no, --each yes|no and --set "
                   "NAME=VALUE");
  }
  parsed.data = args.empty() ? fs::path(WAYSTONE_SOURCE_DIR) / "../shared/data" : fs::path(args[0]);
  return parsed;
}

}  // namespace

int RunRecall(const Args& raw) {
  const RecallArgs args = ParseRecallArgs(raw);
  std::vector<RecallSet> sets = ReadRecallSets(args.data);
  if (const fs::path rig = args.data / "dealership"; fs::exists(rig)) {
    sets.push_back(ReadRigPhotos(rig));
  }
  nlohmann::ordered_json json{{"bench", "recall"}, {"sets", nlohmann::ordered_json::array()}};
  for (const RecallSet& one : sets) {
    if (one.name.find(args.only) == std::string::npos) continue;
    constexpr int kMaxQueries = 50;
    const RecallSet set = args.exchanged ? Exchanged(one, kMaxQueries) : one;
    std::vector<RecallMap> maps;
    for (const int budget : args.budgets) maps.push_back(BuildRecallMap(set, budget, args));
    // All of these maps have the same keyframes.
    const FeatureOptions features = QueryFeatureOptions(*maps.front().index, args.localize.planes);
    const Asked asked{ExtractAll(set.queries, features), ExtractAll(set.look_alikes, features),
                      ExtractAll(ChooseForeign(sets, set, args.foreign), features)};
    nlohmann::ordered_json curve = nlohmann::ordered_json::array();
    for (const RecallMap& map : maps) {
      nlohmann::ordered_json point = AskWaystone(set, asked, map, args).ToJson();
      point["landmarks"] = map.budget;
      std::cout << set.name << " waystone " << point.dump() << std::endl;
      curve.push_back(std::move(point));
    }
    nlohmann::ordered_json searched = nlohmann::ordered_json::array();
    if (args.search) {
      for (const int kept : {1000, 100, 60}) {
        nlohmann::ordered_json point =
            AskImageSearch(set, asked, kept, args.build.features).ToJson();
        point["kept"] = kept;
        std::cout << set.name << " image search " << point.dump() << std::endl;
        searched.push_back(std::move(point));
      }
    }
    json["sets"].push_back({{"name", set.name},
                            {"features_ms", TimeExtraction(set.queries, features)},
                            {"waystone", curve},
                            {"image_search", searched}});
  }
  std::cout << json.dump() << std::endl;
  return 0;
}

}  // namespace waystone::bench
