// SPDX-License-Identifier: Apache-2.0
#include "builder/joining/look_again.h"

#include <tbb/parallel_for.h>

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <set>
#include <tuple>
#include <utility>

#include "builder/joining/append_map.h"
#include "core/features/keypoint_grid.h"
#include "localizer/planes/verify_keyframe.h"
#include "schema/sessions.h"

namespace waystone {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;

// Matches around a feature: the nearest in each of these sectors, no farther than this.
constexpr int kSectors = 8;
constexpr int kLeastSectors = 4;
constexpr double kAround = 0.5;  // of the image's width
// How far a feature may be from where it is predicted, and how well the matches around it must
// agree.
constexpr double kReach = 0.03;        // of the image's width
constexpr double kAgreement = 0.015;   // the same, root mean square
constexpr double kMargin = 0.05;       // of the image: nearer to its border nothing is looked for
constexpr double kLargestScale = 2;    // of what was seen to what is seen, or the other way round
constexpr double kLargestStretch = 2;  // of one direction against the other
constexpr double kAlike = 0.4;         // of the largest distance of descriptors
constexpr size_t kLeastMatches = 20;   // of two keyframes, for comparing them
constexpr size_t kLeastLooked = 20;    // in an image
constexpr double kLeastFound = 0.33;   // share of what was looked for in an image
constexpr int kBeside = 2;             // keyframes before and after the one of the answer
constexpr size_t kMostCompared = 8;    // keyframes

// A feature of the map, by its row of MapIndex::search(), and whether an image showed it.
using RowsSeen = std::map<int, bool>;

bool IsWellInside(const Vector2d& x, const Features& image) {
  const Vector2d size(image.width, image.height);
  const Vector2d margin = kMargin * size;
  return (x.array() > margin.array()).all() && (x.array() < (size - margin).array()).all();
}

// Of each sequence, which of the map's sessions it came with.
using SessionNumbers = std::map<SequenceId, size_t>;

SessionNumbers NumberSessions(const MapData& map) {
  const std::vector<MapSession> sessions = SessionsOf(map);
  SessionNumbers numbers;
  for (size_t n = 0; n < sessions.size(); ++n) {
    for (const SequenceId sequence : sessions[n].sequences) numbers[sequence] = n;
  }
  return numbers;
}

// The keyframe of an answer, those beside it and those of other sessions that it is linked with.
// Links within a session may join places that only look alike, whose differences don't show what is
// gone.
std::vector<int> KeyframesAround(const MapIndex& index, const SessionNumbers& sessions, int found) {
  const std::vector<Keyframe>& keyframes = index.map().keyframes;
  std::vector<int> around{found};
  const int count = static_cast<int>(keyframes.size());
  for (int k = std::max(0, found - kBeside); k < std::min(count, found + kBeside + 1); ++k) {
    if (k != found && keyframes[k].stretch == keyframes[found].stretch) around.push_back(k);
  }
  const auto session = [&](int k) { return sessions.at(keyframes[k].sequence); };
  for (const int linked : index.LinkedTo(found)) {
    if (around.size() == kMostCompared) break;
    if (session(linked) != session(found)) around.push_back(linked);
  }
  return around;
}

void LookFrom(const AskedMap& asked, int keyframe, const Features& image, const KeypointGrid& grid,
              RowsSeen& seen) {
  const MapIndex& index = *asked.index;
  const VerifiedKeyframe verified = VerifyKeyframe(index, image, keyframe, asked.options.planes);
  if (verified.inliers.size() < kLeastMatches) return;
  const LocalMotion motion(verified.keyframe_points, verified.query_points, image.width);
  const KeyframeFeatures target = CollectKeyframeFeatures(index, keyframe);
  const double alike = DistanceAt(image.type, kAlike);
  for (size_t i = 0; i < target.positions.size(); ++i) {
    const std::optional<Vector2d> there = motion.Predict(target.positions[i]);
    if (!there || !IsWellInside(*there, image)) continue;
    const bool found =
        grid.MostAlike(*there, target.descriptors.row(static_cast<int>(i)), alike) >= 0;
    seen[target.rows[i]] |= found;
  }
  for (const MapMatch& match : verified.inliers) {
    const auto looked = seen.find(match.row);
    if (looked != seen.end()) looked->second = true;
  }
}

RowsSeen LookFor(const AskedMap& asked, const SessionNumbers& sessions, const Answer& answer,
                 const Features& image) {
  const MapIndex& index = *asked.index;
  if (answer.verdict != Verdict::kLocalized || !answer.planes.keyframe) return {};
  const KeypointGrid grid(image, kReach * image.width);
  RowsSeen seen;
  const int answered = index.IndexOf(answer.planes.keyframe->id);
  for (const int k : KeyframesAround(index, sessions, answered)) {
    LookFrom(asked, k, image, grid, seen);
  }
  const auto found =
      static_cast<double>(std::ranges::count_if(seen, [](const auto& row) { return row.second; }));
  const bool counts =
      seen.size() >= kLeastLooked && found >= kLeastFound * static_cast<double>(seen.size());
  return counts ? seen : RowsSeen{};
}

// Counts of all rows by the sequences of a walk.
using CountsOfSequence = std::map<SequenceId, std::vector<FeatureLooks>>;

// The counts of `count` rows from `first` on; empty where none was looked for.
std::vector<FeatureLooks> Slice(const std::vector<FeatureLooks>& all, int first, size_t count) {
  const auto begin = all.begin() + first;
  const auto end = begin + static_cast<std::ptrdiff_t>(count);
  if (std::none_of(begin, end, [](const FeatureLooks& one) { return one.looked > 0; })) return {};
  return {begin, end};
}

void AddRows(const MapIndex& index, const CountsOfSequence& counts, Looks& looks) {
  const MapData& map = index.map();
  for (const auto& [sequence, all] : counts) {
    for (size_t p = 0; p < map.planes.size(); ++p) {
      const int first = index.FirstRow(static_cast<int>(p));
      auto slice = Slice(all, first, map.planes[p].features.size());
      if (!slice.empty()) looks.planes.push_back({map.planes[p].id, sequence, std::move(slice)});
    }
    for (size_t k = 0; k < map.keyframes.size(); ++k) {
      const Keyframe& keyframe = map.keyframes[k];
      const int first = index.FirstLandmarkRow(static_cast<int>(k));
      auto slice = Slice(all, first, keyframe.landmarks.positions.size());
      if (!slice.empty()) looks.landmarks.push_back({keyframe.id, sequence, std::move(slice)});
    }
  }
  std::ranges::sort(looks.planes, {},
                    [](const PlaneLooks& row) { return std::tuple(row.plane, row.sequence); });
  std::ranges::sort(looks.landmarks, {}, [](const LandmarkLooks& row) {
    return std::tuple(row.keyframe, row.sequence);
  });
}

}  // namespace

