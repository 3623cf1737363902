// SPDX-License-Identifier: Apache-2.0
#include "builder/build_map.h"

#include <tbb/task_arena.h>

#include <algorithm>
#include <array>
#include <utility>

#include "builder/calibration/link_revisits.h"
#include "builder/calibration/node_pose_calibration.h"
#include "builder/calibration/own_images.h"
#include "builder/calibration/pose_calibration.h"
#include "builder/frames/frame_pipeline.h"
#include "builder/layer_options.h"
#include "core/base/clock.h"
#include "core/base/error.h"
#include "core/image/opencv_errors.h"

namespace waystone {
namespace {

// Images whose features are returned besides those of keyframes: looking for one in a map takes
// about as long as extracting its features.
constexpr int kMostImages = 100;

PlaneBuildOptions OptionsOfPlanes(const BuildOptions& options, BuiltFeatures features) {
  PlaneBuildOptions planes = MakePlaneOptions(options);
  if (features == BuiltFeatures::kKeep) planes.max_images = kMostImages;
  return planes;
}

// The layers of a map, in the order of LayerKind.
class MapBuilder {
 public:
  MapBuilder(const BuildOptions& options, const ProgressCallback& progress,
             const std::optional<GivenPoses>& poses, BuiltFeatures features)
      : options_(options),
        poses_(poses),
        features_(features),
        progress_(progress),
        planes_(OptionsOfPlanes(options, features)),
        appearance_(MakeAppearanceOptions(options)),
        orientation_(MakeOrientationOptions(options)) {
    result_.map.info = MakeMapInfo(options);
  }

  BuildResult Build(const std::vector<AssignedSource>& sources) {
    for (const LayerKind kind :
         {LayerKind::kPlanes, LayerKind::kAppearance, LayerKind::kOrientation}) {
      bool used = false;
      for (const AssignedSource& source : sources) {
        if (source.layers.front() == kind) Read(source);
        for (const LayerKind layer : source.layers) used |= layer == kind;
      }
      if (used) Finish(kind);
    }
    if (poses_ && !result_.map.poses && !result_.report.planes) {
      throw MapError(ErrorCode::kBadRequest,
                     "poses were given, but no source has a layer to put into their frame; add "
                     "planes or appearance to --layers");
    }
    return std::move(result_);
  }

 private:
  LayerBuilder* BuilderOf(LayerKind kind) {
    return std::array<LayerBuilder*, 3>{&planes_, &appearance_,
                                        &orientation_}[static_cast<size_t>(kind)];
  }

  void Read(const AssignedSource& assigned) {
    std::vector<LayerBuilder*> layers;
    for (const LayerKind kind : assigned.layers) layers.push_back(BuilderOf(kind));
    std::vector<Sequence>& sequences = result_.map.sequences;
    const SequenceId id{std::ssize(sequences) + 1};
    sequences.push_back(
        ObserveSequence(*assigned.source, id, layers, progress_, options_.max_skipped_share));
  }

  void Finish(LayerKind kind) {
    BuilderOf(kind)->Finish(result_.map, progress_);
    switch (kind) {
      case LayerKind::kPlanes:
        CalibratePlanes();
        if (poses_) PutPlanesIntoFrame();
        return TakeFeatures();
      case LayerKind::kAppearance:
        if (poses_) PutPanoramasIntoFrame();
        return CalibrateAppearance();
      case LayerKind::kOrientation:
        result_.report.orientation = orientation_.report();
    }
  }

  void PutPlanesIntoFrame() {
    if (result_.map.keyframes.empty()) return;
    progress_.Report("structure", 0, 1);
    PoseReport report = AddPoses(planes_.features(), *poses_, options_.poses, result_.map);
    report.noise = MeasurePoseNoise(result_.map, planes_.samples(), options_.poses.neighbours,
                                    options_.calibration.localize.pose);
    result_.map.poses->noise = report.noise.noise;
    result_.report.poses = report;
    progress_.Report("structure", 1, 1);
  }

  // Frees their memory for the layers after this one.
  void TakeFeatures() {
    std::vector<WalkImage> features = planes_.TakeFeatures();
    if (features_ == BuiltFeatures::kKeep) result_.features = std::move(features);
  }

  // Before the verdict is calibrated, which depends on where nodes are.
  void PutPanoramasIntoFrame() {
    progress_.Report("structure", 0, 1);
    result_.report.node_poses =
        AddNodePoses(*poses_, options_.poses, result_.map, appearance_.samples());
    progress_.Report("structure", 1, 1);
  }

  void CalibratePlanes() {
    const Clock::time_point start = Clock::now();
    const PlaneQueryOptions& query = options_.calibration.localize.planes;
    constexpr int kSteps = 2;
    const int linked = LinkRevisits(planes_.features(), query, result_.map, progress_);
    progress_.Report("calibration", 0, kSteps);
    CalibratePlaneLayer(result_.map, planes_.samples(), options_.features, options_.calibration);
    progress_.Report("calibration", 1, kSteps);
    result_.report.planes = planes_.report();
    result_.report.planes->keyframes_linked = linked;
    result_.report.planes->own =
        FindOwnKeyframes(result_.map, planes_.samples(), options_.calibration.localize);
    result_.report.planes->calibrate_s = SecondsSince(start);
    progress_.Report("calibration", kSteps, kSteps);
  }

  void CalibrateAppearance() {
    const Clock::time_point start = Clock::now();
    const OwnImages own = CalibrateAppearanceLayer(result_.map, appearance_.samples(),
                                                   options_.appearance_calibration, progress_);
    if (result_.map.poses && !result_.map.poses->nodes.empty()) {
      MeasureNodePoseErrors(appearance_.samples(), options_.appearance_calibration.query,
                            result_.map, *result_.report.node_poses);
    }
    result_.report.appearance = appearance_.report();
    result_.report.appearance->own = own;
    result_.report.appearance->calibrate_s = SecondsSince(start);
  }

  const BuildOptions& options_;
  const std::optional<GivenPoses>& poses_;
  BuiltFeatures features_;
  ProgressReporter progress_;
  PlaneLayerBuilder planes_;
  AppearanceLayerBuilder appearance_;
  OrientationLayerBuilder orientation_;
  BuildResult result_;
};

}  // namespace

BuildResult BuildMap(const std::vector<std::unique_ptr<Source>>& sources,
                     const BuildOptions& options, const ProgressCallback& progress,
                     const std::optional<GivenPoses>& poses, BuiltFeatures features) {
  options.Check();
  if (sources.empty())
    throw MapError(ErrorCode::kBadSource, "no source given; at least one is required");
  const Clock::time_point start = Clock::now();
  cv::setNumThreads(1);  // frames run in parallel instead
  ThrowOpenCvErrors();
  const int most = tbb::this_task_arena::max_concurrency();  // TBB prints a warning for more
  tbb::task_arena arena(options.threads == 0 ? most : std::min(options.threads, most));
  return arena.execute([&] {
    BuildResult result = MapBuilder(options, progress, poses, features)
                             .Build(AssignSources(sources, options.layers));
    result.report.total_s = SecondsSince(start);
    return result;
  });
}

}  // namespace waystone
