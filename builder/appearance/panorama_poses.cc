// SPDX-License-Identifier: Apache-2.0
#include "builder/appearance/panorama_poses.h"

#include <algorithm>
#include <functional>
#include <string>
#include <utility>

#include "core/base/clock.h"

namespace waystone {
namespace {

constexpr double kGapSteps = 5;  // between sequences that nothing ties together

// The poses of panoramas, first by odometry and then by odometry and loops together.
class PoseEstimator {
 public:
  PoseEstimator(const TakenPanoramas& taken, const AppearanceOptions& options,
                ProgressReporter& progress)
      : taken_(taken), options_(options), progress_(progress) {}

  PanoramaPoses Estimate() {
    FollowAll();
    if (options_.close_loops) Close();
    LayOut();
    Optimise();
    return std::move(result_);
  }

 private:
  void FollowAll() {
    const Clock::time_point start = Clock::now();
    for (size_t s = 0; s < taken_.stretches.size(); ++s) {
      const auto go_on =
          Reporting("odometry", static_cast<int>(s), static_cast<int>(taken_.stretches.size()));
      go_on();
      const auto [first, last] = taken_.stretches[s];
      result_.trajectories.push_back(
          FollowPanoramas({taken_.signatures.begin() + first, taken_.signatures.begin() + last},
                          taken_.band, options_.odometry, go_on));
      result_.steps += static_cast<int>(result_.trajectories.back().steps.size());
      result_.uncertain += result_.trajectories.back().uncertain;
    }
    result_.odometry_s = SecondsSince(start);
  }

  void Close() {
    const Clock::time_point start = Clock::now();
    const auto go_on = Reporting("loops", 0, 1);
    go_on();
    result_.closure = CloseLoops(taken_.signatures, taken_.band, taken_.stretches,
                                 result_.trajectories, options_.odometry, options_.loops, go_on);
    result_.loops_s = SecondsSince(start);
  }

  // Start of the optimisation: each sequence is placed by its surest loop to those before it.
  void LayOut() {
    double lowest = 0;
    for (size_t s = 0; s < taken_.stretches.size(); ++s) {
      Pose2 layer_from_first;
      const PanoramaRelation* tie = s == 0 ? nullptr : SurestTie(static_cast<int>(s));
      if (tie != nullptr) {
        layer_from_first =
            result_.odometry[tie->a] * tie->a_from_b *
            Inverse(result_.trajectories[s].poses[tie->b - taken_.stretches[s].first]);
      } else if (s > 0) {
        layer_from_first.y =
            lowest - Top(result_.trajectories[s]) - kGapSteps * result_.trajectories[s].mean_step;
      }
      for (const Pose2& pose : result_.trajectories[s].poses) {
        result_.odometry.push_back(layer_from_first * pose);
        lowest = std::min(lowest, result_.odometry.back().y);
      }
    }
  }

  static double Top(const VisualOdometry& trajectory) {
    double top = 0;
    for (const Pose2& pose : trajectory.poses) top = std::max(top, pose.y);
    return top;
  }

  // The loop with the least sigma to an earlier sequence.
  const PanoramaRelation* SurestTie(int s) const {
    const PanoramaRelation* surest = nullptr;
    for (const PanoramaRelation& loop : result_.closure.loops) {
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

  void Optimise() {
    LoopClosure& closure = result_.closure;
    const Clock::time_point start = Clock::now();
    progress_.Report("poses", 0, 1);
    result_.poses = result_.odometry;
    if (closure.loops.empty()) return;
    std::vector<PoseEdge> edges;
    for (size_t s = 0; s < taken_.stretches.size(); ++s) {
      for (PoseEdge edge : result_.trajectories[s].edges) {
        edge.a += taken_.stretches[s].first;
        edge.b += taken_.stretches[s].first;
        edges.push_back(edge);
      }
    }
    const size_t of_odometry = edges.size();
    edges.insert(edges.end(), closure.edges.begin(), closure.edges.end());
    PoseGraphResult optimised = OptimisePoseGraph(result_.odometry, edges, options_.graph);
    result_.poses = std::move(optimised.poses);
    std::vector<PanoramaRelation> kept;
    for (size_t i = 0; i < closure.loops.size(); ++i) {
      if (!optimised.rejected[of_odometry + i]) kept.push_back(closure.loops[i]);
    }
    result_.loops_rejected = static_cast<int>(closure.loops.size() - kept.size());
    closure.loops = std::move(kept);
    result_.graph_s = SecondsSince(start);
  }

  // A callback that reports the stage again, from any of its threads, and may stop it.
  std::function<void()> Reporting(const std::string& stage, int done, int total) {
    return [this, stage, done, total] { progress_.Report(stage, done, total); };
  }

  const TakenPanoramas& taken_;
  const AppearanceOptions& options_;
  ProgressReporter& progress_;
  PanoramaPoses result_;
};

}  // namespace

PanoramaPoses EstimatePanoramaPoses(const TakenPanoramas& taken, const AppearanceOptions& options,
                                    ProgressReporter& progress) {
  return PoseEstimator(taken, options, progress).Estimate();
}

}  // namespace waystone