LocalMotion::LocalMotion(std::vector<Vector2d> in_keyframe, std::vector<Vector2d> in_image,
                         int width)
    : in_keyframe_(std::move(in_keyframe)), in_image_(std::move(in_image)), width_(width) {}

// The nearest match in each sector; empty where they don't surround `x`.
std::vector<int> LocalMotion::NearestAround(const Vector2d& x) const {
  std::array<int, kSectors> nearest;
  nearest.fill(-1);
  std::array<double, kSectors> distance2;
  distance2.fill(kAround * width_ * kAround * width_);
  for (size_t i = 0; i < in_keyframe_.size(); ++i) {
    const Vector2d away = in_keyframe_[i] - x;
    const double turn =
        (std::atan2(away.y(), away.x()) + std::numbers::pi) / (2 * std::numbers::pi);
    const int sector = std::clamp(static_cast<int>(turn * kSectors), 0, kSectors - 1);
    if (away.squaredNorm() >= distance2[sector]) continue;
    distance2[sector] = away.squaredNorm();
    nearest[sector] = static_cast<int>(i);
  }
  std::vector<int> around;
  int gap = 0;  // sectors without a match that follow each other, once around and on
  int largest_gap = 0;
  for (int s = 0; s < 2 * kSectors; ++s) {
    const int i = nearest[s % kSectors];
    gap = i < 0 ? gap + 1 : 0;
    largest_gap = std::max(largest_gap, gap);
    if (i >= 0 && s < kSectors) around.push_back(i);
  }
  // Two empty sectors, and the free parts of those next to them, span at most half a turn.
  if (static_cast<int>(around.size()) < kLeastSectors || largest_gap > 2) return {};
  return around;
}

