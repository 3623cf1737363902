// SPDX-License-Identifier: Apache-2.0
#include "builder/planes/plane_tracker.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "builder/planes/plane_features.h"
#include "builder/planes/rotation_only.h"
#include "core/base/error.h"
#include "core/features/keypoint_grid.h"
#include "core/homography/estimate_homography.h"

namespace waystone {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;

constexpr int kNone = -1;

}  // namespace

void PlaneLayerOptions::Check() const {
  CheckFields("planes", *this);
  segmentation.Check();
  rotation.Check();
  fusion.Check();
  landmarks.Check();
  if (plenty_of_features >= min_features && min_features_unconfirmed >= min_features) return;
  throw MapError(ErrorCode::kBadOptions,
                 "planes.plenty_of_features and planes.min_features_unconfirmed must be at least "
                 "planes.min_features");
}

PlaneTracker::PlaneTracker(const PlaneLayerOptions& options) : options_(options) {
  options_.Check();
}

void PlaneTracker::AddKeyframe(KeyframeId id, const Features& features, bool starts_stretch,
                               const std::optional<Camera>& camera) {
  WS_CHECK(id > last_id_, "keyframes must come in the order of their ids");
  if (starts_stretch) Finish();
  if (last_) Advance(MakeStep(id, features, camera));
  last_ = std::make_shared<const Features>(features);
  last_id_ = id;
}

void PlaneTracker::Finish() {
  for (OpenPlane& open : open_) Close(std::move(open));
  open_.clear();
  last_.reset();
}

PlaneTracker::Step PlaneTracker::MakeStep(KeyframeId id, const Features& features,
                                          const std::optional<Camera>& camera) {
  Step step{id, features, {}, {}, false};
  step.matches =
      MatchDescriptors(features.descriptors, last_->descriptors, features.type, options_.match);
  for (const Match& match : step.matches) {
    step.points.from.push_back(PositionOf(features.keypoints[match.a]));
    step.points.to.push_back(PositionOf(last_->keypoints[match.b]));
  }
  step.rotation_only =
      RotatesOnly(step.points, features.width, features.height, camera, options_.rotation,
                  options_.segmentation.ransac, options_.seed + id.value);
  report_.rotation_only += step.rotation_only;
  return step;
}

// Triple matching plane-image-image (sec. II-A): among the matches that carry the plane's features,
// a homography to the last keyframe and one to the reference image, every match supporting both.
std::optional<PlaneTracker::Tracked> PlaneTracker::Track(OpenPlane& open, const Step& step) const {
  MatchedPoints points;
  std::vector<int> rows;
  for (int row = 0; row < static_cast<int>(step.matches.size()); ++row) {
    const int feature = open.feature_at[step.matches[row].b];
    if (feature == kNone) continue;
    rows.push_back(row);
    points.from.push_back(step.points.from[row]);
    points.to.push_back(step.points.to[row]);
    points.reference.push_back(PositionOf(open.plane.features[feature].reference));
  }
  if (static_cast<int>(rows.size()) < options_.min_tracked) return std::nullopt;
  const auto estimate =
      EstimateHomography(points, options_.segmentation.ransac,
                         options_.seed ^ (step.id.value << 20) ^ open.plane.id.value);
  const int supported = estimate ? static_cast<int>(estimate->inliers.size()) : 0;
  if (!step.rotation_only) {
    open.carried += static_cast<int>(rows.size());
    open.supported += supported;
  }
  if (supported < options_.min_tracked || IsContradicted(open)) return std::nullopt;
  Tracked tracked;
  tracked.reference_from_current = estimate->reference_from.b_from_a;
  tracked.segment.to_from = estimate->to_from;
  tracked.feature_at.assign(step.current.size(), kNone);
  for (const int i : estimate->inliers) {
    tracked.segment.rows.push_back(rows[i]);
    const Match& match = step.matches[rows[i]];
    tracked.feature_at[match.a] = open.feature_at[match.b];
  }
  Reacquire(open, step, tracked);
  return tracked;
}

