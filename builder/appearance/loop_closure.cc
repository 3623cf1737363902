// SPDX-License-Identifier: Apache-2.0
#include "builder/appearance/loop_closure.h"

#include <tbb/parallel_for.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "core/base/check.h"
#include "core/robust/median.h"

namespace waystone {
namespace {

constexpr int kUsualSamples = 64;  // panoramas from whose distances the usual one is taken
constexpr double kLeastSigma = 1e-6;

using Matrix = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// One row per panorama: its magnitudes of the lowest frequencies.
Matrix LowMagnitudes(const std::vector<FourierSignature>& signatures, int k1) {
  const Eigen::Index columns = std::min<Eigen::Index>(k1, signatures[0].magnitudes.cols());
  const Eigen::Index rows = signatures[0].magnitudes.rows();
  Matrix matrix(static_cast<Eigen::Index>(signatures.size()), rows * columns);
  for (size_t i = 0; i < signatures.size(); ++i) {
    const Matrix low = signatures[i].magnitudes.leftCols(columns).cast<float>();
    matrix.row(static_cast<Eigen::Index>(i)) =
        Eigen::Map<const Eigen::RowVectorXf>(low.data(), low.size());
  }
  return matrix;
}

class Closer {
 public:
  Closer(const std::vector<FourierSignature>& signatures,
         const std::vector<PanoramaStretch>& stretches,
         const std::vector<VisualOdometry>& trajectories, const VisualOdometryOptions& odometry,
         const LoopOptions& options, const std::function<void()>& before_each)
      : signatures_(signatures),
        stretches_(stretches),
        trajectories_(trajectories),
        odometry_(odometry),
        options_(options),
        before_each_(before_each),
        low_(LowMagnitudes(signatures, options.k1)),
        squares_(low_.rowwise().squaredNorm()) {
    for (size_t s = 0; s < stretches.size(); ++s) {
      stretch_of_.insert(stretch_of_.end(), stretches[s].last - stretches[s].first,
                         static_cast<int>(s));
    }
    WS_CHECK(stretch_of_.size() == signatures.size(), "stretches that don't cover the panoramas");
    FindUnits();
  }

  LoopClosure Run() {
    std::vector<PanoramaRelation> certain = Compare(Candidates());
    for (const PanoramaRelation& relation : certain) {
      if (Supporters(relation, certain) < options_.min_supporters) continue;
      result_.loops.push_back(relation);
      result_.edges.push_back(EdgeOf(relation));
    }
    return std::move(result_);
  }

 private:
  int size() const { return static_cast<int>(signatures_.size()); }

  bool MayBeLoop(int a, int b) const {
    return stretch_of_[a] != stretch_of_[b] || std::abs(a - b) >= options_.min_gap;
  }

  // The mean distance of a panorama's landmarks in the unit of the trajectory: the median over the
  // steps near it, since single ones are noisy. 0 where no step gives it.
  void FindUnits() {
    units_.assign(size(), 0);
    for (size_t s = 0; s < stretches_.size(); ++s) {
      const auto& steps = trajectories_[s].steps;
      const int count = stretches_[s].last - stretches_[s].first;
      for (int i = 0; i < count; ++i) {
        std::vector<double> units;
        const int last = std::min(i + options_.neighbourhood, static_cast<int>(steps.size()));
        for (int t = std::max(0, i - options_.neighbourhood); t < last; ++t) {
          const auto& motion = steps[t].heading.motion;
          if (!motion || motion->step_per_distance.value_or(0) <= 0) continue;
          units.push_back(std::hypot(steps[t].a_from_b.x, steps[t].a_from_b.y) /
                          *motion->step_per_distance);
        }
        units_[stretches_[s].first + i] = Median(std::move(units));
      }
    }
  }

  // The distances of a panorama to all before it.
  Eigen::RowVectorXf DistancesOf(int b) const {
    const Eigen::RowVectorXf dots = low_.row(b) * low_.topRows(b).transpose();
    return (squares_.head(b).transpose().array() + squares_(b) - 2 * dots.array())
        .max(0)
        // Not Eigen's square root, which starts from the processor's estimate: processors differ.
        .unaryExpr([](float square) { return std::sqrt(square); })
        .matrix();
  }

  // The median over panoramas spread over all.
  double UsualDistance() const {
    std::vector<double> distances;
    const int every = std::max(1, size() / kUsualSamples);
    for (int a = 0; a < size(); a += every) {
      for (int b = a + every; b < size(); b += every) {
        if (MayBeLoop(a, b)) distances.push_back((low_.row(a) - low_.row(b)).norm());
      }
    }
    return Median(std::move(distances));
  }

  std::vector<std::pair<int, int>> Candidates() const {
    const auto limit = static_cast<float>(options_.max_distance_share * UsualDistance());
    std::vector<std::vector<int>> nearest(size());
    tbb::parallel_for(0, size(), [&](int b) {
      if (b == 0) return;
      Eigen::RowVectorXf distances = DistancesOf(b);
      for (int a = 0; a < b; ++a) {
        if (!MayBeLoop(a, b)) distances(a) = std::numeric_limits<float>::max();
      }
      for (int i = 0; i < options_.candidates; ++i) {
        Eigen::Index best = 0;
        if (distances.minCoeff(&best) > limit) break;
        nearest[b].push_back(static_cast<int>(best));
        const Eigen::Index first = std::max<Eigen::Index>(0, best - options_.min_gap);
        const Eigen::Index last = std::min<Eigen::Index>(b, best + options_.min_gap);
        distances.segment(first, last - first).setConstant(std::numeric_limits<float>::max());
      }
    });
    std::vector<std::pair<int, int>> pairs;
    for (int b = 0; b < size(); ++b) {
      for (const int a : nearest[b]) pairs.emplace_back(a, b);
    }
    std::sort(pairs.begin(), pairs.end());
    return pairs;
  }