std::optional<Vector2d> LocalMotion::Predict(const Vector2d& x) const {
  const std::vector<int> around = NearestAround(x);
  if (around.empty()) return std::nullopt;
  Vector2d middle = Vector2d::Zero();
  Vector2d there = Vector2d::Zero();
  for (const int i : around) {
    middle += in_keyframe_[i];
    there += in_image_[i];
  }
  const auto count = static_cast<double>(around.size());
  middle /= count;
  there /= count;
  Matrix2d spread = Matrix2d::Zero();
  Matrix2d moved = Matrix2d::Zero();
  for (const int i : around) {
    const Vector2d away = in_keyframe_[i] - middle;
    spread += away * away.transpose();
    moved += (in_image_[i] - there) * away.transpose();
  }
  const Matrix2d affinity = moved * spread.inverse();
  const double area = affinity.determinant();
  // With singular values s and t: s t = area, s^2 + t^2 = the squared norm.
  const double stretch = affinity.squaredNorm() / area;  // s / t + t / s
  const bool seen_alike = area > 1 / (kLargestScale * kLargestScale) &&
                          area < kLargestScale * kLargestScale &&
                          stretch <= kLargestStretch + 1 / kLargestStretch;  // not for NaN
  if (!seen_alike) return std::nullopt;
  double error2 = 0;
  for (const int i : around) {
    error2 += (affinity * (in_keyframe_[i] - middle) - (in_image_[i] - there)).squaredNorm();
  }
  // An affinity takes six of the coordinates for itself.
  const double error = std::sqrt(error2 / (2 * count - 6));
  if (error > kAgreement * width_) return std::nullopt;
  return there + affinity * (x - middle);
}

LookCounts LookAgain(const AskedMap& asked, const MapData& walk,
                     const std::vector<WalkImage>& images, MapData& map) {
  const MapIndex& index = *asked.index;
  const SessionNumbers sessions = NumberSessions(index.map());
  std::vector<RowsSeen> seen(images.size());
  tbb::parallel_for(size_t{0}, images.size(), [&](size_t i) {
    seen[i] = LookFor(asked, sessions, asked.answers[i], images[i].features);
  });
  const std::map<SequenceId, SequenceId> ids = AppendedSequences(walk, map);
  CountsOfSequence counts;
  std::set<int> looked;
  std::set<int> found;
  for (size_t i = 0; i < images.size(); ++i) {
    if (seen[i].empty()) continue;
    std::vector<FeatureLooks>& rows = counts[ids.at(images[i].sequence)];
    rows.resize(static_cast<size_t>(index.search().rows()));
    for (const auto& [row, was_found] : seen[i]) {
      looked.insert(row);
      if (was_found) found.insert(row);
      FeatureLooks& one = rows[static_cast<size_t>(row)];
      if (one.looked == kMaxLooks) continue;
      ++one.looked;
      one.found = static_cast<uint8_t>(one.found + (was_found ? 1 : 0));
    }
  }
  AddRows(index, counts, map.looks);
  return {static_cast<int>(looked.size()), static_cast<int>(found.size())};
}

}  // namespace waystone
