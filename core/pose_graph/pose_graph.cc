// SPDX-License-Identifier: Apache-2.0
#include "core/pose_graph/pose_graph.h"

#include <ceres/ceres.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>
#include <optional>
#include <string>

#include "core/base/check.h"
#include "core/base/error.h"

namespace waystone {
namespace {

// Factor from one width of the robust loss to the next.
constexpr double kNarrowing = 2;
constexpr double kWidest = 1e6;  // sigmas: larger differences aren't drift

using Block = std::array<double, 3>;  // x, y, theta

// WrappedAngle for Ceres' dual numbers too, which have no remainder.
template <class T>
T Wrapped(const T& angle) {
  using std::floor;
  constexpr double kTurn = 2 * std::numbers::pi;
  return angle - kTurn * floor((angle + std::numbers::pi) / kTurn);
}

// The residual of an edge between two poses, in the edge's sigmas.
struct EdgeResidual {
  const PoseEdge& edge;

  template <class T>
  bool operator()(const T* a, const T* b, const T* log_scale, T* residual) const {
    using std::cos;
    using std::exp;
    using std::sin;
    const T c = cos(a[2]);
    const T s = sin(a[2]);
    const T dx = b[0] - a[0];
    const T dy = b[1] - a[1];
    const T scale = exp(*log_scale);
    residual[0] = (c * dx + s * dy - scale * edge.a_from_b.x) / edge.position_sigma;
    residual[1] = (c * dy - s * dx - scale * edge.a_from_b.y) / edge.position_sigma;
    residual[2] = Wrapped(b[2] - a[2] - edge.a_from_b.theta_rad) / edge.heading_sigma_rad;
    return true;
  }
};

struct ScalePrior {
  double sigma;

  template <class T>
  bool operator()(const T* log_scale, T* residual) const {
    residual[0] = *log_scale / sigma;
    return true;
  }
};

// For each pose, the lowest pose of its connected part.
std::vector<int> PartOfPoses(int poses, const std::vector<PoseEdge>& edges) {
  std::vector<int> parent(poses);
  std::iota(parent.begin(), parent.end(), 0);
  const auto root = [&](int i) {
    while (parent[i] != i) i = parent[i] = parent[parent[i]];
    return i;
  };
  for (const PoseEdge& edge : edges) {
    const int a = root(edge.a);
    const int b = root(edge.b);
    parent[std::max(a, b)] = std::min(a, b);
  }
  std::vector<int> part;
  for (int i = 0; i < poses; ++i) part.push_back(root(i));
  return part;
}

class Optimiser {
 public:
  Optimiser(const std::vector<Pose2>& start, const std::vector<PoseEdge>& edges,
            const PoseGraphOptions& options)
      : edges_(edges), options_(options) {
    for (const Pose2& pose : start) blocks_.push_back({pose.x, pose.y, pose.theta_rad});
    int groups = 1;
    for (const PoseEdge& edge : edges) groups = std::max(groups, edge.scale_group + 1);
    log_scales_.assign(groups, 0.0);
    result_.rejected.assign(edges.size(), false);
  }

  PoseGraphResult Run() {
    const bool has_loops =
        std::any_of(edges_.begin(), edges_.end(), [](const PoseEdge& edge) { return edge.loop; });
    if (has_loops) {
      SolveRobustly();
      RejectLoops();
    }
    Solve({});
    return Finish();
  }

 private:
  // Graduated non-convexity (Yang et al. 2020): a drift of many sigmas would let the robust
  // loss give up right loops at once, so at first it is as wide as the worst of them and then
  // narrows.
  void SolveRobustly() {
    double width = options_.loop_loss;
    for (const PoseEdge& edge : edges_) {
      if (edge.loop) width = std::max(width, std::min(Residual(edge), kWidest));
    }
    for (; width > options_.loop_loss; width /= kNarrowing) Solve(width);
    Solve(options_.loop_loss);
  }

