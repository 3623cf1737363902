// SPDX-License-Identifier: Apache-2.0
#include "localizer/verdict/answer.h"

#include <cmath>

#include "core/base/check.h"

namespace waystone {

const char* NameOf(Verdict verdict) {
  switch (verdict) {
    case Verdict::kLocalized:
      return "localized";
    case Verdict::kAmbiguous:
      return "ambiguous";
    case Verdict::kNotInMap:
      return "not_in_map";
    case Verdict::kBadImage:
      return "bad_image";
    case Verdict::kUndecided:
      return "undecided";
  }
  WS_CHECK(false, "unknown verdict");
}

const char* NameOf(DecidedBy gate) {
  switch (gate) {
    case DecidedBy::kNone:
      return "";
    case DecidedBy::kFeatures:
      return "features";
    case DecidedBy::kShortlistVotes:
      return "shortlist_votes";
    case DecidedBy::kHomographyInliers:
      return "homography_inliers";
    case DecidedBy::kEpipolarInliers:
      return "epipolar_inliers";
    case DecidedBy::kInlierShare:
      return "inlier_share";
    case DecidedBy::kHomographyScale:
      return "homography_scale";
    case DecidedBy::kPlaceProbability:
      return "place_probability";
    case DecidedBy::kAmbiguousPlaces:
      return "ambiguous_places";
    case DecidedBy::kAmbiguousMaps:
      return "ambiguous_maps";
    case DecidedBy::kBuildingAxes:
      return "building_axes";
    case DecidedBy::kPanoramaSignature:
      return "panorama_signature";
    case DecidedBy::kPanoramaFeatures:
      return "panorama_features";
    case DecidedBy::kPhoto:
      return "photo";
    case DecidedBy::kPhotoFeatures:
      return "photo_features";
    case DecidedBy::kSeries:
      return "series";
    case DecidedBy::kDeadline:
      return "deadline";
    case DecidedBy::kBadImage:
      return "bad_image";
    case DecidedBy::kImageTooLarge:
      return "image_too_large";
  }
  WS_CHECK(false, "unknown gate");
}

const char* NameOf(Stage stage) {
  switch (stage) {
    case Stage::kQueue:
      return "queue";
    case Stage::kDecode:
      return "decode";
    case Stage::kExtract:
      return "extract";
    case Stage::kShortlist:
      return "shortlist";
    case Stage::kDecide:
      return "decide";
  }
  WS_CHECK(false, "unknown stage");
}

const char* NameOf(HeadingFrame frame) {
  switch (frame) {
    case HeadingFrame::kKeyframe:
      return "keyframe";
    case HeadingFrame::kBuilding:
      return "building";
    case HeadingFrame::kLayer:
      return "layer";
  }
  WS_CHECK(false, "unknown frame");
}

const char* NameOf(Gate gate) {
  switch (gate) {
    case Gate::kPassed:
      return "passed";
    case Gate::kSettled:
      return "settled";
    case Gate::kNoHomography:
      return "no_homography";
    case Gate::kMinInliers:
      return "min_inliers";
    case Gate::kMinInlierShare:
      return "min_inlier_share";
    case Gate::kMaxScale:
      return "max_scale";
  }
  WS_CHECK(false, "unknown gate");
}

int CountBestInliers(const PlaneAnswer& answer) {
  if (!answer.recognised.empty()) return answer.recognised.front().inliers;
  return answer.epipolar ? answer.epipolar->inliers : 0;
}

std::string PercentText(double share) {
  constexpr double kRounding = 1e-9;  // 100 * 0.29 is less than 29
  return std::to_string(static_cast<int>(std::floor(100 * share + kRounding))) + "%";
}

Answer Undecided(Stage last) {
  Answer answer;
  answer.verdict = Verdict::kUndecided;
  answer.decided_by = DecidedBy::kDeadline;
  answer.last_stage = last;
  answer.message = last == Stage::kQueue
                       ? "the deadline expired before the image was decoded; use a longer deadline "
                         "or send fewer "
                         "queries"
                       : "the deadline expired after stage '" + std::string(NameOf(last)) +
                             "'; use a longer deadline";
  return answer;
}

Answer RefuseImage(const MapError& error) {
  const bool large = error.code() == ErrorCode::kImageTooLarge;
  WS_CHECK(large || error.code() == ErrorCode::kBadImage, "no error of an image");
  Answer answer;
  answer.verdict = Verdict::kBadImage;
  answer.decided_by = large ? DecidedBy::kImageTooLarge : DecidedBy::kBadImage;
  answer.message = error.what();
  return answer;
}

}  // namespace waystone