  // The relations of which the compass is certain.
  std::vector<PanoramaRelation> Compare(const std::vector<std::pair<int, int>>& pairs) {
    std::vector<std::optional<PanoramaRelation>> relations(pairs.size());
    tbb::parallel_for(size_t{0}, pairs.size(), [&](size_t i) {
      if (before_each_) before_each_();
      const auto [a, b] = pairs[i];
      relations[i] = Relation(a, b);
    });
    result_.candidates = static_cast<int>(pairs.size());
    std::vector<PanoramaRelation> certain;
    for (const auto& relation : relations) {
      if (relation) certain.push_back(*relation);
    }
    result_.certain = static_cast<int>(certain.size());
    return certain;
  }

  std::optional<PanoramaRelation> Relation(int a, int b) const {
    const CompassHeading heading =
        RelativeHeading(signatures_[a], signatures_[b], odometry_.compass);
    if (!heading.small_motion || heading.sigma_rad > options_.max_sigma_rad) return {};
    double length = 0;  // without a direction it is the same place
    double direction = 0;
    if (heading.motion) {
      if (!heading.motion->step_per_distance || units_[a] <= 0) return {};
      length = *heading.motion->step_per_distance * units_[a];
      direction = heading.motion->direction_rad;
    }
    return PanoramaRelation{
        a, b, SignatureDistance(signatures_[a], signatures_[b], odometry_.k1), heading,
        Pose2{length * std::cos(direction), length * std::sin(direction), heading.heading_rad}};
  }

  const Pose2& TrajectoryPose(int i) const {
    const int s = stretch_of_[i];
    return trajectories_[s].poses[i - stretches_[s].first];
  }

  double StepOf(int i) const { return trajectories_[stretch_of_[i]].mean_step; }

  // How many other relations in the neighbourhood of both panoramas agree.
  int Supporters(const PanoramaRelation& r, const std::vector<PanoramaRelation>& all) const {
    const auto is_near = [&](int i, int j) {
      return stretch_of_[i] == stretch_of_[j] && std::abs(i - j) <= options_.neighbourhood;
    };
    int count = 0;
    const auto begin =
        std::lower_bound(all.begin(), all.end(), r.a - options_.neighbourhood,
                         [](const PanoramaRelation& relation, int a) { return relation.a < a; });
    for (auto other = begin; other != all.end(); ++other) {
      if (other->a > r.a + options_.neighbourhood) break;
      const bool itself = other->a == r.a && other->b == r.b;
      if (!itself && is_near(other->a, r.a) && is_near(other->b, r.b) && Agree(r, *other)) ++count;
    }
    return count;
  }

  bool Agree(const PanoramaRelation& r, const PanoramaRelation& other) const {
    const Pose2 a_from_other_a = Inverse(TrajectoryPose(r.a)) * TrajectoryPose(other.a);
    const Pose2 other_b_from_b = Inverse(TrajectoryPose(other.b)) * TrajectoryPose(r.b);
    const Pose2 difference =
        Inverse(r.a_from_b) * (a_from_other_a * other.a_from_b * other_b_from_b);
    const double trajectory = std::hypot(a_from_other_a.x, a_from_other_a.y) +
                              std::hypot(other_b_from_b.x, other_b_from_b.y);
    return std::abs(difference.theta_rad) <= options_.agreement_rad &&
           std::hypot(difference.x, difference.y) <=
               options_.agreement_steps * StepOf(r.a) + options_.trajectory_share * trajectory;
  }

  PoseEdge EdgeOf(const PanoramaRelation& r) const {
    PoseEdge edge;
    edge.a = r.a;
    edge.b = r.b;
    edge.a_from_b = r.a_from_b;
    edge.position_sigma =
        std::max(kLeastSigma, options_.length_sigma * std::hypot(r.a_from_b.x, r.a_from_b.y) +
                                  options_.steps_sigma * StepOf(r.a));
    edge.heading_sigma_rad = std::max(kLeastSigma, r.heading.sigma_rad);
    edge.loop = true;
    return edge;
  }

  const std::vector<FourierSignature>& signatures_;
  const std::vector<PanoramaStretch>& stretches_;
  const std::vector<VisualOdometry>& trajectories_;
  const VisualOdometryOptions& odometry_;
  const LoopOptions& options_;
  const std::function<void()>& before_each_;
  Matrix low_;
  Eigen::VectorXf squares_;
  std::vector<int> stretch_of_;
  std::vector<double> units_;
  LoopClosure result_;
};

}  // namespace

void LoopOptions::Check() const { CheckFields("loops", *this); }

LoopClosure CloseLoops(const std::vector<FourierSignature>& signatures, const ElevationBand& band,
                       const std::vector<PanoramaStretch>& stretches,
                       const std::vector<VisualOdometry>& trajectories,
                       const VisualOdometryOptions& odometry, const LoopOptions& options,
                       const std::function<void()>& before_each) {
  options.Check();
  if (signatures.empty()) return {};
  VisualOdometryOptions of_band = odometry;
  of_band.compass.band = band;
  return Closer(signatures, stretches, trajectories, of_band, options, before_each).Run();
}

}  // namespace waystone
