// SPDX-License-Identifier: Apache-2.0
#include "builder/build_map.h"

#include <tbb/task_arena.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <set>

#include "builder/calibration/calibrate.h"
#include "builder/calibration/rendered_negatives.h"
#include "builder/extract_frames.h"
#include "builder/orientation_pass.h"
#include "builder/planes/fusion.h"
#include "builder/planes/plane_features.h"
#include "builder/planes/plane_tracker.h"
#include "core/base/clock.h"
#include "core/base/error.h"
#include "core/base/version.h"
#include "schema/layers/planes/index_features.h"

namespace waystone {
namespace {

constexpr int kMaxNamedSkips = 20;
constexpr int kThumbnailQuality = 80;  // of JPEG

std::string OptionsJson(const BuildOptions& options) {
  const PlaneLayerOptions& planes = options.planes;
  const nlohmann::ordered_json json = {
      {"features",
       {{"type", NameOf(options.features.type)},
        {"max_features", options.features.max_features},
        {"contrast_threshold", options.features.contrast_threshold}}},
      {"keyframes",
       {{"min_matches_last", options.keyframes.min_matches_last},
        {"min_matches_before_last", options.keyframes.min_matches_before_last},
        {"min_matches_stretch", options.keyframes.min_matches_stretch}}},
      {"planes",
       {{"seed", planes.seed},
        {"max_ratio", planes.match.max_ratio},
        {"max_error_px", planes.segmentation.ransac.max_error_px},
        {"min_inliers", planes.segmentation.min_inliers},
        {"min_vote_share", planes.min_vote_share},
        {"plenty_of_features", planes.plenty_of_features},
        {"votes_in_plenty", planes.votes_in_plenty},
        {"min_features", planes.min_features}}},
      {"appearance",
       {{"rows", options.appearance.describe.signature.rows},
        {"k1", options.appearance.describe.signature.k1},
        {"k2", options.appearance.describe.signature.k2},
        {"node_features", options.appearance.describe.features.max_kept},
        {"max_span", options.appearance.odometry.max_span},
        {"close_loops", options.appearance.close_loops},
        {"max_loss", options.appearance.redundancy.max_loss}}},
      {"orientation",
       {{"step", options.orientation.step},
        {"detector", NameOf(options.orientation.segments.detector)},
        {"max_kept", options.orientation.bearings.max_kept}}}};
  return json.dump();
}

MapInfo InfoOf(const BuildOptions& options) {
  MapInfo info;
  info.name = options.map_name;
  info.program = std::string("waystone ") + kVersion;
  info.feature_type = options.features.type;
  info.options_json = OptionsJson(options);
  return info;
}

// The state of a build: what the serial end of the pipeline feeds.
class MapBuilder {
 public:
  MapBuilder(const BuildOptions& options, const std::function<bool(const BuildProgress&)>& progress)
      : options_(options),
        progress_(progress),
        tracker_(options.planes),
        calibration_(options.calibration.max_keyframes) {}

  void AddSource(Source& source) {
    Sequence sequence;
    sequence.id = SequenceId{static_cast<int64_t>(map_.sequences.size()) + 1};
    sequence.name = source.name();
    sequence.kind = source.kind();
    sequence.camera = source.camera();
    map_.sequences.push_back(sequence);
    KeyframeSelector selector(options_.keyframes, options_.planes.match);
    TakeFrames(source, selector);
    AddKeyframes([&] { return selector.Finish(); });
  }

