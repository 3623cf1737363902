// SPDX-License-Identifier: Apache-2.0
#include "builder/planes/landmarks.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <utility>

#include "core/features/descriptor_codes.h"
#include "core/homography/homography.h"

namespace waystone {
namespace {

using Eigen::Vector2d;

// Candidates held per keyframe, in budgets: planes will claim some of them.
constexpr int kHeldBudgets = 6;

// Positions at which the planes of a map have features in one keyframe.
class PlanePositions {
 public:
  explicit PlanePositions(double radius_px) : radius_px_(radius_px) {}

  void Add(const Plane& plane, const PlaneView& view) {
    const Eigen::Matrix3d keyframe_from_reference = view.reference_from_keyframe.inverse();
    for (const PlaneFeature& feature : plane.features) {
      const Vector2d reference = PositionOf(feature.reference);
      const Vector2d x = Apply(keyframe_from_reference, reference);
      if (x.allFinite() && IsInFront(keyframe_from_reference, reference)) positions_.push_back(x);
    }
  }
  bool Near(const Vector2d& x) const {
    return std::any_of(positions_.begin(), positions_.end(), [&](const Vector2d& other) {
      return (other - x).squaredNorm() <= radius_px_ * radius_px_;
    });
  }

 private:
  double radius_px_;
  std::vector<Vector2d> positions_;
};

// The index of the keypoint's cell; the image is divided into `cells` along each side.
int SpreadCell(const Keypoint& keypoint, const Keyframe& keyframe, int cells) {
  const auto cell = [cells](float at, int size) {
    return std::clamp(static_cast<int>(cells * at / static_cast<float>(size)), 0, cells - 1);
  };
  return cell(keypoint.y_px, keyframe.height) * cells + cell(keypoint.x_px, keyframe.width);
}

}  // namespace

void LandmarkOptions::Check() const { CheckFields("landmarks", *this); }

LandmarkChooser::LandmarkChooser(const LandmarkOptions& options) : options_(options) {
  options_.Check();
}

void LandmarkChooser::Add(KeyframeId id, const Features& features, bool starts_stretch) {
  if (options_.max_kept == 0) return;
  if (starts_stretch) {
    while (!recent_.empty()) Retire();
  }
  Recent now{id, features, std::vector<int>(features.size(), 0)};
  for (Recent& before : recent_) Compare(before, now);
  recent_.push_back(std::move(now));
  if (std::ssize(recent_) > options_.neighbours) Retire();
}

void LandmarkChooser::Compare(Recent& before, Recent& now) const {
  const std::vector<Match> matches = MatchDescriptors(
      before.features.descriptors, now.features.descriptors, now.features.type, options_.match);
  std::vector<Vector2d> in_before;
  std::vector<Vector2d> in_now;
  for (const Match& match : matches) {
    in_before.push_back(PositionOf(before.features.keypoints[match.a]));
    in_now.push_back(PositionOf(now.features.keypoints[match.b]));
  }
  const auto fit = FindEpipolarGeometry(in_before, in_now, options_.epipolar);
  if (!fit) return;
  for (const int row : fit->inliers) {
    ++before.found[matches[row].a];
    ++now.found[matches[row].b];
  }
}

// Ranks the features of the oldest keyframe: those found again most often first, then the
// strongest.
void LandmarkChooser::Retire() {
  const Recent& oldest = recent_.front();
  std::vector<int> order(oldest.features.size());
  std::iota(order.begin(), order.end(), 0);
  std::ranges::stable_sort(order, [&](int a, int b) { return oldest.found[a] > oldest.found[b]; });
  order.resize(std::min(order.size(), static_cast<size_t>(kHeldBudgets) * options_.max_kept));
  Candidates candidates{oldest.id, {}, {}};
  Descriptors kept(oldest.features.descriptors.bytes());
  for (const int row : order) {
    candidates.ranked.push_back({oldest.features.keypoints[row], kept.rows(), oldest.found[row]});
    kept.Append(oldest.features.descriptors.row(row));
  }
  candidates.codes = EncodeDescriptors(kept, oldest.features.type);
  candidates_.push_back(std::move(candidates));
  recent_.pop_front();
}

void LandmarkChooser::Finish(MapData& map) {
  if (options_.max_kept == 0) return;
  while (!recent_.empty()) Retire();
  std::map<KeyframeId, std::vector<std::pair<const Plane*, const PlaneView*>>> seen;
  for (const Plane& plane : map.planes) {
    for (const PlaneView& view : plane.views) seen[view.keyframe].emplace_back(&plane, &view);
  }
  const int cells = options_.cells * options_.cells;
  for (Keyframe& keyframe : map.keyframes) {
    const auto found = std::ranges::lower_bound(candidates_, keyframe.id, {}, &Candidates::id);
    if (found == candidates_.end() || found->id != keyframe.id) continue;
    PlanePositions claimed(options_.on_plane_px);
    for (const auto& [plane, view] : seen[keyframe.id]) claimed.Add(*plane, *view);
    std::vector<const Candidate*> free;  // not on any plane
    for (const Candidate& candidate : found->ranked) {
      if (!claimed.Near(PositionOf(candidate.keypoint))) free.push_back(&candidate);
    }
    const auto of_planes = static_cast<int>(found->ranked.size() - free.size());
    const auto found_again = static_cast<int>(std::ranges::count_if(
        free, [](const Candidate* candidate) { return candidate->found > 0; }));
    const int missing = std::max(0, options_.max_kept - of_planes - found_again);
    const int lone = options_.lone_per_found * missing;
    const int most = std::min(found_again, options_.max_kept) + lone;
    free.resize(std::min(free.size(), static_cast<size_t>(found_again + lone)));
    const int share = static_cast<int>(std::ceil(options_.max_crowd * most / cells));
    std::vector<int> filled(cells, 0);
    std::vector<const Candidate*> kept;
    std::vector<const Candidate*> rest;
    for (const Candidate* candidate : free) {
      (filled[SpreadCell(candidate->keypoint, keyframe, options_.cells)]++ < share ? kept : rest)
          .push_back(candidate);
    }
    kept.insert(kept.end(), rest.begin(), rest.end());
    kept.resize(std::min(kept.size(), static_cast<size_t>(most)));
    if (kept.empty()) continue;
    keyframe.landmarks.codes = Descriptors(CodeBytes(map.info.feature_type));
    for (const Candidate* candidate : kept) {
      keyframe.landmarks.positions.push_back(
          EncodePosition(PositionOf(candidate->keypoint), keyframe.width, keyframe.height));
      keyframe.landmarks.codes.Append(found->codes.row(candidate->row));
    }
  }
}

}  // namespace waystone