  // Solves with a loss of this width on loop edges, or without one.
  void Solve(std::optional<double> loop_loss) {
    ceres::Problem problem;
    AddScales(problem);
    for (size_t i = 0; i < edges_.size(); ++i) {
      if (!result_.rejected[i]) AddEdge(edges_[i], loop_loss, problem);
    }
    const std::vector<int> part = PartOfPoses(static_cast<int>(blocks_.size()), KeptEdges());
    for (size_t i = 0; i < blocks_.size(); ++i) {
      double* block = blocks_[i].data();
      if (part[i] == static_cast<int>(i) && problem.HasParameterBlock(block)) {
        problem.SetParameterBlockConstant(block);
      }
    }
    ceres::Solver::Options solver;
    solver.num_threads = 1;
    solver.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
    solver.max_num_iterations = options_.max_iterations;
    solver.function_tolerance = 1e-10;
    solver.logging_type = ceres::SILENT;
    ceres::Solver::Summary summary;
    ceres::Solve(solver, &problem, &summary);
  }

  void AddScales(ceres::Problem& problem) {
    for (size_t group = 0; group < log_scales_.size(); ++group) {
      problem.AddParameterBlock(&log_scales_[group], 1);
      if (group == 0) {
        problem.SetParameterBlockConstant(&log_scales_[0]);
        continue;
      }
      problem.AddResidualBlock(new ceres::AutoDiffCostFunction<ScalePrior, 1, 1>(
                                   new ScalePrior{options_.log_scale_sigma}),
                               nullptr, &log_scales_[group]);
    }
  }

  void AddEdge(const PoseEdge& edge, std::optional<double> loop_loss, ceres::Problem& problem) {
    ceres::LossFunction* loss =
        loop_loss && edge.loop ? new ceres::CauchyLoss(*loop_loss) : nullptr;
    problem.AddResidualBlock(
        new ceres::AutoDiffCostFunction<EdgeResidual, 3, 3, 3, 1>(new EdgeResidual{edge}), loss,
        blocks_[edge.a].data(), blocks_[edge.b].data(), &log_scales_[edge.scale_group]);
  }

  std::vector<PoseEdge> KeptEdges() const {
    std::vector<PoseEdge> kept;
    for (size_t i = 0; i < edges_.size(); ++i) {
      if (!result_.rejected[i]) kept.push_back(edges_[i]);
    }
    return kept;
  }

  double Residual(const PoseEdge& edge) const {
    std::array<double, 3> r{};
    EdgeResidual{edge}(blocks_[edge.a].data(), blocks_[edge.b].data(),
                       &log_scales_[edge.scale_group], r.data());
    return std::hypot(r[0], r[1], r[2]);
  }

  void RejectLoops() {
    for (size_t i = 0; i < edges_.size(); ++i) {
      result_.rejected[i] = edges_[i].loop && Residual(edges_[i]) > options_.reject_beyond;
    }
  }

  PoseGraphResult Finish() {
    for (const Block& block : blocks_) {
      result_.poses.push_back({block[0], block[1], WrappedAngle(block[2])});
    }
    for (const double log_scale : log_scales_) result_.scales.push_back(std::exp(log_scale));
    return std::move(result_);
  }

  const std::vector<PoseEdge>& edges_;
  const PoseGraphOptions& options_;
  std::vector<Block> blocks_;
  std::vector<double> log_scales_;
  PoseGraphResult result_;
};

}  // namespace

void PoseGraphOptions::Check() const { CheckFields("pose_graph", *this); }

PoseGraphResult OptimisePoseGraph(const std::vector<Pose2>& start,
                                  const std::vector<PoseEdge>& edges,
                                  const PoseGraphOptions& options) {
  options.Check();
  const int count = static_cast<int>(start.size());
  for (const PoseEdge& edge : edges) {
    WS_CHECK(edge.a >= 0 && edge.b >= 0 && edge.a < count && edge.b < count && edge.a != edge.b,
             "an edge from " + std::to_string(edge.a) + " to " + std::to_string(edge.b));
    WS_CHECK(edge.position_sigma > 0 && edge.heading_sigma_rad > 0 && edge.scale_group >= 0,
             "an edge without sigmas or with a scale group below 0");
  }
  return Optimiser(start, edges, options).Run();
}

}  // namespace waystone
