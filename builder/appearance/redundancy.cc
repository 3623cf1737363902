// SPDX-License-Identifier: Apache-2.0
#include "builder/appearance/redundancy.h"

#include <Eigen/Core>
#include <cmath>

namespace waystone {
namespace {

// Longer runs are too costly to try, and interpolation over them is meaningless.
constexpr int kLongestRun = 64;

class Keeper {
 public:
  Keeper(const std::vector<FourierSignature>& signatures, const std::vector<Pose2>& poses,
         double max_loss)
      : signatures_(signatures), max_loss_(max_loss) {
    mean_ = Eigen::MatrixXf::Zero(signatures[0].magnitudes.rows(), signatures[0].magnitudes.cols());
    for (size_t i = 0; i < signatures.size(); ++i) mean_ += At(static_cast<int>(i));
    mean_ /= static_cast<float>(signatures.size());
    trajectory_ = {0};
    for (size_t i = 1; i < poses.size(); ++i) {
      trajectory_.push_back(trajectory_.back() + Apart(poses[i - 1], poses[i]));
    }
  }

  // The panorama to keep after `from`: the last one such that all between can be interpolated.
  int NextAfter(int from, int last) const {
    int next = from + 1;
    for (int to = from + 2; to <= std::min(last, from + kLongestRun); ++to) {
      if (!CanSpan(from, to)) break;
      next = to;
    }
    return next;
  }

 private:
  Eigen::MatrixXf At(int i) const { return signatures_[i].magnitudes.cast<float>(); }

  bool CanSpan(int from, int to) const {
    const Eigen::MatrixXf a = At(from);
    const Eigen::MatrixXf b = At(to);
    const double length = trajectory_[to] - trajectory_[from];
    for (int i = from + 1; i < to; ++i) {
      const double share = length > 0 ? (trajectory_[i] - trajectory_[from]) / length : 0;
      const Eigen::MatrixXf own = At(i);
      const double lost =
          (own - static_cast<float>(1 - share) * a - static_cast<float>(share) * b).squaredNorm();
      if (lost > max_loss_ * (own - mean_).squaredNorm()) return false;
    }
    return true;
  }

  const std::vector<FourierSignature>& signatures_;
  double max_loss_;
  Eigen::MatrixXf mean_;
  std::vector<double> trajectory_;  // to each panorama
};

}  // namespace

void RedundancyOptions::Check() const { CheckFields("redundancy", *this); }

std::vector<bool> KeepInformative(const std::vector<FourierSignature>& signatures,
                                  const std::vector<Pose2>& poses,
                                  const std::vector<PanoramaStretch>& stretches,
                                  const RedundancyOptions& options) {
  options.Check();
  if (options.max_loss <= 0 || signatures.empty()) {
    return std::vector<bool>(signatures.size(), true);
  }
  std::vector<bool> keep(signatures.size(), false);
  const Keeper keeper(signatures, poses, options.max_loss);
  for (const PanoramaStretch& stretch : stretches) {
    for (int i = stretch.first; i < stretch.last; i = keeper.NextAfter(i, stretch.last - 1)) {
      keep[i] = true;
    }
  }
  return keep;
}

}  // namespace waystone