  BuildResult Finish() {
    tracker_.Finish();
    if (report_.frames == report_.skipped) FailWithoutFrames();
    map_.planes = std::move(tracker_.planes());
    CopyTrackerReport();
    std::sort(map_.planes.begin(), map_.planes.end(),
              [](const Plane& a, const Plane& b) { return a.id < b.id; });
    TakeEdges();
    if (!Report("fusion", 0, 1)) Interrupt();
    const Clock::time_point start = Clock::now();
    FusionResult fusion = FusePlanes(std::move(map_.planes), std::move(map_.edges), map_.keyframes,
                                     options_.features.type, options_.planes);
    map_.planes = std::move(fusion.planes);
    map_.edges = std::move(fusion.edges);
    report_.planes_fused = fusion.fused;
    DropSparse();
    report_.fusion_s = SecondsSince(start);
    Renumber();
    map_.info = InfoOf(options_);
    map_.index = IndexFeatures(map_);
    Calibrate();
    if (!Report("fusion", 1, 1)) Interrupt();
    return {std::move(map_), std::move(report_)};
  }

 private:
  void TakeFrames(Source& source, KeyframeSelector& selector) {
    const int total = source.size();
    int done = 0;
    bool stopped = false;
    const ExtractFramesOptions extract{options_.features,
                                       options_.images ? options_.image_width : 0};
    ExtractFrames(source, extract, [&](WorkedFrame worked) {
      Consume(std::move(worked), selector);
      stopped = !Report("frames", ++done, std::max(total, done));
      return !stopped;
    });
    if (stopped) Interrupt();
  }

  void Consume(WorkedFrame worked, KeyframeSelector& selector) {
    ++report_.frames;
    ++map_.sequences.back().frames;
    report_.decode_s += worked.decode_s;
    report_.extract_s += worked.extract_s;
    if (!worked.error.empty()) {
      ++report_.skipped;
      ++map_.sequences.back().skipped;
      if (static_cast<int>(report_.skipped_names.size()) < kMaxNamedSkips) {
        report_.skipped_names.push_back(worked.frame.info.source + ": " + worked.error);
      }
      return;
    }
    AddKeyframes([&] { return selector.Add(std::move(worked.frame)); });
  }

  // Adds the keyframes that `choose` decides on; times both.
  template <class Choose>
  void AddKeyframes(Choose choose) {
    const Clock::time_point start = Clock::now();
    std::vector<ChosenKeyframe> chosen = choose();
    report_.choose_s += SecondsSince(start);
    for (const ChosenKeyframe& keyframe : chosen) AddKeyframe(keyframe);
    report_.track_s += SecondsSince(start);
  }

  void AddKeyframe(const ChosenKeyframe& chosen) {
    Keyframe keyframe;
    keyframe.id = KeyframeId{static_cast<int64_t>(map_.keyframes.size()) + 1};
    keyframe.sequence = map_.sequences.back().id;
    report_.stretches += chosen.starts_stretch;
    keyframe.stretch = report_.stretches - 1;
    keyframe.frame = chosen.frame.info.number;
    keyframe.source = chosen.frame.info.source;
    keyframe.time_s = chosen.frame.info.time_s;
    keyframe.width = chosen.frame.features.width;
    keyframe.height = chosen.frame.features.height;
    if (!chosen.frame.thumbnail.empty()) {
      cv::imencode(".jpg", chosen.frame.thumbnail, keyframe.jpeg,
                   {cv::IMWRITE_JPEG_QUALITY, kThumbnailQuality});
    }
    tracker_.AddKeyframe(keyframe.id, chosen.frame.features, chosen.starts_stretch,
                         map_.sequences.back().camera);
    calibration_.Add(keyframe.id, chosen.frame.features);
    map_.keyframes.push_back(std::move(keyframe));
  }

  // Last, so that fusion sees all that planes have in common.
  void DropSparse() {
    for (Plane& plane : map_.planes) {
      const size_t before = plane.features.size();
      DropSparseFeatures(options_.planes.plenty_of_features, options_.planes.votes_in_plenty,
                         plane);
      report_.features_dropped += static_cast<int>(before - plane.features.size());
    }
  }

  // Asks the finished map for its own keyframes.
  void Calibrate() {
    const Clock::time_point start = Clock::now();
    MapData copy = map_;
    for (Keyframe& keyframe : copy.keyframes) keyframe.jpeg.clear();
    map_.verdict = CalibrateVerdict(
        *MapIndex::Build(std::move(copy)), calibration_.queries(),
        RenderedNegatives(options_.calibration.rendered_negatives, options_.features),
        options_.calibration);
    report_.calibrate_s = SecondsSince(start);
  }

