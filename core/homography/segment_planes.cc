// SPDX-License-Identifier: Apache-2.0
#include "core/homography/segment_planes.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <set>

#include "core/base/check.h"
#include "core/base/error.h"

namespace waystone {
namespace {

constexpr int kNoPlane = -1;

class Segmenter {
 public:
  Segmenter(const MatchedPoints& points, std::vector<PlaneSegment> known,
            const SegmentationOptions& options, uint64_t seed)
      : points_{points.from, points.to, {}},
        options_(options),
        neighbourhoods_(points_.from, 3 * options.ransac.neighbourhood),
        random_(seed),
        known_(static_cast<int>(known.size())),
        label_(points.size(), kNoPlane) {
    result_.planes = std::move(known);
    for (int p = 0; p < known_; ++p) Claim(p);
  }

  Segmentation Run() {
    AssignToKnown();
    for (int tries = 0; tries < options_.max_planes; ++tries) {
      std::optional<PlaneFit> fit = NextCandidate();
      if (!fit) break;
      Consider(*fit);
    }
    return std::move(result_);
  }

 private:
  void Claim(int plane) {
    for (int row : result_.planes[plane].rows) label_[row] = plane;
  }

  std::vector<int> Free() const {
    std::vector<int> rows;
    for (int row = 0; row < points_.size(); ++row) {
      if (label_[row] == kNoPlane && !spent_.contains(row)) rows.push_back(row);
    }
    return rows;
  }

  // Growth: matches of no plane yet that fit a known plane's homography and lie among its own.
  void AssignToKnown() {
    if (known_ == 0) return;
    std::vector<int> wish(label_);
    for (int row : Free()) {
      double best = 1;  // of the error as a share of the plane's bound
      for (int p = 0; p < known_; ++p) {
        const HomographyEstimate& plane = result_.planes[p].to_from;
        const double share =
            std::sqrt(Error2(plane.b_from_a, row)) / ErrorBound(plane.sigma_px, options_.ransac);
        if (share < best) {
          best = share;
          wish[row] = p;
        }
      }
    }
    for (int row : Free()) {
      if (wish[row] != kNoPlane && Companions(row, wish[row], wish) >= options_.min_companions) {
        label_[row] = wish[row];
      }
    }
    for (int p = 0; p < known_; ++p) Collect(p);
  }

  double Error2(const Eigen::Matrix3d& to_from, int row) const {
    return SymmetricTransferError2(to_from, to_from.inverse(), points_.from[row], points_.to[row]);
  }

  int Companions(int row, int plane, const std::vector<int>& labels) const {
    int count = 0;
    int seen = 0;
    for (int neighbour : neighbourhoods_.of(row)) {
      count += labels[neighbour] == plane;
      if (++seen == options_.companions) break;
    }
    return count;
  }

  void Collect(int plane) {
    std::vector<int>& rows = result_.planes[plane].rows;
    rows.clear();
    for (int row = 0; row < points_.size(); ++row) {
      if (label_[row] == plane) rows.push_back(row);
    }
  }

  std::optional<PlaneFit> NextCandidate() {
    const std::vector<int> free = Free();
    if (static_cast<int>(free.size()) < options_.min_inliers) return std::nullopt;
    std::optional<PlaneFit> fit =
        FindPlane(points_, free, neighbourhoods_, options_.ransac, random_);
    if (!fit || static_cast<int>(fit->inliers.size()) < options_.min_inliers) return std::nullopt;
    return fit;
  }

  // Rows whose companions are in the candidate too; none when they are scattered among others.
  std::vector<int> Coherent(const std::vector<int>& rows) const {
    std::vector<int> labels(points_.size(), kNoPlane);
    for (int row : rows) labels[row] = 0;
    std::vector<int> coherent;
    double companions = 0;
    for (int row : rows) {
      const int count = Companions(row, 0, labels);
      if (count < options_.min_companions) continue;
      coherent.push_back(row);
      companions += count;
    }
    const double all = static_cast<double>(options_.companions) * coherent.size();
    if (companions < options_.min_coherence * all) coherent.clear();
    return coherent;
  }

