// SPDX-License-Identifier: Apache-2.0
#include "bench/accuracy/collection_scenes.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <numeric>

#include "bench/accuracy/common.h"
#include "bench/accuracy/look_alike_buildings.h"
#include "bench/accuracy/panorama_places.h"
#include "bench/accuracy/recall_sets.h"
#include "bench/accuracy/relight.h"
#include "bench/accuracy/settings.h"
#include "bench/accuracy/world_source.h"
#include "builder/appearance/describe_panorama.h"
#include "core/image/decode.h"
#include "localizer/appearance/panorama_features.h"
#include "world/rig.h"

namespace waystone::bench {
namespace {

constexpr int kMapFrames = 48;
constexpr int kQueries = 30;
constexpr double kSeen = 0.3;  // of what a query shows, by a place that is right
constexpr int kRays = 12;      // across a query's picture, by which that is measured
constexpr double kSameSurface_m = 0.05;
constexpr int kLearnedFrom = 9000;  // seeds of scenes that words are learned from begin here
constexpr std::string_view kNoHash =
    "sha256:0000000000000000000000000000000000000000000000000000000000000000";

WorldOptions DrawLook(int seed) {
  Random random(static_cast<uint64_t>(seed) * 104'729 + 3);
  WorldOptions options;
  options.seed = static_cast<uint64_t>(seed);
  options.texel_m = 0.006;
  options.trim = random.Uniform() < 0.7;
  options.texture_richness = random.Uniform(0.1, 0.6);
  options.bare_walls = random.Uniform(0.0, 0.5);
  options.poster_probability = random.Uniform(0.3, 0.9);
  options.repeat_poster = random.Uniform(0, 0.2);
  options.alike_share = random.Uniform(0.3, 0.9);
  return options;
}

Walk MapWalk(const World& world) {
  WalkOptions options;
  options.gaze_rad = 0.4;
  return SpreadOver(DemoWalk(world.plan(), options), kMapFrames);
}

// Another visit: another height, gaze and hand, a step aside.
Walk QueryWalk(const World& world, Random& random) {
  WalkOptions options;
  options.height_m = random.Uniform(1.35, 1.65);
  options.gaze_rad = random.Uniform(0.2, 0.7);
  options.gaze_period_m = random.Uniform(4, 9);
  options.seed = random.Next();
  Walk walk = SpreadOver(DemoWalk(world.plan(), options), kQueries);
  for (WalkFrame& frame : walk.frames) {
    Eigen::Isometry3d aside = frame.world_from_camera;
    aside.linear() =
        Eigen::AngleAxisd(random.Uniform(-0.3, 0.3), Eigen::Vector3d::UnitZ()) * aside.linear();
    aside.translation() += Eigen::Vector3d(random.Uniform(-0.5, 0.5), random.Uniform(-0.5, 0.5), 0);
    if (world.IsInside(aside.translation())) frame.world_from_camera = aside;
  }
  return walk;
}

// The share of what one camera sees that another one sees too.
double SharedView(const World& world, const Camera& camera, const Eigen::Isometry3d& query,
                  const Eigen::Isometry3d& place) {
  int seen = 0;
  for (int i = 0; i < kRays * kRays; ++i) {
    const int row = i / kRays;
    const int column = i % kRays;
    const Eigen::Vector2d x((column + 0.5) * camera.width / kRays,
                            (row + 0.5) * camera.height / kRays);
    const Eigen::Vector3d direction = query.linear() * Eigen::Vector3d(Unproject(camera, x));
    const Eigen::Vector3d at =
        query.translation() + world.Cast(query.translation(), direction).t * direction;
    const auto there = Project(camera, place.inverse() * at);
    if (!there || there->x() < 0 || there->y() < 0 || there->x() >= camera.width ||
        there->y() >= camera.height) {
      continue;
    }
    const Eigen::Vector3d back = at - place.translation();
    const double off = back.norm() * std::abs(1 - world.Cast(place.translation(), back).t);
    seen += off < kSameSurface_m;
  }
  return static_cast<double>(seen) / (kRays * kRays);
}

Descriptors PoolOf(const MapIndex& index) { return index.search().Rows(0, index.search().rows()); }

MapData BuildOf(std::unique_ptr<Source> source, FeatureType type) {
  std::vector<std::unique_ptr<Source>> sources;
  sources.push_back(std::move(source));
  BuildOptions options = BuildOptionsFor(type);
  options.images = false;
  MapData map = BuildMap(sources, options, {}).map;
  map.info.version = kNoHash;
  return map;
}

std::vector<CoarseDescriptors> Described(const cv::Mat& grey, const CoarseEntry& entry) {
  ImageFeatures features;
  const CoarseNeed need{entry.feature_type, entry.working_pixels, entry.places() > entry.keyframes};
  return DescribeForCoarse(grey, {need}, {}, {}, features);
}

bool IsLocalized(const MapIndex& index, const cv::Mat& grey) {
  return LocalizeImage(index, grey, {}).verdict == Verdict::kLocalized;
}

CollectionScene MapBuilding(const std::string& name, const World& world, const Renderer& renderer,
                            FeatureType type) {
  const Walk walk = MapWalk(world);
  const auto index =
      MapIndex::Build(BuildOf(std::make_unique<WorldSource>(world, renderer, walk), type));
  CollectionScene scene{name, "rendered", MakeCoarseEntry(*index), PoolOf(*index), {}};
  // Places that are right need the frames of the keyframes.
  Random random(world.options().seed * 31 + 7);
  const Walk asked = QueryWalk(world, random);
  scene.queries.resize(asked.frames.size());
  for (size_t q = 0; q < asked.frames.size(); ++q) {
    for (int k = 0; k < scene.entry.keyframes; ++k) {
      const int frame = index->map().keyframes[k].frame;
      const double share = SharedView(world, renderer.camera(), asked.frames[q].world_from_camera,
                                      walk.frames[frame].world_from_camera);
      if (share >= kSeen) scene.queries[q].places.push_back(k);
    }
  }
  tbb::parallel_for(size_t{0}, asked.frames.size(), [&](size_t q) {
    if (scene.queries[q].places.empty()) return;
    Random light(world.options().seed * 1000 + q);
    RenderOptions options;
    options.lens_blur_px = light.Uniform(0.5, 1.2);
    options.noise_sigma = light.Uniform(2, 6);
    options.noise_seed = world.options().seed * 1000 + q;
    options.exposure_gain = light.Uniform(0.5, 1.2);
    const RenderedFrame frame = renderer.Render(world, asked.frames[q].world_from_camera, options);
    const cv::Mat grey = light.Uniform() < 0.5 ? frame.grey : Relight(frame, light);
    scene.queries[q].descriptors = Described(grey, scene.entry);
    scene.queries[q].localized = IsLocalized(*index, grey);
  });
  std::erase_if(scene.queries, [](const CollectionQuery& one) { return one.places.empty(); });
  return scene;
}

// Merges the sets of one map: with several maps of one place, a query would find only one.
std::vector<RecallSet> MergeByMap(std::vector<RecallSet> sets) {
  std::vector<RecallSet> merged;
  for (RecallSet& set : sets) {
    const auto same = std::ranges::find(merged, set.map, &RecallSet::map);
    if (same == merged.end()) {
      merged.push_back(std::move(set));
      continue;
    }
    same->name = set.name.substr(0, set.name.find('-'));
    same->is_right = [first = same->is_right, of_first = static_cast<int>(same->queries.size()),
                      second = set.is_right](int query, int frame) {
      return query < of_first ? first(query, frame) : second(query - of_first, frame);
    };
    same->queries.insert(same->queries.end(), set.queries.begin(), set.queries.end());
  }
  return merged;
}

}  // namespace

CoarseEntry PlacesOf(const CoarseEntry& entry, int from, int to) {
  CoarseEntry part = entry;
  const auto codes_before = [&](int place) {
    return std::accumulate(entry.codes_of.begin(), entry.codes_of.begin() + place, 0);
  };
  const int first = codes_before(from);
  const int last = codes_before(to);
  part.keyframes = std::clamp(entry.keyframes, from, to) - from;
  part.codes_of.assign(entry.codes_of.begin() + from, entry.codes_of.begin() + to);
  part.words.assign(entry.words.begin() + first, entry.words.begin() + last);
  part.signatures.assign(entry.signatures.begin() + first, entry.signatures.begin() + last);
  return part;
}

std::vector<CollectionScene> RenderBuilding(int seed, FeatureType type) {
  const Renderer renderer(PinholeCamera(640, 480, 1.1));
  WorldOptions look = DrawLook(seed);
  const std::string name = "building " + std::to_string(seed);
  std::vector<CollectionScene> scenes;
  scenes.push_back(MapBuilding(name, World(PlanOf(seed), look), renderer, type));
  if (seed % 2 == 1) {
    look.storey = 1;
    scenes.push_back(MapBuilding(name + ", above", World(PlanOf(seed), look), renderer, type));
  }
  return scenes;
}

CollectionScene RenderFlatScene(int seed, FeatureType type) {
  std::vector<PanoramaPlace> places = InWalkOrder(RenderFlatPlaces(static_cast<uint64_t>(seed)));
  DescribeOptions describe;
  describe.features.extract.bearings.features.type = type;
  // Two of every three are mapped, the others are queries.
  std::vector<size_t> mapped;
  std::vector<size_t> asked;
  for (size_t i = 0; i < places.size(); ++i) (i % 3 == 1 ? asked : mapped).push_back(i);
  std::vector<BearingFeatures> features(mapped.size());
  tbb::parallel_for(size_t{0}, mapped.size(), [&](size_t i) {
    features[i] = ExtractPanoramaFeatures(places[mapped[i]].grey, describe.features.extract);
  });
  MapData map;
  map.info.version = kNoHash;
  map.info.feature_type = type;
  map.sequences.push_back({SequenceId{1}, "flat", "panorama", 0, 0, {}});
  AppearanceLayer& layer = map.appearance.emplace();
  layer.described = describe.signature;
  NodeFeatureChooser chooser(describe.features);
  for (size_t i = 0; i < mapped.size(); ++i) {
    AppearanceNode node;
    node.id = AppearanceNodeId{static_cast<int64_t>(i) + 1};
    node.sequence = SequenceId{1};
    node.frame = static_cast<int>(i);
    node.signature = Signature(places[mapped[i]].grey, layer.described);
    NodeFeatures before = chooser.Next(features[i]);
    if (i > 0) layer.nodes[i - 1].features = std::move(before);
    layer.nodes.push_back(std::move(node));
  }
  layer.nodes.back().features = chooser.Last();
  const auto index = MapIndex::Build(std::move(map));
  CollectionScene scene{"flat " + std::to_string(seed),
                        "panoramas",
                        MakeCoarseEntry(*index),
                        Descriptors(DescriptorBytes(type)),
                        {}};
  for (const BearingFeatures& one : features) {
    for (int i = 0; i < one.size(); ++i) scene.pool.Append(one.descriptors.row(i));
  }
  scene.queries.resize(asked.size());
  tbb::parallel_for(size_t{0}, asked.size(), [&](size_t q) {
    const PanoramaPlace& place = places[asked[q]];
    for (size_t i = 0; i < mapped.size(); ++i) {
      const bool hidden = !place.hidden.empty() && place.hidden[mapped[i]];
      const double away_m = (places[mapped[i]].position_m - place.position_m).norm();
      if (!hidden && away_m < 2.5) scene.queries[q].places.push_back(static_cast<int>(i));
    }
    scene.queries[q].descriptors = Described(place.grey, scene.entry);
    scene.queries[q].localized = IsLocalized(*index, place.grey);
  });
  std::erase_if(scene.queries, [](const CollectionQuery& one) { return one.places.empty(); });
  return scene;
}

std::vector<CollectionScene> ReadRealScenes(const std::filesystem::path& data, FeatureType type) {
  std::vector<CollectionScene> scenes;
  for (const RecallSet& set : MergeByMap(ReadRecallSets(data))) {
    const auto index = MapIndex::Build(BuildOf(OpenRecallMap(set), type));
    CollectionScene scene{set.name, "photos", MakeCoarseEntry(*index), PoolOf(*index), {}};
    scene.queries.resize(set.queries.size());
    tbb::parallel_for(size_t{0}, set.queries.size(), [&](size_t q) {
      for (int k = 0; k < scene.entry.keyframes; ++k) {
        if (set.is_right(static_cast<int>(q), index->map().keyframes[k].frame)) {
          scene.queries[q].places.push_back(k);
        }
      }
      const cv::Mat grey = DecodeGrey(ReadBytes(set.queries[q]), {});
      scene.queries[q].descriptors = Described(grey, scene.entry);
      scene.queries[q].localized = IsLocalized(*index, grey);
    });
    std::erase_if(scene.queries, [](const CollectionQuery& one) { return one.places.empty(); });
    scenes.push_back(std::move(scene));
  }
  return scenes;
}

Descriptors RenderedDescriptors(FeatureType type, int scenes) {
  std::vector<Descriptors> of_scene(scenes, Descriptors(DescriptorBytes(type)));
  tbb::parallel_for(0, scenes, [&](int i) {
    const int seed = kLearnedFrom + i;
    const World world(PlanOf(seed), DrawLook(seed));
    const Renderer renderer(PinholeCamera(640, 480, 1.1));
    const Walk walk = MapWalk(world);
    const WorldSource source(world, renderer, walk);
    FeatureOptions options;
    options.type = type;
    for (int frame = i % 2; frame < kMapFrames; frame += 6) {
      const Features features = ExtractFeatures(source.Render(frame).grey, options);
      for (int row = 0; row < features.size(); ++row) {
        of_scene[i].Append(features.descriptors.row(row));
      }
    }
    int place = 0;
    for (const PanoramaPlace& one : RenderFlatPlaces(static_cast<uint64_t>(seed))) {
      if (++place % 12 != 0) continue;
      PanoramaFeatureOptions faces;
      faces.bearings.features.type = type;
      const BearingFeatures features = ExtractPanoramaFeatures(one.grey, faces);
      for (int row = 0; row < features.size(); ++row) {
        of_scene[i].Append(features.descriptors.row(row));
      }
    }
  });
  Descriptors all(DescriptorBytes(type));
  for (const Descriptors& one : of_scene) {
    for (int row = 0; row < one.rows(); ++row) all.Append(one.row(row));
  }
  return all;
}

}  // namespace waystone::bench