  [[noreturn]] static void Interrupt() {
    throw MapError(ErrorCode::kInterrupted, "interrupted; nothing was written");
  }

  [[noreturn]] void FailWithoutFrames() const {
    const std::string first =
        report_.skipped_names.empty() ? "" : " (first: " + report_.skipped_names.front() + ")";
    throw MapError(ErrorCode::kBadSource, "none of the " + std::to_string(report_.frames) +
                                              " frames could be decoded" + first +
                                              "; check that the images open in a viewer");
  }

  void CopyTrackerReport() {
    const TrackerReport& tracker = tracker_.report();
    report_.rotation_only = tracker.rotation_only;
    report_.planes_started = tracker.started;
    report_.planes_rejected = tracker.rejected;
    report_.planes_merged = tracker.merged;
    report_.planes_dropped = tracker.dropped;
    report_.features_dropped = tracker.features_dropped;
  }

  // Edges between planes that are left.
  void TakeEdges() {
    std::set<PlaneId> ids;
    for (const Plane& plane : map_.planes) ids.insert(plane.id);
    for (const Edge& edge : tracker_.edges()) {
      if (ids.contains(edge.a) && ids.contains(edge.b)) map_.edges.push_back(edge);
    }
    std::sort(map_.edges.begin(), map_.edges.end(), [](const Edge& x, const Edge& y) {
      return std::pair(x.a, x.b) < std::pair(y.a, y.b);
    });
  }

  // Ids without gaps, in the order in which the planes were found.
  void Renumber() {
    std::map<PlaneId, PlaneId> renumbered;
    for (Plane& plane : map_.planes) {
      const PlaneId id{static_cast<int64_t>(renumbered.size()) + 1};
      renumbered[plane.id] = id;
      plane.id = id;
      plane.outline = OutlineOf(plane.features);
    }
    for (Edge& edge : map_.edges) {
      edge.a = renumbered.at(edge.a);
      edge.b = renumbered.at(edge.b);
    }
  }

  bool Report(const std::string& stage, int done, int total) {
    if (!progress_) return true;
    return progress_(
        {stage, done, total, static_cast<int>(map_.keyframes.size()),
         map_.planes.empty() ? tracker_.plane_count() : static_cast<int>(map_.planes.size())});
  }

