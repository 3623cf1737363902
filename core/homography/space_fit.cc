// SPDX-License-Identifier: Apache-2.0
#include "core/homography/space_fit.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/geometry/linear_algebra.h"
#include "core/geometry/rotation.h"

namespace waystone {
namespace {

constexpr double kLargestCost = 25;  // of a point: beyond 5 sigmas it is simply wrong
constexpr double kFirstDamping = 1e-3;
constexpr double kLargestDamping = 1e8;
constexpr double kSmallestGain = 1e-9;  // of the cost, as a share of it

using Rows = Eigen::Matrix<double, 2, 3>;

// Where a motion moves a plane's point, before the division: R x + t (m . x).
Eigen::Vector3d Moved(const ViewMotion& motion, const Eigen::Vector3d& m,
                      const Eigen::Vector2d& a) {
  const Eigen::Vector3d x = a.homogeneous();
  return motion.rotation * x + motion.translation * m.dot(x);
}

// Error of a point in sigmas; nothing for one behind either camera.
std::optional<Eigen::Vector2d> ComputeError(const ViewMotion& motion, const Eigen::Vector3d& m,
                                            const Eigen::Vector2d& a, const Eigen::Vector2d& b,
                                            double sigma) {
  const Eigen::Vector3d y = Moved(motion, m, a);
  if (y.z() <= 1e-9 || m.dot(a.homogeneous()) <= 0) return std::nullopt;
  return (y.hnormalized() - b) / sigma;
}

// Geman and McClure's cost of a squared sigma, which levels off at kLargestCost.
double Robust(double squared) { return squared * kLargestCost / (squared + kLargestCost); }
double RobustWeight(double squared) {
  const double share = kLargestCost / (squared + kLargestCost);
  return share * share;
}

// The normal equations of a model: three parameters a known plane, then six a known view (rotation
// vector on the left, translation).
struct Equations {
  Eigen::MatrixXd normal;
  Eigen::VectorXd right;
  double weighted = 0;  // sum of weighted squared errors
  double weights = 0;
};

struct Columns {
  std::vector<int> plane;
  std::vector<int> view;
  int size = 0;
};

Columns LayOutColumns(const SpaceModel& model) {
  Columns columns;
  for (const auto& plane : model.planes) {
    columns.plane.push_back(columns.size);
    columns.size += plane ? 3 : 0;
  }
  for (const auto& view : model.views) {
    columns.view.push_back(columns.size);
    columns.size += view ? 6 : 0;
  }
  return columns;
}

void AddPoint(const ViewMotion& motion, const Eigen::Vector3d& m, const Eigen::Vector2d& a,
              const Eigen::Vector2d& b, double sigma, int plane, int view, Equations& equations) {
  const auto error = ComputeError(motion, m, a, b, sigma);
  if (!error) return;
  const Eigen::Matrix<double, 2, 9> j = SpaceJacobian(motion, m, a, sigma);
  const double weight = RobustWeight(error->squaredNorm());
  const Eigen::Matrix<double, 9, 9> block = weight * j.transpose() * j;
  const Eigen::Matrix<double, 9, 1> right = -weight * j.transpose() * *error;
  equations.normal.block<3, 3>(plane, plane) += block.topLeftCorner<3, 3>();
  equations.normal.block<6, 6>(view, view) += block.bottomRightCorner<6, 6>();
  equations.normal.block<3, 6>(plane, view) += block.topRightCorner<3, 6>();
  equations.normal.block<6, 3>(view, plane) += block.bottomLeftCorner<6, 3>();
  equations.right.segment<3>(plane) += right.head<3>();
  equations.right.segment<6>(view) += right.tail<6>();
  equations.weighted += weight * error->squaredNorm();
  equations.weights += weight;
}

Equations SumEquations(const SpaceModel& model, const Columns& columns,
                       std::span<const PlaneSighting> sightings, double sigma) {
  Equations equations;
  equations.normal = Eigen::MatrixXd::Zero(columns.size, columns.size);
  equations.right = Eigen::VectorXd::Zero(columns.size);
  for (const PlaneSighting& seen : sightings) {
    const auto& m = model.planes[seen.plane];
    const auto& motion = model.views[seen.view];
    if (!m || !motion) continue;
    for (int i = 0; i < seen.points.size(); ++i) {
      AddPoint(*motion, *m, seen.points.a[i], seen.points.b[i], sigma, columns.plane[seen.plane],
               columns.view[seen.view], equations);
    }
  }
  return equations;
}

SpaceModel Stepped(const SpaceModel& model, const Columns& columns, const Eigen::VectorXd& step) {
  SpaceModel next = model;
  for (size_t p = 0; p < next.planes.size(); ++p) {
    if (next.planes[p]) *next.planes[p] += step.segment<3>(columns.plane[p]);
  }
  for (size_t v = 0; v < next.views.size(); ++v) {
    if (!next.views[v]) continue;
    next.views[v]->rotation =
        RotationByVector(step.segment<3>(columns.view[v])) * next.views[v]->rotation;
    next.views[v]->translation += step.segment<3>(columns.view[v] + 3);
  }
  return next;
}

}  // namespace

Eigen::Matrix<double, 2, 9> SpaceJacobian(const ViewMotion& motion, const Eigen::Vector3d& m,
                                          const Eigen::Vector2d& a, double sigma) {
  const Eigen::Vector3d x = a.homogeneous();
  const Eigen::Vector3d y = Moved(motion, m, a);
  Rows divide;
  divide << 1 / y.z(), 0, -y.x() / (y.z() * y.z()), 0, 1 / y.z(), -y.y() / (y.z() * y.z());
  divide /= sigma;
  Eigen::Matrix<double, 2, 9> j;
  j.leftCols<3>() = divide * motion.translation * x.transpose();
  j.middleCols<3>(3) = -divide * CrossMatrix(motion.rotation * x);
  j.rightCols<3>() = divide * m.dot(x);
  return j;
}

double ComputeCost(const SpaceModel& model, std::span<const PlaneSighting> sightings,
                   const SpaceOptions& options) {
  double cost = 0;
  for (const PlaneSighting& seen : sightings) {
    const auto& m = model.planes[seen.plane];
    const auto& motion = model.views[seen.view];
    for (int i = 0; i < seen.points.size(); ++i) {
      const auto error = m && motion ? ComputeError(*motion, *m, seen.points.a[i], seen.points.b[i],
                                                    options.point_sigma)
                                     : std::nullopt;
      cost += error ? Robust(error->squaredNorm()) : kLargestCost;
    }
  }
  return cost;
}

void RefineSpace(SpaceModel& model, std::span<const PlaneSighting> sightings,
                 const SpaceOptions& options, int steps) {
  const Columns columns = LayOutColumns(model);
  model.cost = ComputeCost(model, sightings, options);
  double damping = kFirstDamping;
  for (int i = 0; i < steps && damping < kLargestDamping; ++i) {
    const Equations equations = SumEquations(model, columns, sightings, options.point_sigma);
    Eigen::MatrixXd damped = equations.normal;
    damped.diagonal() *= 1 + damping;
    damped.diagonal().array() += 1e-9;  // the scale is free
    SpaceModel next = Stepped(model, columns, SolveSymmetric(damped, equations.right));
    next.cost = ComputeCost(next, sightings, options);
    if (!(next.cost < model.cost)) {
      damping *= 10;
      continue;
    }
    const bool settled = model.cost - next.cost < kSmallestGain * model.cost;
    model = std::move(next);
    damping = std::max(1e-9, damping / 10);
    if (settled) break;
  }
}

std::vector<std::optional<Eigen::Matrix3d>> PlaneCovariances(
    const SpaceModel& model, std::span<const PlaneSighting> sightings, const SpaceOptions& options,
    int unit_plane) {
  const Columns columns = LayOutColumns(model);
  Equations equations = SumEquations(model, columns, sightings, options.point_sigma);
  // The length of the unit plane's m is known: no other parameter tells the scale.
  const Eigen::Vector3d along = model.planes[unit_plane]->normalized();
  const double strength = 1e3 * equations.normal.diagonal().maxCoeff();
  equations.normal.block<3, 3>(columns.plane[unit_plane], columns.plane[unit_plane]) +=
      strength * along * along.transpose();
  // Directions that nothing determines keep a huge variance instead of none.
  equations.normal.diagonal().array() += 1e-6;
  const double freedom = std::max(1.0, 2 * equations.weights - columns.size);
  const double scale = std::max(1.0, equations.weighted / freedom);
  const Eigen::MatrixXd covariance = scale * InvertSymmetric(equations.normal);
  std::vector<std::optional<Eigen::Matrix3d>> planes(model.planes.size());
  for (size_t p = 0; p < planes.size(); ++p) {
    if (!model.planes[p]) continue;
    planes[p] = covariance.block<3, 3>(columns.plane[p], columns.plane[p]);
  }
  return planes;
}

}  // namespace waystone
