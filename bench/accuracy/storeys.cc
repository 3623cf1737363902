// SPDX-License-Identifier: Apache-2.0
#include <tbb/parallel_for.h>

#include <functional>
#include <iostream>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "bench/accuracy/common.h"
#include "bench/accuracy/look_alike_buildings.h"
#include "bench/accuracy/print_evidence.h"
#include "bench/accuracy/recall_sets.h"
#include "bench/accuracy/settings.h"
#include "bench/accuracy/world_source.h"
#include "bench/baseline/image_search.h"
#include "core/base/error.h"
#include "localizer/planes/locate.h"

namespace waystone::bench {
namespace {

constexpr int kStoreys = 2;          // of rendered buildings
constexpr int kKeptFeatures = 1000;  // of an image, by image search

using Extract = std::function<std::vector<Features>(const FeatureOptions& options)>;

// A storey: the images of its map, which are a source of their own, and photos of another visit.
struct Storey {
  std::unique_ptr<Source> source;
  std::vector<Features> images;
  Extract queries;
};

struct StoreyFigures {
  int asked = 0;
  int localized = 0;
  int on_storey = 0;  // of these, at a keyframe of the query's storey
  int ambiguous = 0;
  int found = 0;            // by image search
  int found_on_storey = 0;  // of these
  int planes = 0;
  int planes_across = 0;  // with views of several storeys
  int edges_across = 0;   // between planes of different storeys
  int links = 0;
  int links_across = 0;  // between keyframes of different storeys

  void Add(const StoreyFigures& more) {
    asked += more.asked;
    localized += more.localized;
    on_storey += more.on_storey;
    ambiguous += more.ambiguous;
    found += more.found;
    found_on_storey += more.found_on_storey;
    planes += more.planes;
    planes_across += more.planes_across;
    edges_across += more.edges_across;
    links += more.links;
    links_across += more.links_across;
  }

  nlohmann::ordered_json ToJson() const {
    return {{"asked", asked},
            {"localized", localized},
            {"on_storey", on_storey},
            {"elsewhere", localized - on_storey},
            {"ambiguous", ambiguous},
            {"found", found},
            {"found_on_storey", found_on_storey},
            {"found_elsewhere", found - found_on_storey},
            {"planes", planes},
            {"planes_across", planes_across},
            {"edges_across", edges_across},
            {"links", links},
            {"links_across", links_across}};
  }
};

// Storeys are sequences of the map, in their order.
int StoreyOfKeyframe(const MapIndex& index, KeyframeId keyframe) {
  return static_cast<int>(index.FindKeyframe(keyframe)->sequence.value) - 1;
}

void CountAcross(const MapIndex& index, StoreyFigures& figures) {
  std::map<PlaneId, int> home;
  for (const Plane& plane : index.map().planes) {
    std::set<int> seen_on;
    for (const PlaneView& view : plane.views) {
      seen_on.insert(StoreyOfKeyframe(index, view.keyframe));
    }
    ++figures.planes;
    figures.planes_across += seen_on.size() > 1;
    home[plane.id] = StoreyOfKeyframe(index, plane.reference);
  }
  for (const Edge& edge : index.map().edges) {
    figures.edges_across += home.at(edge.a) != home.at(edge.b);
  }
  for (const KeyframeLink& link : index.map().links) {
    ++figures.links;
    figures.links_across += StoreyOfKeyframe(index, link.a) != StoreyOfKeyframe(index, link.b);
  }
}

struct StoreysArgs {
  int buildings = 8;
  int first = 17;
  int every = 1;  // the maps of rendered buildings have every n-th image of the tour
  BuildOptions build;
  bool each = false;  // whether to print every answer
};

// The map of all storeys and what image search has of them.
class Together {
 public:
  Together(std::vector<Storey> storeys, const StoreysArgs& args) : each_(args.each) {
    std::vector<std::unique_ptr<Source>> sources;
    std::vector<Features> images;
    for (Storey& storey : storeys) {
      const int number = static_cast<int>(sources.size());
      storey_of_image_.insert(storey_of_image_.end(), storey.images.size(), number);
      images.insert(images.end(), storey.images.begin(), storey.images.end());
      sources.push_back(std::move(storey.source));
    }
    index_ = MapIndex::Build(BuildMap(sources, args.build, {}).map);
    const FeatureOptions features = QueryFeatureOptions(*index_, {});
    for (const Storey& storey : storeys) queries_.push_back(storey.queries(features));
    search_.emplace(std::move(images), kKeptFeatures);
  }

  StoreyFigures Ask() const {
    StoreyFigures figures;
    CountAcross(*index_, figures);
    for (size_t i = 0; i < queries_.size(); ++i) {
      AskStorey(static_cast<int>(i), figures);
      FindStorey(static_cast<int>(i), figures);
    }
    return figures;
  }

