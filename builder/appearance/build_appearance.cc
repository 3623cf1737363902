// SPDX-License-Identifier: Apache-2.0
#include "builder/appearance/build_appearance.h"

#include <algorithm>
#include <mutex>
#include <opencv2/core.hpp>
#include <utility>

#include "builder/appearance/appearance_graph.h"
#include "builder/appearance/take_panoramas.h"
#include "core/base/clock.h"
#include "core/base/error.h"
#include "core/base/option_range.h"

namespace waystone {
namespace {

constexpr double kGapSteps = 5;  // between sequences that nothing ties together
// A chain of headings is no better than its doubtful ones: with each tenth step in doubt hardly a
// stretch of twenty has none.
constexpr double kDoubtfulShare = 0.1;

// The poses of panoramas, by odometry and then by all that ties them together.
class LayerBuilder {
 public:
  LayerBuilder(TakenPanoramas taken, const AppearanceOptions& options,
               const AppearanceProgress& progress, AppearanceReport& report)
      : taken_(std::move(taken)), options_(options), progress_(progress), report_(report) {}

  AppearanceGraph Build() {
    FollowAll();
    LoopClosure closure;
    if (options_.close_loops) closure = Close();
    LayOut(closure);
    Optimise(closure);
    return MakeAppearanceGraph(std::move(taken_), trajectories_, closure, report_.poses, options_);
  }

 private:
  void FollowAll() {
    const Clock::time_point start = Clock::now();
    for (size_t s = 0; s < taken_.stretches.size(); ++s) {
      const auto go_on =
          GoOn("odometry", static_cast<int>(s), static_cast<int>(taken_.stretches.size()));
      go_on();
      const auto [first, last] = taken_.stretches[s];
      trajectories_.push_back(
          FollowPanoramas({taken_.signatures.begin() + first, taken_.signatures.begin() + last},
                          taken_.band, options_.odometry, go_on));
      report_.steps += static_cast<int>(trajectories_.back().steps.size());
      report_.uncertain += trajectories_.back().uncertain;
    }
    report_.odometry_s = SecondsSince(start);
  }

  LoopClosure Close() {
    const Clock::time_point start = Clock::now();
    const auto go_on = GoOn("loops", 0, 1);
    go_on();
    LoopClosure closure = CloseLoops(taken_.signatures, taken_.band, taken_.stretches,
                                     trajectories_, options_.odometry, options_.loops, go_on);
    report_.loop_candidates = closure.candidates;
    report_.loops_certain = closure.certain;
    report_.loops_supported = static_cast<int>(closure.loops.size());
    report_.loops_s = SecondsSince(start);
    return closure;
  }

  // Start of the optimisation: each sequence where its surest loop to those before it puts it.
  void LayOut(const LoopClosure& closure) {
    double lowest = 0;
    for (size_t s = 0; s < taken_.stretches.size(); ++s) {
      Pose2 layer_from_first;
      const PanoramaRelation* tie = s == 0 ? nullptr : SurestTie(closure, static_cast<int>(s));
      if (tie != nullptr) {
        layer_from_first = report_.odometry[tie->a] * tie->a_from_b *
                           Inverse(trajectories_[s].poses[tie->b - taken_.stretches[s].first]);
      } else if (s > 0) {
        layer_from_first.y =
            lowest - Top(trajectories_[s]) - kGapSteps * trajectories_[s].mean_step;
      }
      for (const Pose2& pose : trajectories_[s].poses) {
        report_.odometry.push_back(layer_from_first * pose);
        lowest = std::min(lowest, report_.odometry.back().y);
      }
    }
  }

  static double Top(const VisualOdometry& trajectory) {
    double top = 0;
    for (const Pose2& pose : trajectory.poses) top = std::max(top, pose.y);
    return top;
  }

  // The loop of the least sigma from a sequence before it.
  const PanoramaRelation* SurestTie(const LoopClosure& closure, int s) const {
    const PanoramaRelation* surest = nullptr;
    for (const PanoramaRelation& loop : closure.loops) {
      if (loop.a >= taken_.stretches[s].first || loop.b < taken_.stretches[s].first ||
          loop.b >= taken_.stretches[s].last) {
        continue;
      }
      if (surest == nullptr || loop.heading.sigma_rad < surest->heading.sigma_rad) {
        surest = &loop;
      }
    }
    return surest;
  }

  void Optimise(LoopClosure& closure) {
    const Clock::time_point start = Clock::now();
    GoOn("poses", 0, 1)();
    report_.poses = report_.odometry;
    if (closure.loops.empty()) return;
    std::vector<PoseEdge> edges;
    for (size_t s = 0; s < taken_.stretches.size(); ++s) {
      for (PoseEdge edge : trajectories_[s].edges) {
        edge.a += taken_.stretches[s].first;
        edge.b += taken_.stretches[s].first;
        edges.push_back(edge);
      }
    }
    const size_t of_odometry = edges.size();
    edges.insert(edges.end(), closure.edges.begin(), closure.edges.end());
    PoseGraphResult optimised = OptimisePoseGraph(report_.odometry, edges, options_.graph);
    report_.poses = std::move(optimised.poses);
    std::vector<PanoramaRelation> kept;
    for (size_t i = 0; i < closure.loops.size(); ++i) {
      if (!optimised.rejected[of_odometry + i]) kept.push_back(closure.loops[i]);
    }
    report_.loops_rejected = static_cast<int>(closure.loops.size() - kept.size());
    closure.loops = std::move(kept);
    report_.graph_s = SecondsSince(start);
  }

  // What stops a stage on the way, from whichever of its threads.
  std::function<void()> GoOn(const std::string& stage, int done, int total) {
    return [this, stage, done, total] {
      const std::lock_guard lock(reporting_);
      if (!progress_ || progress_(stage, done, total)) return;
      throw MapError(ErrorCode::kInterrupted, "interrupted; nothing was written");
    };
  }

  TakenPanoramas taken_;
  const AppearanceOptions& options_;
  const AppearanceProgress& progress_;
  AppearanceReport& report_;
  std::vector<VisualOdometry> trajectories_;
  std::mutex reporting_;  // one call at a time
};

}  // namespace

bool AppearanceReport::IsTrajectoryDoubtful() const { return uncertain > kDoubtfulShare * steps; }

void AppearanceOptions::Check() const {
  describe.Check();
  odometry.Check();
  loops.Check();
  graph.Check();
  redundancy.Check();
  CheckRange("max_skipped_share", max_skipped_share, 0, 1);
  CheckRange("max_samples", max_samples, 0, 100'000);
}

AppearanceResult BuildAppearanceLayer(const std::vector<Source*>& sources,
                                      const AppearanceOptions& options,
                                      const AppearanceProgress& progress) {
  options.Check();
  if (sources.empty())
    throw MapError(ErrorCode::kBadSource, "no source given; at least one is required");
  cv::setNumThreads(1);  // frames are what runs in parallel
  const Clock::time_point start = Clock::now();
  AppearanceResult result;
  PanoramaTaker taker(options, progress, result.report);
  for (Source* source : sources) taker.Add(*source);
  TakenPanoramas taken = taker.Finish();
  result.sequences = taken.sequences;
  result.report.panoramas = taken.size();
  AppearanceGraph graph = LayerBuilder(std::move(taken), options, progress, result.report).Build();
  result.layer = std::move(graph.layer);
  result.samples = std::move(graph.samples);
  result.report.dropped = result.layer.dropped;
  result.report.total_s = SecondsSince(start);
  return result;
}

}  // namespace waystone
