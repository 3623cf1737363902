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

// Noise of a proposed plane until it is measured. px
constexpr double kFirstSigma_px = 1.0;

class Segmenter {
 public:
  Segmenter(const MatchedPoints& points, std::vector<PlaneSegment> known,
            const SegmentationOptions& options, uint64_t seed)
      : points_{points.from, points.to, {}},
        options_(options),
        neighbourhoods_(points_.from, 3 * options.ransac.neighbourhood),
        labelling_(points_, neighbourhoods_, options.labelling),
        random_(seed),
        known_(std::move(known)) {
    for (const PlaneSegment& plane : known_) {
      labelling_.Add(plane.to_from.b_from_a, plane.to_from.sigma_px, true);
    }
  }

  Segmentation Run() {
    labelling_.Settle();
    for (int tries = 0; tries < options_.max_planes; ++tries) {
      const std::optional<PlaneFit> fit = ProposeFree();
      if (!fit) break;
      if (!Verify(fit->model.to_from)) spent_.insert(fit->inliers.begin(), fit->inliers.end());
    }
    for (int p = 0; p < labelling_.planes(); ++p) {
      while (labelling_.planes() < known() + options_.max_planes && Split(p)) {
      }
    }
    MergeSame();
    RejectInvalid();
    return Collect();
  }

 private:
  int known() const { return static_cast<int>(known_.size()); }

  std::vector<int> Free() const {
    std::vector<int> rows;
    for (int row = 0; row < points_.size(); ++row) {
      if (labelling_.labels()[row] == kNoPlane && !spent_.contains(row)) rows.push_back(row);
    }
    return rows;
  }

  // Proposes a plane among the matches of none.
  std::optional<PlaneFit> ProposeFree() {
    const std::vector<int> free = Free();
    if (static_cast<int>(free.size()) < options_.min_inliers) return std::nullopt;
    std::optional<PlaneFit> fit =
        FindPlane(points_, free, neighbourhoods_, options_.ransac, random_);
    if (!fit || static_cast<int>(fit->inliers.size()) < options_.min_inliers) return std::nullopt;
    return fit;
  }

  // Adds a plane, labels everything anew, and takes it back unless all is better explained then.
  bool Verify(const Eigen::Matrix3d& to_from) {
    const PlaneLabelling before = labelling_;
    labelling_.Add(to_from, kFirstSigma_px, false);
    labelling_.Settle();
    if (!Stands(labelling_.planes() - 1) || labelling_.Energy() >= before.Energy()) {
      labelling_ = before;
      return false;
    }
    for (int p = labelling_.planes() - 2; p >= known(); --p) {
      if (!Stands(p)) labelling_.Remove(p);
    }
    return true;
  }

  bool Stands(int plane) const {
    return static_cast<int>(labelling_.RowsOf(plane).size()) >= options_.min_inliers;
  }

  // Looks for a second plane among the matches of one: where a patch of them is explained best by a
  // homography of its own.
  bool Split(int plane) {
    const std::vector<int> rows = labelling_.RowsOf(plane);
    if (static_cast<int>(rows.size()) < 2 * options_.min_inliers) return false;
    constexpr int kStride = 2;  // patches overlap: every other one is enough
    std::optional<Eigen::Matrix3d> best;
    double most = 0;
    for (size_t i = 0; i < rows.size(); i += kStride) {
      const std::vector<int> around = Around(rows[i], plane);
      if (static_cast<int>(around.size()) < options_.patch) continue;
      const auto to_from = HomographyByDlt(PairsOf(std::span(around).first(options_.patch)));
      if (!to_from) continue;
      const double gain = labelling_.Gain(around, *to_from, plane);
      if (gain > most) {
        most = gain;
        best = to_from;
      }
    }
    return best && Verify(*best);
  }

  // A match and its nearest ones of the same plane.
  std::vector<int> Around(int row, int plane) const {
    std::vector<int> around{row};
    for (int neighbour : neighbourhoods_.of(row)) {
      if (labelling_.labels()[neighbour] == plane) around.push_back(neighbour);
    }
    return around;
  }