  const BuildOptions& options_;
  const std::function<bool(const BuildProgress&)>& progress_;
  PlaneTracker tracker_;
  CalibrationSample calibration_;
  MapData map_;
  BuildReport report_;
};

using Progress = std::function<bool(const BuildProgress&)>;

// Adds the appearance layer of the sources; its sequences come after those that are there.
void AddAppearance(const std::vector<Source*>& sources, const BuildOptions& options,
                   const Progress& progress, BuildResult& result) {
  int panoramas = 0;
  const AppearanceProgress report = [&](const std::string& stage, int done, int total) {
    if (stage == "panoramas") panoramas = done;
    return !progress || progress({stage, done, total, static_cast<int>(result.map.keyframes.size()),
                                  static_cast<int>(result.map.planes.size()), panoramas});
  };
  AppearanceOptions appearance = options.appearance;
  if (!options.images) appearance.describe.image_width = 0;
  appearance.max_samples = options.appearance_calibration.max_nodes;
  appearance.describe.features.extract.bearings.features.type = options.features.type;
  AppearanceResult built = BuildAppearanceLayer(sources, appearance, report);
  const int64_t before = std::ssize(result.map.sequences);
  for (Sequence& sequence : built.sequences) {
    sequence.id.value += before;
    result.map.sequences.push_back(std::move(sequence));
  }
  for (AppearanceNode& node : built.layer.nodes) node.sequence.value += before;
  result.map.appearance = std::move(built.layer);
  result.report.appearance = std::move(built.report);
  result.map.info = InfoOf(options);
  const Clock::time_point start = Clock::now();
  CalibrateAppearanceLayer(result.map, built.samples, options.appearance_calibration,
                           [&] { return report("calibration", 0, 1); });
  result.report.appearance->calibrate_s = SecondsSince(start);
}

BuildResult BuildPlanes(const std::vector<Source*>& sources, const BuildOptions& options,
                        const Progress& progress) {
  MapBuilder builder(options, progress);
  for (Source* source : sources) builder.AddSource(*source);
  return builder.Finish();
}

// The sources of each layer. A layer that was asked for and gets none is a mistake.
std::vector<Source*> SourcesOf(LayerKind kind, bool asked, const char* what,
                               const std::vector<std::unique_ptr<Source>>& sources,
                               const LayerChoice& layers) {
  std::vector<Source*> fitting;
  for (const std::unique_ptr<Source>& source : sources) {
    if (LayerOf(*source, layers) == kind) fitting.push_back(source.get());
  }
  if (asked && fitting.empty()) {
    throw MapError(ErrorCode::kBadSource,
                   "none of the " + std::to_string(sources.size()) + " sources " + what);
  }
  return fitting;
}

BuildResult BuildLayers(const std::vector<std::unique_ptr<Source>>& sources,
                        const BuildOptions& options, const Progress& progress) {
  const LayerChoice& layers = options.layers;
  auto planes = SourcesOf(LayerKind::kPlanes, layers.planes,
                          "are ordinary images, which the plane layer requires; omit planes, or "
                          "select that layer alone to treat panoramas as photos",
                          sources, layers);
  auto panoramas =
      SourcesOf(LayerKind::kAppearance, layers.appearance,
                "are panoramas (twice as wide as high, or rigs), which the appearance layer "
                "requires; select that layer alone to treat other images as panoramas",
                sources, layers);
  OrientationPass pass(options, progress);
  pass.Watch(1, planes);
  pass.Watch(std::ssize(planes) + 1, panoramas);
  const std::vector<Source*> alone = DirectionsAlone(sources, layers);
  if (layers.orientation && pass.empty() && alone.empty()) RefuseUncalibrated(sources.size());
  BuildResult result;
  if (!planes.empty()) result = BuildPlanes(planes, options, progress);
  result.map.info = InfoOf(options);
  if (!panoramas.empty()) AddAppearance(panoramas, options, progress, result);
  for (Source* source : alone) result.map.sequences.push_back(pass.Read(result.map, *source));
  pass.Finish(result);
  return result;
}

}  // namespace

void BuildOptions::Check() const {
  features.Check();
  keyframes.Check();
  planes.Check();
  appearance.Check();
  orientation.Check();
  calibration.Check();
  appearance_calibration.Check();
  if (image_width < 16 || image_width > 4096) {
    throw MapError(ErrorCode::kBadOptions, "image_width is " + std::to_string(image_width) +
                                               "; it must be between 16 and 4096");
  }
  if (threads < 0 || threads > 1024) {
    throw MapError(ErrorCode::kBadOptions, "threads is " + std::to_string(threads) +
                                               "; it must be between 0 (one per core) and 1024");
  }
}

BuildResult BuildMap(const std::vector<std::unique_ptr<Source>>& sources,
                     const BuildOptions& options,
                     const std::function<bool(const BuildProgress&)>& progress) {
  options.Check();
  if (sources.empty())
    throw MapError(ErrorCode::kBadSource, "no source given; at least one is required");
  const Clock::time_point start = Clock::now();
  cv::setNumThreads(1);  // frames are what runs in parallel
  tbb::task_arena arena(options.threads == 0 ? tbb::task_arena::automatic : options.threads);
  return arena.execute([&] {
    BuildResult result = BuildLayers(sources, options, progress);
    result.report.total_s = SecondsSince(start);
    return result;
  });
}

}  // namespace waystone