// A feature that was missed in the last keyframe is looked for where the homography puts it, so
// that it isn't added to the plane a second time.
void PlaneTracker::Reacquire(const OpenPlane& open, const Step& step, Tracked& tracked) const {
  const KeypointGrid grid(step.current, options_.reacquire_px);
  const Matrix3d current_from_reference = tracked.reference_from_current.inverse();
  const Vector2d inside = PositionOf(
      open.plane.features[tracked.feature_at[step.matches[tracked.segment.rows[0]].a]].reference);
  std::vector<char> found(open.plane.features.size(), 0);
  for (int feature : tracked.feature_at) {
    if (feature != kNone) found[feature] = 1;
  }
  const double limit = DistanceAt(step.current.type, options_.reacquire_distance);
  for (int f = 0; f < static_cast<int>(open.plane.features.size()); ++f) {
    const Vector2d reference = PositionOf(open.plane.features[f].reference);
    if (found[f] || !OnSameSide(current_from_reference, reference, inside)) continue;
    const int keypoint = grid.MostAlike(Apply(current_from_reference, reference),
                                        open.plane.descriptors.row(f), limit);
    if (keypoint != kNone && tracked.feature_at[keypoint] == kNone) {
      tracked.feature_at[keypoint] = f;
    }
  }
}

// Algorithm 1, lines 6 to 13, for one keyframe.
void PlaneTracker::Advance(const Step& step) {
  std::vector<OpenPlane> still_open;
  std::vector<Tracked> tracked;
  std::vector<PlaneSegment> known;
  for (OpenPlane& open : open_) {  // lines 6 to 8
    std::optional<Tracked> found = Track(open, step);
    if (!found) {
      Close(std::move(open));
      continue;
    }
    known.push_back(found->segment);
    tracked.push_back(std::move(*found));
    still_open.push_back(std::move(open));
  }
  open_ = std::move(still_open);

  Segmentation segmentation;
  if (step.rotation_only) {  // every match fits every plane: nothing grows, nothing starts
    segmentation.planes = std::move(known);
  } else {
    segmentation = SegmentPlanes(step.points, std::move(known), options_.segmentation,
                                 options_.seed + step.id.value);
  }
  report_.rejected += segmentation.rejected;
  report_.merged += segmentation.merged;
  for (size_t p = 0; p < tracked.size(); ++p) {  // line 9
    Confirm(step, open_[p], tracked[p], segmentation.planes[p].rows);
    const std::vector<int> beyond = Grow(open_[p], step, tracked[p], segmentation.planes[p].rows);
    const std::vector<int> rows = segmentation.planes[p].rows;
    if (step.rotation_only) continue;
    open_[p].renewed = WantsRenewal(open_[p], rows);
    Continue(step, open_[p].renewed ? rows : beyond, segmentation);
  }
  for (size_t p = tracked.size(); p < segmentation.planes.size(); ++p) {  // lines 11 and 12
    Start(step, segmentation.planes[p]);
  }
  std::vector<PlaneId> ids;
  for (const OpenPlane& open : open_) ids.push_back(open.plane.id);
  if (!step.rotation_only) AddEdges(step, ids, segmentation.planes);  // line 13
  for (OpenPlane& open : open_) {
    if (open.renewed) Close(std::move(open));
  }
  std::erase_if(open_, [](const OpenPlane& open) { return open.renewed; });
}

// A match that carries a feature of the plane but doesn't fit the plane, between the last two
// keyframes or to the reference image, doesn't extend it; it also votes against the feature, which
// seemed to be on the plane only as long as the camera had moved too little.
void PlaneTracker::Confirm(const Step& step, OpenPlane& open, Tracked& tracked,
                           std::vector<int>& rows) {
  const std::vector<int>& triple = tracked.segment.rows;
  for (int row = 0; row < static_cast<int>(step.matches.size()); ++row) {
    const Match& match = step.matches[row];
    const int feature = open.feature_at[match.b];
    if (feature == kNone) continue;
    const auto own = std::lower_bound(rows.begin(), rows.end(), row);
    const bool is_own = own != rows.end() && *own == row;
    if (is_own && std::binary_search(triple.begin(), triple.end(), row)) continue;
    tracked.feature_at[match.a] = kNone;
    int& votes = open.plane.features[feature].votes;
    votes = std::max(0, votes - 1);
    if (is_own) rows.erase(own);
  }
}