  // Three eigenvalues near one: the two are one plane, unless the matches say otherwise.
  void MergeSame() {
    for (int m = 0; m < labelling_.planes(); ++m) {
      for (int n = labelling_.planes() - 1; n > m && n >= known(); --n) {
        result_.merged += Merge(m, n);
      }
    }
  }

  bool Merge(int m, int n) {
    if (!Stands(m)) return false;
    const auto a = EstimateOf(m);
    const auto b = EstimateOf(n);
    if (!a || !b || TestHomology(*a, *b, options_.homology).kind != HomologyKind::kSamePlane) {
      return false;
    }
    std::vector<int> rows = labelling_.RowsOf(m);
    const std::vector<int> others = labelling_.RowsOf(n);
    rows.insert(rows.end(), others.begin(), others.end());
    const auto both = RefineHomography(PairsOf(rows), a->b_from_a);
    if (!both) return false;
    PlaneLabelling merged = labelling_;
    merged.Remove(n);
    merged.Replace(m, both->b_from_a, both->sigma_px);
    merged.Settle();
    if (merged.Energy() >= labelling_.Energy()) return false;
    labelling_ = std::move(merged);
    if (m < known()) known_[m].to_from = *both;
    return true;
  }

  // The eigenvalue test of each new plane against all others, the newest first: it goes if it has
  // fewer than two eigenvalues near one with every one of them. Only now, because as long as planes
  // were missing, the others were stretched over their matches.
  void RejectInvalid() {
    for (int p = labelling_.planes() - 1; p >= known(); --p) {
      const auto estimate = EstimateOf(p);
      bool valid = labelling_.planes() == 1;
      for (int q = 0; q < labelling_.planes() && estimate && !valid; ++q) {
        const auto other = q == p ? std::nullopt : EstimateOf(q);
        valid = other &&
                TestHomology(*other, *estimate, options_.homology).kind != HomologyKind::kInvalid;
      }
      if (estimate && valid) continue;
      labelling_.Remove(p);
      ++result_.rejected;
    }
  }

  Segmentation Collect() {
    for (int p = 0; p < labelling_.planes(); ++p) {
      const auto estimate = EstimateOf(p);
      if (estimate) result_.planes.push_back({*estimate, labelling_.RowsOf(p)});
    }
    return std::move(result_);
  }

  // A known plane's own estimate; a new one's from its matches.
  std::optional<HomographyEstimate> EstimateOf(int plane) const {
    if (plane < known()) return known_[plane].to_from;
    return RefineHomography(PairsOf(labelling_.RowsOf(plane)), labelling_.to_from(plane));
  }

  PointPairs PairsOf(std::span<const int> rows) const {
    PointPairs pairs;
    for (int row : rows) pairs.Add(points_.from[row], points_.to[row]);
    return pairs;
  }

  const MatchedPoints points_;
  const SegmentationOptions& options_;
  const Neighbourhoods neighbourhoods_;
  PlaneLabelling labelling_;
  Random random_;
  std::vector<PlaneSegment> known_;
  std::set<int> spent_;  // matches of candidates that were turned down
  Segmentation result_;
};

}  // namespace

void SegmentationOptions::Check() const {
  ransac.Check();
  labelling.Check();
  homology.Check();
  const bool good = min_inliers >= 5 && max_planes >= 1 && patch >= 5;
  if (!good) {
    throw MapError(ErrorCode::kBadOptions, "plane search: option out of range; use the defaults");
  }
}

Segmentation SegmentPlanes(const MatchedPoints& points, std::vector<PlaneSegment> known,
                           const SegmentationOptions& options, uint64_t seed) {
  options.Check();
  WS_CHECK(points.from.size() == points.to.size(), "matches of different lengths");
  return Segmenter(points, std::move(known), options, seed).Run();
}

}  // namespace waystone
