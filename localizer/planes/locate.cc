// SPDX-License-Identifier: Apache-2.0
#include "localizer/planes/locate.h"

#include <Eigen/Dense>
#include <algorithm>
#include <set>

#include "core/base/check.h"
#include "core/base/clock.h"
#include "localizer/planes/decide.h"
#include "localizer/planes/explain.h"
#include "localizer/planes/image_features.h"
#include "localizer/planes/shortlist.h"
#include "localizer/planes/sightings.h"
#include "localizer/planes/surroundings.h"
#include "localizer/planes/verify.h"

namespace waystone {

namespace {

constexpr int64_t kFewestWorkingPixels = 76'800;  // 320 x 240, for maps of tiny images

// The inliers of the answered place: those of its planes, and of the verified keyframes near the
// answered one.
std::vector<MapMatch> CollectMatches(const MapIndex& index, const Answer& answer,
                                     const std::vector<VerifiedPlane>& tried,
                                     const std::vector<VerifiedKeyframe>& keyframes) {
  std::vector<MapMatch> matches;
  for (const VerifiedPlane& plane : tried) {
    const PlaneId id = index.map().planes[plane.plane].id;
    if (std::ranges::count(answer.planes.recognised, id, &RecognisedPlane::id) == 0) continue;
    for (const Match& match : plane.inliers) {
      matches.push_back({match.a, index.FirstRow(plane.plane) + match.b});
    }
  }
  const std::set<int> near = KeyframesNear(index, index.IndexOf(answer.planes.keyframe->id));
  for (const VerifiedKeyframe& keyframe : keyframes) {
    if (!near.contains(keyframe.keyframe)) continue;
    matches.insert(matches.end(), keyframe.inliers.begin(), keyframe.inliers.end());
  }
  return matches;
}

}  // namespace

FeatureOptions QueryFeatureOptions(FeatureType type, int64_t largest_px,
                                   const PlaneQueryOptions& options) {
  FeatureOptions features{.type = type,
                          .max_features = options.max_features,
                          .contrast_threshold = options.contrast_threshold};
  if (largest_px > 0) {
    features.working_pixels = static_cast<int>(
        std::clamp<int64_t>(largest_px, kFewestWorkingPixels, features.working_pixels));
  }
  return features;
}

FeatureOptions QueryFeatureOptions(const MapIndex& index, const PlaneQueryOptions& options) {
  int64_t largest_px = 0;
  for (const Keyframe& keyframe : index.map().keyframes) {
    largest_px = std::max(largest_px, int64_t{keyframe.width} * keyframe.height);
  }
  return QueryFeatureOptions(index.map().info.feature_type, largest_px, options);
}

void ToImagePixels(const Features& query, PlaneAnswer& answer) {
  const cv::Size image = ImageSize(query);
  if (image.width == query.width) return;
  const Eigen::Matrix3d image_from_working = ImageFromWorking(query);
  const Eigen::Matrix3d working_from_image = image_from_working.inverse();
  const auto move = [&](std::vector<Eigen::Vector2d>& points) {
    for (Eigen::Vector2d& x : points) x = (image_from_working * x.homogeneous()).head<2>();
  };
  for (RecognisedPlane& plane : answer.recognised) {
    plane.reference_from_query *= working_from_image;
    plane.reference_from_query /= plane.reference_from_query(2, 2);
    move(plane.outline);
    move(plane.query_points);
  }
  if (answer.epipolar) move(answer.epipolar->query_points);
  if (!answer.explanation) return;
  answer.explanation->width = image.width;
  answer.explanation->height = image.height;
  for (ExplainedCandidate& candidate : answer.explanation->candidates) {
    move(candidate.query_points);
  }
  for (ExplainedKeyframe& keyframe : answer.explanation->keyframes) move(keyframe.query_points);
}

Answer LocateByPlanes(const MapIndex& index, const Features& query,
                      const PlaneQueryOptions& options, const Deadline& deadline, bool explain) {
  WS_CHECK(query.type == index.map().info.feature_type, "features of another type than the map's");
  LapTimer timer;
  const Shortlist shortlist = VoteForPlaces(index, query, options);
  const double shortlist_ms = timer.Lap();
  const std::vector<VerifiedPlane> tried =
      TryPlanes(index, query, shortlist.planes, options, deadline);
  std::vector<Place> places = FindPlaces(index, tried, options);
  const std::vector<VerifiedKeyframe> keyframes =
      VerifyKeyframes(index, query, shortlist, places, options, deadline);
  JoinKeyframes(index, query, keyframes, options, places);
  Answer answer =
      HasPassed(deadline)
          ? Undecided(Stage::kShortlist)
          : Decide(index, query, static_cast<int>(shortlist.planes.size()), tried, places, options);
  if (deadline && !answer.last_stage) answer.last_stage = Stage::kDecide;
  answer.timing.shortlist_ms = shortlist_ms;
  answer.timing.verify_ms = timer.Lap();
  if (explain)
    answer.planes.explanation = Explain(index, query, shortlist, tried, keyframes, places, options);
  if (index.map().poses && answer.verdict == Verdict::kLocalized) {
    answer.planes.matches = CollectMatches(index, answer, tried, keyframes);
  }
  answer.timing.total_ms = answer.timing.shortlist_ms + answer.timing.verify_ms;
  return answer;
}

}  // namespace waystone