  void Consider(const PlaneFit& fit) {
    const std::vector<int> rows = Coherent(fit.inliers);
    std::optional<HomographyEstimate> estimate;
    if (static_cast<int>(rows.size()) >= options_.min_inliers) {
      estimate = Refine(rows, fit.model.to_from);
    }
    if (!estimate) {
      spent_.insert(fit.inliers.begin(), fit.inliers.end());
      return;
    }
    Decide(PlaneSegment{*estimate, rows});
  }

  std::optional<HomographyEstimate> Refine(const std::vector<int>& rows,
                                           const Eigen::Matrix3d& initial) const {
    PointPairs pairs;
    for (int row : rows) pairs.Add(points_.from[row], points_.to[row]);
    return RefineHomography(pairs, initial);
  }

  // The eigenvalue test against every plane found so far: the same plane, another, or none.
  void Decide(PlaneSegment candidate) {
    int invalid = 0;
    int tested = 0;
    for (int p = 0; p < static_cast<int>(result_.planes.size()); ++p) {
      const Homology homology =
          TestHomology(result_.planes[p].to_from, candidate.to_from, options_.homology);
      if (homology.kind == HomologyKind::kSamePlane && SharesPlane(p, candidate)) {
        Merge(p, candidate);
        return;
      }
      ++tested;
      invalid += homology.kind == HomologyKind::kInvalid;
    }
    if (tested > 0 && 2 * invalid > tested) {
      ++result_.rejected;
      spent_.insert(candidate.rows.begin(), candidate.rows.end());
      return;
    }
    result_.planes.push_back(std::move(candidate));
    Claim(static_cast<int>(result_.planes.size()) - 1);
  }

  bool SharesPlane(int plane, const PlaneSegment& candidate) const {
    const HomographyEstimate& to_from = result_.planes[plane].to_from;
    const double limit2 = std::pow(2 * ErrorBound(to_from.sigma_px, options_.ransac), 2);
    int fits = 0;
    for (int row : candidate.rows) fits += Error2(to_from.b_from_a, row) < limit2;
    return fits >= options_.min_shared * static_cast<double>(candidate.rows.size());
  }

  void Merge(int plane, const PlaneSegment& candidate) {
    ++result_.merged;
    for (int row : candidate.rows) label_[row] = plane;
    Collect(plane);
    PlaneSegment& segment = result_.planes[plane];
    if (auto refined = Refine(segment.rows, segment.to_from.b_from_a)) segment.to_from = *refined;
  }

  const MatchedPoints points_;
  const SegmentationOptions& options_;
  const Neighbourhoods neighbourhoods_;
  Random random_;
  const int known_;
  std::vector<int> label_;  // of each match: index of its plane, or kNoPlane
  std::set<int> spent_;     // matches of candidates that were turned down
  Segmentation result_;
};

}  // namespace

void SegmentationOptions::Check() const {
  ransac.Check();
  homology.Check();
  const bool good = min_inliers >= 5 && max_planes >= 1 && companions >= 1 && min_companions >= 0 &&
                    min_companions <= companions && min_shared >= 0 && min_shared <= 1 &&
                    min_coherence >= 0 && min_coherence <= 1;
  if (!good) {
    throw MapError(ErrorCode::kBadOptions,
                   "plane search: an option is out of its range; leave them at their defaults");
  }
}

Segmentation SegmentPlanes(const MatchedPoints& points, std::vector<PlaneSegment> known,
                           const SegmentationOptions& options, uint64_t seed) {
  options.Check();
  WS_CHECK(points.from.size() == points.to.size(), "matches of different lengths");
  return Segmenter(points, std::move(known), options, seed).Run();
}

}  // namespace waystone
