// SPDX-License-Identifier: Apache-2.0
#include "builder/appearance/appearance_layer.h"

#include <utility>

#include "builder/appearance/appearance_graph.h"
#include "builder/appearance/panorama_poses.h"

namespace waystone {
namespace {

// A chain of headings is no better than its doubtful ones: with one step in ten doubtful, only
// 0.9^20 = 12 % of the runs of twenty steps have none.
constexpr double kDoubtfulShare = 0.1;

const AppearanceOptions& Checked(const AppearanceOptions& options) {
  options.Check();
  return options;
}

void Report(const PanoramaPoses& poses, AppearanceReport& report) {
  report.steps = poses.steps;
  report.uncertain = poses.uncertain;
  report.loop_candidates = poses.closure.candidates;
  report.loops_certain = poses.closure.certain;
  report.loops_supported = static_cast<int>(poses.closure.loops.size()) + poses.loops_rejected;
  report.loops_rejected = poses.loops_rejected;
  report.odometry = poses.odometry;
  report.poses = poses.poses;
  report.odometry_s = poses.odometry_s;
  report.loops_s = poses.loops_s;
  report.graph_s = poses.graph_s;
}

}  // namespace

bool AppearanceReport::IsTrajectoryDoubtful() const { return uncertain > kDoubtfulShare * steps; }

AppearanceLayerBuilder::AppearanceLayerBuilder(const AppearanceOptions& options)
    : options_(Checked(options)), taker_(options_) {}

void AppearanceLayerBuilder::StartSequence(SequenceId id, const Source& source) {
  taker_.StartSequence(id, source.name());
}

std::unique_ptr<Observation> AppearanceLayerBuilder::Observe(const Frame& frame) const {
  return DescribePanorama(frame, options_.describe);
}

void AppearanceLayerBuilder::Add(std::unique_ptr<Observation> observation,
                                 ProgressReporter& progress) {
  progress.AddPanorama();
  auto& panorama = static_cast<DescribedPanorama&>(*observation);
  if (panorama.error.empty()) taker_.Take(std::move(panorama));
}

void AppearanceLayerBuilder::FinishSequence(const FrameReport& sequence) {
  taker_.FinishSequence(sequence);
  report_.Append(sequence);
}

void AppearanceLayerBuilder::Finish(MapData& map, ProgressReporter& progress) {
  TakenPanoramas taken = taker_.Finish();
  report_.panoramas = taken.size();
  const PanoramaPoses poses = EstimatePanoramaPoses(taken, options_, progress);
  Report(poses, report_);
  AppearanceGraph graph = MakeAppearanceGraph(std::move(taken), poses, options_);
  report_.dropped = graph.layer.dropped;
  map.appearance = std::move(graph.layer);
  samples_ = std::move(graph.samples);
}

}  // namespace waystone
