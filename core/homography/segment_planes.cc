// SPDX-License-Identifier: Apache-2.0
#include "core/homography/segment_planes.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>
#include <set>
#include <utility>

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
        known_(std::move(known)),
        all_(points_.size()) {
    std::iota(all_.begin(), all_.end(), 0);
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
    while (AddFromPatches()) {
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

  // Proposes a plane among the matches that belong to none.
  std::optional<PlaneFit> ProposeFree() {
    const std::vector<int> free = Free();
    if (static_cast<int>(free.size()) < options_.min_inliers) return std::nullopt;
    std::optional<PlaneFit> fit =
        FindPlane(points_, free, neighbourhoods_, options_.ransac, random_);
    if (!fit || static_cast<int>(fit->inliers.size()) < options_.min_inliers) return std::nullopt;
    return fit;
  }

  // Adds a plane, relabels all matches, and removes it again unless they are then better explained.
  // A plane that doesn't recover half of its cost before the others have made room isn't tried
  // further.
  bool Verify(const Eigen::Matrix3d& to_from) {
    const PlaneLabelling before = labelling_;
    const double energy = before.Energy();
    labelling_.Add(to_from, kFirstSigma_px, false);
    labelling_.Grow(labelling_.planes() - 1);
    const bool promising = labelling_.Energy() < energy + options_.labelling.plane_cost / 2;
    if (promising) labelling_.Settle();
    if (!promising || !Stands(labelling_.planes() - 1) || labelling_.Energy() >= energy) {
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

  // A plane through a patch: neighbouring matches of one label.
  struct Proposal {
    int row;  // in its middle
    Eigen::Matrix3d to_from;
    double gain;
  };

  // Adds the planes through patches that improve the overall explanation. Returns whether there
  // were any: others may then be found among the remaining matches.
  bool AddFromPatches() {
    bool any = false;
    std::set<int> refused;  // matches that proposals would have explained better
    for (const Proposal& patch : ProposePatches()) {
      if (labelling_.planes() >= known() + options_.max_planes) return false;
      if (refused.contains(patch.row)) continue;
      const auto [to_from, better] = Grown(patch.to_from);
      // A quarter of its cost: a plane's gain grows while everything is relabelled and refitted
      // with it.
      const bool promising = better.gain > options_.labelling.plane_cost / 4;
      if (promising && Verify(to_from)) {
        any = true;
      } else {
        refused.insert(patch.row);
        refused.insert(better.rows.begin(), better.rows.end());
      }
    }
    return any;
  }

  // Patches of three sizes, because small ones find small planes and large ones determine them
  // better; the proposal that explains most of its neighbourhood comes first.
  std::vector<Proposal> ProposePatches() const {
    constexpr int kMaxRows = 150;  // as middles: patches overlap
    const int stride = std::max(2, points_.size() / kMaxRows);
    std::vector<Proposal> proposals;
    for (int row = 0; row < points_.size(); row += stride) {
      const std::vector<int> around = Around(row);
      for (const int size : {options_.patch, options_.patch / 2, options_.patch / 4}) {
        if (size < 5 || static_cast<int>(around.size()) < size) continue;
        const auto to_from = HomographyByDlt(PairsOf(std::span(around).first(size)));
        if (!to_from) continue;
        const double gain = labelling_.BetterWith(*to_from, kFirstSigma_px, around).gain;
        if (gain > 0) proposals.push_back({row, *to_from, gain});
      }
    }
    std::ranges::stable_sort(proposals, std::greater<>(), &Proposal::gain);
    return proposals;
  }

  // A match and its nearest ones of the same label.
  std::vector<int> Around(int row) const {
    std::vector<int> around{row};
    for (int neighbour : neighbourhoods_.of(row)) {
      if (labelling_.labels()[neighbour] == labelling_.labels()[row]) around.push_back(neighbour);
    }
    return around;
  }

  // Refits a homography to the matches that it explains better, as long as their number grows.
  std::pair<Eigen::Matrix3d, PlaneLabelling::Better> Grown(Eigen::Matrix3d to_from) const {
    constexpr int kMaxRefits = 5;
    PlaneLabelling::Better better = labelling_.BetterWith(to_from, kFirstSigma_px, all_);
    for (int refit = 0; refit < kMaxRefits; ++refit) {
      const auto refitted = labelling_.Refitted(to_from, kFirstSigma_px, better.rows);
      if (!refitted) break;
      PlaneLabelling::Better next = labelling_.BetterWith(*refitted, kFirstSigma_px, all_);
      if (next.gain <= better.gain) break;
      to_from = *refitted;
      better = std::move(next);
    }
    return {to_from, std::move(better)};
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

  // The eigenvalue test of each new plane against all others, the newest first: it is removed if it
  // has fewer than two eigenvalues near one with every one of them. This comes last, because as
  // long as planes were missing, the others were stretched over their matches.
  void RejectInvalid() {
    for (int p = labelling_.planes() - 1; p >= known(); --p) {
      const auto estimate = EstimateOf(p);
      bool valid = labelling_.planes() == 1;
      for (int q = 0; q < labelling_.planes() && estimate && !valid; ++q) {
        const auto other = q == p ? std::nullopt : EstimateOf(q);
        valid = other && HaveHomology(*other, *estimate, options_.homology);
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
  std::vector<int> all_;  // rows
  std::set<int> spent_;   // matches of candidates that were turned down
  Segmentation result_;
};

// Extraction as in the paper, for comparison: one plane after the other takes the matches that are
// left and support it (sec. II-A), and is tested against those before it (sec. II-B).
class GreedyExtractor {
 public:
  GreedyExtractor(const MatchedPoints& points, std::vector<PlaneSegment> known,
                  const SegmentationOptions& options, uint64_t seed)
      : points_{points.from, points.to, {}},
        options_(options),
        neighbourhoods_(points_.from, 2 * options.ransac.neighbourhood),
        random_(seed),
        known_(static_cast<int>(known.size())),
        taken_(points_.size(), false) {
    result_.planes = std::move(known);
  }

  Segmentation Run() {
    for (PlaneSegment& plane : result_.planes) {
      std::erase_if(plane.rows, [&](int row) { return taken_[row]; });
      Take(plane.rows);
    }
    for (PlaneSegment& plane : result_.planes) AddSupport(plane);
    while (static_cast<int>(result_.planes.size()) < known_ + options_.max_planes && Extract()) {
    }
    return std::move(result_);
  }

 private:
  std::vector<int> Free() const {
    std::vector<int> rows;
    for (int row = 0; row < points_.size(); ++row) {
      if (!taken_[row]) rows.push_back(row);
    }
    return rows;
  }

  void Take(const std::vector<int>& rows) {
    for (const int row : rows) taken_[row] = true;
  }

  // Adds the matches of no plane that fit a known plane's homography.
  void AddSupport(PlaneSegment& plane) {
    const PlaneModel model{plane.to_from.b_from_a, Eigen::Matrix3d::Identity()};
    const PlaneModel inverse = Inverse(model);
    const double bound = ErrorBound(plane.to_from.sigma_px, options_.ransac);
    std::vector<int> found;
    for (const int row : Free()) {
      if (PlaneError2(points_, model, inverse, row) < bound * bound) found.push_back(row);
    }
    AddRows(plane, found);
  }

  void AddRows(PlaneSegment& plane, const std::vector<int>& rows) {
    plane.rows.insert(plane.rows.end(), rows.begin(), rows.end());
    std::ranges::sort(plane.rows);
    Take(rows);
  }

  // Extracts one more plane, gives its matches to another one, or rejects them; false at the end.
  bool Extract() {
    const std::vector<int> free = Free();
    if (static_cast<int>(free.size()) < options_.min_inliers) return false;
    const std::optional<PlaneFit> fit =
        FindPlane(points_, free, neighbourhoods_, options_.ransac, random_);
    if (!fit || static_cast<int>(fit->inliers.size()) < options_.min_inliers) return false;
    PointPairs pairs;
    for (const int row : fit->inliers) pairs.Add(points_.from[row], points_.to[row]);
    const auto estimate = RefineHomography(pairs, fit->model.to_from);
    Take(fit->inliers);
    if (!estimate) {
      ++result_.rejected;
      return true;
    }
    bool valid = result_.planes.empty();
    for (PlaneSegment& plane : result_.planes) {
      const HomologyKind kind = TestHomology(plane.to_from, *estimate, options_.homology).kind;
      if (kind == HomologyKind::kSamePlane) {
        AddRows(plane, fit->inliers);
        ++result_.merged;
        return true;
      }
      valid = valid || kind == HomologyKind::kTwoPlanes;
    }
    if (valid) {
      result_.planes.push_back({*estimate, fit->inliers});
    } else {
      ++result_.rejected;
    }
    return true;
  }

  const MatchedPoints points_;
  const SegmentationOptions& options_;
  const Neighbourhoods neighbourhoods_;
  Random random_;
  const int known_;
  std::vector<bool> taken_;  // matches of a plane, or of a candidate that was turned down
  Segmentation result_;
};

}  // namespace

void SegmentationOptions::Check() const {
  CheckFields("segmentation", *this);
  ransac.Check();
  labelling.Check();
}

Segmentation SegmentPlanes(const MatchedPoints& points, std::vector<PlaneSegment> known,
                           const SegmentationOptions& options, uint64_t seed) {
  options.Check();
  WS_CHECK(points.from.size() == points.to.size(), "matches of different lengths");
  if (options.greedy) return GreedyExtractor(points, std::move(known), options, seed).Run();
  return Segmenter(points, std::move(known), options, seed).Run();
}

}  // namespace waystone
