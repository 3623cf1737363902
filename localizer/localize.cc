// SPDX-License-Identifier: Apache-2.0
#include <chrono>

#include "core/base/error.h"
#include "localizer/decide.h"
#include "localizer/localizer.h"
#include "localizer/shortlist.h"
#include "localizer/verify.h"

namespace waystone {
namespace {

// Milliseconds since it was made or last asked.
class LapTimer {
 public:
  double Lap() {
    const auto now = std::chrono::steady_clock::now();
    const double ms = std::chrono::duration<double, std::milli>(now - last_).count();
    last_ = now;
    return ms;
  }

 private:
  std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
};

void Sign(const MapIndex& index, Answer& answer) {
  answer.map = index.map().info.name;
  answer.map_version = index.map().info.version;
}

// Whether a plane that settled where the query is makes it pointless to try a candidate.
bool IsBeaten(const MapIndex& index, const ShortlistedPlane& candidate, const VerifiedPlane& best,
              const LocalizeOptions& options) {
  if (best.distinct < options.settled_inliers) return false;
  if (candidate.votes >= options.settled_share * best.distinct) return false;
  const std::vector<Plane>& planes = index.map().planes;
  return !PlanesAreNear(index, planes[best.plane], planes[candidate.plane]);
}

}  // namespace

std::vector<VerifiedPlane> TryPlanes(const MapIndex& index, const Features& query,
                                     const std::vector<ShortlistedPlane>& shortlist,
                                     const LocalizeOptions& options) {
  const PackedFeatures packed(query);
  std::vector<VerifiedPlane> tried;
  int best = -1;  // of those that were accepted
  for (const ShortlistedPlane& candidate : shortlist) {
    if (best >= 0 && IsBeaten(index, candidate, tried[best], options)) continue;
    auto verified = VerifyPlane(index, packed, candidate.plane, options);
    if (!verified) continue;
    tried.push_back(std::move(*verified));
    if (!tried.back().accepted) continue;
    if (best < 0 || tried.back().distinct > tried[best].distinct) {
      best = static_cast<int>(tried.size()) - 1;
    }
  }
  return tried;
}

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
  }
  WS_CHECK(false, "unknown verdict");
}

void GateOptions::Check() const {
  const bool good = min_inliers >= 5 && min_probability > 0 && min_probability < 1 &&
                    min_inlier_share >= 0 && min_inlier_share <= 1 && distinct_px >= 0 &&
                    max_scale > 1 && ambiguous_share > 0 && ambiguous_share <= 1;
  if (!good) {
    throw MapError(ErrorCode::kBadOptions,
                   "gates: an option is out of its range; leave them at their defaults");
  }
}

void LocalizeOptions::Check() const {
  limits.Check();
  FeatureOptions{FeatureType::kSift, max_features, contrast_threshold}.Check();
  match.Check();
  ransac.Check();
  homology.Check();
  gates.Check();
  if (settled_inliers < 1 || !(settled_share >= 0 && settled_share <= gates.ambiguous_share)) {
    throw MapError(ErrorCode::kBadOptions,
                   "settled_inliers must be positive and settled_share lie between 0 and "
                   "ambiguous_share; leave them at their defaults");
  }
  if (votes_per_feature < 1 || probes < 1 || max_candidates < 1 || min_votes < 1) {
    throw MapError(ErrorCode::kBadOptions,
                   "shortlist: votes_per_feature, probes, max_candidates and min_votes must be "
                   "positive; leave them at their defaults");
  }
}

Answer LocalizeFeatures(const MapIndex& index, const Features& query,
                        const LocalizeOptions& options) {
  options.Check();
  WS_CHECK(query.type == index.map().info.feature_type, "features of another type than the map's");
  LapTimer timer;
  const std::vector<ShortlistedPlane> shortlist = ShortlistPlanes(index, query, options);
  const double shortlist_ms = timer.Lap();
  const std::vector<VerifiedPlane> tried = TryPlanes(index, query, shortlist, options);
  Answer answer = Decide(index, query, static_cast<int>(shortlist.size()), tried, options);
  Sign(index, answer);
  answer.timing.shortlist_ms = shortlist_ms;
  answer.timing.verify_ms = timer.Lap();
  answer.timing.total_ms = answer.timing.shortlist_ms + answer.timing.verify_ms;
  return answer;
}

Answer LocalizeImage(const MapIndex& index, const cv::Mat& grey, const LocalizeOptions& options) {
  options.Check();
  LapTimer timer;
  const Features query = ExtractFeatures(
      grey, {index.map().info.feature_type, options.max_features, options.contrast_threshold});
  const double extract_ms = timer.Lap();
  Answer answer = LocalizeFeatures(index, query, options);
  answer.timing.extract_ms = extract_ms;
  answer.timing.total_ms += extract_ms;
  return answer;
}

Answer Localize(const MapIndex& index, std::span<const uint8_t> bytes, const std::string& name,
                const LocalizeOptions& options) {
  LapTimer timer;
  Answer answer;
  try {
    const cv::Mat grey = DecodeGrey(bytes, options.limits);
    const double decode_ms = timer.Lap();
    answer = LocalizeImage(index, grey, options);
    answer.timing.decode_ms = decode_ms;
    answer.timing.total_ms += decode_ms;
  } catch (const MapError& error) {
    if (error.code() != ErrorCode::kBadImage && error.code() != ErrorCode::kImageTooLarge) throw;
    answer.verdict = Verdict::kBadImage;
    answer.decided_by = InfoOf(error.code()).name;
    answer.message = error.what();
    answer.timing.decode_ms = answer.timing.total_ms = timer.Lap();
    Sign(index, answer);
  }
  answer.image = name;
  return answer;
}

}  // namespace waystone