// Whether too few of a plane's matches are features that its reference image shows.
bool PlaneTracker::WantsRenewal(const OpenPlane& open, const std::vector<int>& rows) const {
  if (static_cast<int>(rows.size()) < options_.segmentation.min_inliers) return false;
  int anchored = 0;
  for (int feature : open.feature_at) anchored += feature != kNone && open.anchored[feature];
  return anchored < options_.min_anchored * static_cast<double>(rows.size());
}

void PlaneTracker::AddFeature(OpenPlane& open, int keypoint, const PlaneFeature& feature,
                              const uint8_t* descriptor, bool anchored) {
  open.feature_at[keypoint] = static_cast<int>(open.plane.features.size());
  open.plane.features.push_back(feature);
  open.plane.descriptors.Append(descriptor);
  open.anchored.push_back(anchored);
}

// Line 9: new features are expressed in the reference image by H_{r,i}. Returns the rows that lie
// too far beyond it.
std::vector<int> PlaneTracker::Grow(OpenPlane& open, const Step& step, const Tracked& tracked,
                                    const std::vector<int>& grown_rows) {
  Plane& plane = open.plane;
  open.feature_at = tracked.feature_at;
  const Matrix3d& reference_from_current = tracked.reference_from_current;
  const Vector2d inside = step.points.from[tracked.segment.rows[0]];
  const KeypointGrid grid(*open.reference, options_.reacquire_px);
  const double limit = DistanceAt(step.current.type, options_.reacquire_distance);
  std::vector<int> beyond;
  for (int row : grown_rows) {
    const int keypoint = step.matches[row].a;
    if (open.feature_at[keypoint] != kNone) continue;
    const uint8_t* descriptor = step.current.descriptors.row(keypoint);
    const int seen =
        grid.MostAlike(Apply(reference_from_current, step.points.from[row]), descriptor, limit);
    if (seen != kNone) {
      // The reference image also shows it, although it wasn't matched then: that is its true
      // position.
      AddFeature(open, keypoint, {open.reference->keypoints[seen], 2, 2}, descriptor, true);
      continue;
    }
    const Keypoint reference =
        Transferred(reference_from_current, step.current.keypoints[keypoint]);
    if (!OnSameSide(reference_from_current, step.points.from[row], inside) ||
        !IsWithinReach(PositionOf(reference), open.reference->width, open.reference->height,
                       options_.max_extrapolation)) {
      beyond.push_back(row);
      continue;
    }
    AddFeature(open, keypoint, {reference, 1, 1}, descriptor, false);
  }
  if (!step.rotation_only) CountVotes(open, step, tracked);  // else every feature would fit
  plane.views.push_back(
      {step.id, reference_from_current, static_cast<int>(tracked.segment.rows.size())});
  return beyond;
}

void PlaneTracker::CountVotes(OpenPlane& open, const Step& step, const Tracked& tracked) const {
  for (int feature : open.feature_at) {
    if (feature != kNone) ++open.plane.features[feature].votes;
  }
  const Matrix3d current_from_reference = tracked.reference_from_current.inverse();
  for (PlaneFeature& feature : open.plane.features) {
    const Vector2d reference = PositionOf(feature.reference);
    const Vector2d x = Apply(current_from_reference, reference);
    feature.visible += IsInFront(current_from_reference, reference) && x.x() >= 0 && x.y() >= 0 &&
                       x.x() < step.current.width && x.y() < step.current.height;
  }
}

