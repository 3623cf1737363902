// SPDX-License-Identifier: Apache-2.0
#include "builder/appearance/visual_odometry.h"

#include <tbb/parallel_for.h>

#include <cmath>
#include <string>

#include "core/base/check.h"

namespace waystone {
namespace {

// Panoramas that are exactly alike: sigmas must be above 0.
constexpr double kLeastLength = 1e-6;
constexpr double kLeastSigma_rad = 1e-6;

bool StoodStill(const CompassHeading& heading) { return heading.small_motion && !heading.motion; }

double ChooseDirection(const CompassHeading& heading) {
  return heading.motion ? heading.motion->direction_rad : heading.heading_rad / 2;
}

Pose2 Step(double length, const CompassHeading& heading) {
  const double direction = ChooseDirection(heading);
  return {length * std::cos(direction), length * std::sin(direction), heading.heading_rad};
}

PoseEdge MakeSpanEdge(int a, int b, const Pose2& a_from_b, double position_sigma,
                      const CompassHeading& heading) {
  PoseEdge edge;
  edge.a = a;
  edge.b = b;
  edge.a_from_b = a_from_b;
  edge.position_sigma = std::max(position_sigma, kLeastLength);
  edge.heading_sigma_rad = std::max(heading.sigma_rad, kLeastSigma_rad);
  return edge;
}

class Follower {
 public:
  Follower(const std::vector<FourierSignature>& signatures, const ElevationBand& band,
           const VisualOdometryOptions& options, const std::function<void()>& before_each)
      : signatures_(signatures),
        options_(options),
        before_each_(before_each),
        compass_(options.compass) {
    compass_.band = band;
  }

  VisualOdometry Run() {
    if (signatures_.empty()) return {};
    AddSteps();
    for (int span = 2; span <= options_.max_span; span *= 2) AddSpans(span);
    if (trajectory_.edges.size() > trajectory_.steps.size()) {
      trajectory_.poses = OptimisePoseGraph(trajectory_.poses, trajectory_.edges).poses;
    }
    return std::move(trajectory_);
  }

 private:
  int size() const { return static_cast<int>(signatures_.size()); }

  std::vector<CompassHeading> HeadingsOver(int span) const {
    std::vector<CompassHeading> headings(std::max(0, size() - span));
    tbb::parallel_for(size_t{0}, headings.size(), [&](size_t a) {
      if (before_each_) before_each_();
      headings[a] = RelativeHeading(signatures_[a], signatures_[a + span], compass_);
    });
    return headings;
  }

  void AddSteps() {
    const std::vector<CompassHeading> headings = HeadingsOver(1);
    trajectory_.poses.emplace_back();
    double trajectory = 0;
    for (int a = 0; a + 1 < size(); ++a) {
      const CompassHeading& heading = headings[a];
      const double distance = SignatureDistance(signatures_[a], signatures_[a + 1], options_.k1);
      const Pose2 a_from_b = Step(StoodStill(heading) ? 0 : distance, heading);
      trajectory_.steps.push_back({a, a + 1, distance, heading, a_from_b});
      trajectory_.edges.push_back(
          MakeSpanEdge(a, a + 1, a_from_b, options_.length_sigma * distance, heading));
      trajectory_.poses.push_back(trajectory_.poses.back() * a_from_b);
      trajectory_.uncertain += heading.sigma_rad > options_.max_sigma_rad;
      trajectory += std::hypot(a_from_b.x, a_from_b.y);
    }
    trajectory_.mean_step = trajectory / std::max(1, size() - 1);
  }

  void AddSpans(int span) {
    const std::vector<CompassHeading> headings = HeadingsOver(span);
    for (int a = 0; a + span < size(); ++a) {
      const Pose2 by_steps = Inverse(trajectory_.poses[a]) * trajectory_.poses[a + span];
      const double length = std::hypot(by_steps.x, by_steps.y);
      const double sigma = options_.span_sigma * std::max(length, trajectory_.mean_step);
      trajectory_.edges.push_back(
          MakeSpanEdge(a, a + span, Step(length, headings[a]), sigma, headings[a]));
    }
  }

  const std::vector<FourierSignature>& signatures_;
  const VisualOdometryOptions& options_;
  const std::function<void()>& before_each_;
  CompassOptions compass_;
  VisualOdometry trajectory_;
};

}  // namespace

void VisualOdometryOptions::Check() const {
  CheckFields("odometry", *this);
  compass.Check();
}

double SignatureDistance(const FourierSignature& a, const FourierSignature& b, int k1) {
  WS_CHECK(a.magnitudes.rows() == b.magnitudes.rows() && a.magnitudes.cols() == b.magnitudes.cols(),
           "signatures of two sizes");
  const Eigen::Index columns = std::min<Eigen::Index>(k1, a.magnitudes.cols());
  return (a.magnitudes.leftCols(columns).cast<float>() -
          b.magnitudes.leftCols(columns).cast<float>())
      .norm();
}

VisualOdometry FollowPanoramas(const std::vector<FourierSignature>& signatures,
                               const ElevationBand& band, const VisualOdometryOptions& options,
                               const std::function<void()>& before_each) {
  options.Check();
  return Follower(signatures, band, options, before_each).Run();
}

}  // namespace waystone