 private:
  void AskStorey(int storey, StoreyFigures& figures) const {
    const std::vector<Features>& queries = queries_[storey];
    std::vector<Answer> answers(queries.size());
    LocalizeOptions options;
    options.explain = each_;
    tbb::parallel_for(size_t{0}, queries.size(), [&](size_t q) {
      answers[q] = LocalizeFeatures(*index_, queries[q], options);
    });
    const std::string kind = "storey " + std::to_string(storey) + " query";
    for (size_t q = 0; q < queries.size(); ++q) {
      const Answer& answer = answers[q];
      const bool localized = answer.verdict == Verdict::kLocalized;
      const bool right =
          localized && StoreyOfKeyframe(*index_, answer.planes.keyframe->id) == storey;
      ++figures.asked;
      figures.localized += localized;
      figures.on_storey += right;
      figures.ambiguous += answer.verdict == Verdict::kAmbiguous;
      if (each_) PrintEvidence(kind.c_str(), static_cast<int>(q), answer, right);
    }
  }

  void FindStorey(int storey, StoreyFigures& figures) const {
    const std::vector<Features>& queries = queries_[storey];
    std::vector<std::optional<FoundImage>> found(queries.size());
    tbb::parallel_for(size_t{0}, queries.size(),
                      [&](size_t q) { found[q] = search_->Find(queries[q]); });
    for (const std::optional<FoundImage>& one : found) {
      figures.found += one.has_value();
      figures.found_on_storey += one && storey_of_image_[one->image] == storey;
    }
  }

  bool each_;
  std::vector<std::vector<Features>> queries_;  // of each storey
  std::vector<int> storey_of_image_;            // of image search
  std::shared_ptr<const MapIndex> index_;
  std::optional<ImageSearch> search_;
};

StoreyFigures AskTogether(const std::string& name, std::vector<Storey> storeys,
                          const StoreysArgs& args) {
  const StoreyFigures figures = Together(std::move(storeys), args).Ask();
  std::cout << name << " " << figures.ToJson().dump() << std::endl;
  return figures;
}

// Both storeys of a rendered building.
StoreyFigures AskBuilding(int building, const StoreysArgs& args) {
  const Renderer renderer(LookAlikeCamera(640));
  std::vector<World> worlds;
  for (int storey = 0; storey < kStoreys; ++storey) worlds.push_back(StoreyOf(building, storey));
  const Walk map_walk = EveryNth(MapTour(worlds.front()), args.every);
  const Walk query_walk = QueryTour(worlds.front(), building);
  std::vector<Storey> storeys;
  for (const World& world : worlds) {
    auto source = std::make_unique<WorldSource>(world, renderer, map_walk);
    Storey storey{nullptr, std::vector<Features>(map_walk.frames.size()), {}};
    tbb::parallel_for(size_t{0}, storey.images.size(), [&](size_t i) {
      storey.images[i] =
          ExtractFeatures(source->Render(static_cast<int>(i)).grey, args.build.features);
    });
    storey.queries = [&, building](const FeatureOptions& options) {
      std::vector<Features> queries(query_walk.frames.size());
      tbb::parallel_for(size_t{0}, queries.size(), [&](size_t i) {
        const uint64_t seed = 1000 * static_cast<uint64_t>(building) + i;
        queries[i] = ExtractFeatures(
            Photograph(renderer, world, query_walk.frames[i].world_from_camera, seed), options);
      });
      return queries;
    };
    storey.source = std::move(source);
    storeys.push_back(std::move(storey));
  }
  return AskTogether("building " + std::to_string(building), std::move(storeys), args);
}

// All floors of the tower.
StoreyFigures AskTower(const std::vector<RecallSet>& sets, const StoreysArgs& args) {
  std::vector<Storey> floors;
  for (const RecallSet& set : sets) {
    if (set.look_alikes.empty()) continue;
    floors.push_back(
        {OpenRecallMap(set), ExtractAll(set.map, args.build.features),
         [&set](const FeatureOptions& options) { return ExtractAll(set.queries, options); }});
  }
  return AskTogether("tower", std::move(floors), args);
}

}  // namespace

int RunStoreys(const Args& raw) {
  Args rest = raw;
  StoreysArgs args;
  args.buildings = std::stoi(TakeOption(rest, "buildings", "8"));
  args.first = std::stoi(TakeOption(rest, "first", "17"));
  args.every = std::max(1, std::stoi(TakeOption(rest, "every", "1")));
  args.each = TakeOption(rest, "each", "no") == "yes";
  args.build = TakeBuildSettings(rest);
  args.build.images = false;
  if (rest.size() > 1) {
    throw MapError(ErrorCode::kUsage,
                   "storeys takes a folder with data, --buildings N, --first SEED, --every N, "
                   "--each yes|no and --set NAME=VALUE");
  }
  nlohmann::ordered_json json{{"bench", "storeys"}, {"buildings", args.buildings}};
  StoreyFigures rendered;
  for (int building = args.first; building < args.first + args.buildings; ++building) {
    rendered.Add(AskBuilding(building, args));
  }
  json["rendered"] = rendered.ToJson();
  if (!rest.empty()) json["tower"] = AskTower(ReadRecallSets(rest[0]), args).ToJson();
  std::cout << json.dump() << std::endl;
  return 0;
}

}  // namespace waystone::bench