// What lies beyond the reach of a plane's reference image, or all of it when that image by now
// shows too little of it, becomes a plane of its own with the last keyframe as its reference image.
void PlaneTracker::Continue(const Step& step, const std::vector<int>& rows,
                            Segmentation& segmentation) {
  if (static_cast<int>(rows.size()) < options_.segmentation.min_inliers) return;
  PointPairs pairs;
  for (int row : rows) pairs.Add(step.points.from[row], step.points.to[row]);
  const auto initial = HomographyByDlt(pairs);
  if (!initial) return;
  const auto estimate = RefineHomography(pairs, *initial);
  if (estimate) segmentation.planes.push_back({*estimate, rows});
}

// A new plane: its reference image is the first that saw it, the last keyframe.
void PlaneTracker::Start(const Step& step, const PlaneSegment& segment) {
  OpenPlane open;
  open.plane.id = PlaneId{next_plane_++};
  open.plane.reference = last_id_;
  open.reference = last_;
  open.plane.descriptors = Descriptors(DescriptorBytes(step.current.type));
  open.feature_at.assign(step.current.size(), kNone);
  for (int row : segment.rows) {
    const Match& match = step.matches[row];
    AddFeature(open, match.a, {last_->keypoints[match.b], 2, 2}, last_->descriptors.row(match.b),
               true);
  }
  const int inliers = static_cast<int>(segment.rows.size());
  open.plane.views.push_back({last_id_, Matrix3d::Identity(), inliers});
  open.plane.views.push_back({step.id, segment.to_from.b_from_a, inliers});
  open_.push_back(std::move(open));
  ++report_.started;
}

// Eq. (5): A(m,n) = A(n,m) = 1 for planes seen together with a correct homology between them.
void PlaneTracker::AddEdges(const Step& step, const std::vector<PlaneId>& ids,
                            const std::vector<PlaneSegment>& segments) {
  for (size_t m = 0; m < ids.size(); ++m) {
    for (size_t n = m + 1; n < ids.size(); ++n) {
      const auto key = std::minmax(ids[m], ids[n]);
      if (has_edge_.contains({key.first, key.second})) continue;
      const bool ordered = ids[m] < ids[n];
      const HomographyEstimate& a = segments[ordered ? m : n].to_from;
      const HomographyEstimate& b = segments[ordered ? n : m].to_from;
      const Homology homology = TestHomology(a, b, options_.segmentation.homology);
      if (homology.kind == HomologyKind::kInvalid) continue;
      has_edge_.insert({key.first, key.second});
      edges_.push_back(
          {key.first, key.second, last_id_, step.id, homology.matrix, homology.third_eigenvalue});
    }
  }
}

// Whether too few of the matches that took its features to later keyframes support a plane. Things
// at different depths fit one homography as long as the camera moves little: two keyframes make a
// plane of them, and later ones show them moving apart.
bool PlaneTracker::IsContradicted(const OpenPlane& open) const {
  return open.supported < options_.min_support * open.carried;
}

// Sec. II-A: a closed plane keeps the features with enough votes.
void PlaneTracker::Close(OpenPlane open) {
  Plane& plane = open.plane;
  std::vector<int> kept;
  for (int f = 0; f < static_cast<int>(plane.features.size()); ++f) {
    const PlaneFeature& feature = plane.features[f];
    // A feature without votes isn't one of the plane, whatever the share.
    if (feature.votes >= std::max(1.0, options_.min_vote_share * feature.visible)) {
      kept.push_back(f);
    }
  }
  report_.features_dropped += static_cast<int>(plane.features.size() - kept.size());
  const bool confirmed = plane.views.size() > 2;
  const int needed = confirmed ? options_.min_features : options_.min_features_unconfirmed;
  if (static_cast<int>(kept.size()) < needed || IsContradicted(open)) {
    ++report_.dropped;
    return;
  }
  KeepFeatures(kept, plane);
  closed_.push_back(std::move(plane));
}

}  // namespace waystone
