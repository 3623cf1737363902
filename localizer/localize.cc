// SPDX-License-Identifier: Apache-2.0
#include <chrono>
#include <map>
#include <utility>

#include "core/base/error.h"
#include "localizer/appearance/appearance.h"
#include "localizer/appearance/panorama_series.h"
#include "localizer/appearance/photo.h"
#include "localizer/localizer.h"
#include "localizer/orientation/building.h"
#include "localizer/planes/decide.h"
#include "localizer/planes/explain.h"
#include "localizer/planes/shortlist.h"
#include "localizer/planes/verify.h"
#include "localizer/undecided.h"

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

// Whether the map's panoramas are asked rather than its planes.
bool AsksPanoramas(const MapIndex& index, const cv::Mat& grey) {
  return index.HasAppearance() && (IsPanoramic(grey.size()) || index.map().planes.empty());
}

}  // namespace

bool IsBeaten(const MapIndex& index, const ShortlistedPlane& candidate, const VerifiedPlane& best,
              const LocalizeOptions& options) {
  if (best.distinct < options.settled_inliers) return false;
  if (candidate.votes >= options.settled_share * best.distinct) return false;
  const std::vector<Plane>& planes = index.map().planes;
  return !PlanesAreNear(index, planes[best.plane], planes[candidate.plane]);
}

std::vector<VerifiedPlane> TryPlanes(const MapIndex& index, const Features& query,
                                     const std::vector<ShortlistedPlane>& shortlist,
                                     const LocalizeOptions& options) {
  const PackedFeatures packed(query);
  std::vector<VerifiedPlane> tried;
  int best = -1;  // of those that were accepted
  for (const ShortlistedPlane& candidate : shortlist) {
    if (options.TooLate()) break;
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
    case Verdict::kUndecided:
      return "undecided";
  }
  WS_CHECK(false, "unknown verdict");
}

void GateOptions::Check() const {
  const bool good = min_inliers >= 5 && min_probability > 0 && min_probability < 1 &&
                    min_inlier_share >= 0 && min_inlier_share <= 1 && distinct_px >= 0 &&
                    max_scale > 1 && ambiguous_share > 0 && ambiguous_share <= 1;
  if (!good) {
    throw MapError(ErrorCode::kBadOptions, "gates: option out of range; use the defaults");
  }
}

void LocalizeOptions::Check() const {
  limits.Check();
  FeatureOptions{FeatureType::kSift, max_features, contrast_threshold}.Check();
  match.Check();
  ransac.Check();
  homology.Check();
  gates.Check();
  panorama.Check();
  building.Check();
  if (settled_inliers < 1 || !(settled_share >= 0 && settled_share <= gates.ambiguous_share)) {
    throw MapError(ErrorCode::kBadOptions,
                   "settled_inliers must be positive and settled_share lie between 0 and "
                   "ambiguous_share; use the defaults");
  }
  if (votes_per_feature < 1 || probes < 1 || max_candidates < 1 || min_votes < 1) {
    throw MapError(ErrorCode::kBadOptions,
                   "shortlist: votes_per_feature, probes, max_candidates and min_votes must be "
                   "positive; use the defaults");
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
  Answer answer = options.TooLate()
                      ? Undecided("shortlist")
                      : Decide(index, query, static_cast<int>(shortlist.size()), tried, options);
  if (options.deadline && answer.stage.empty()) answer.stage = "decide";
  Sign(index, answer);
  answer.timing.shortlist_ms = shortlist_ms;
  answer.timing.verify_ms = timer.Lap();
  if (options.explain) answer.explanation = Explain(index, query, shortlist, tried, options);
  answer.timing.total_ms = answer.timing.shortlist_ms + answer.timing.verify_ms;
  return answer;
}

namespace {

Answer AskPanoramas(const MapIndex& index, const cv::Mat& grey, const LocalizeOptions& options) {
  if (!IsPanoramic(grey.size())) return LocalizePhoto(index, grey, options);
  if (!options.series) return LocalizePanorama(index, grey, options.panorama);
  SeriesOptions series;
  series.query = options.panorama;
  return LocalizeInSeries(index, grey, *options.series, series);
}

// Its time counts as verification, which it is.
void AddTimedBuilding(const MapIndex& index, const cv::Mat& grey, bool with_lines,
                      const LocalizeOptions& options, Answer& answer) {
  LapTimer timer;
  AddBuilding(index, grey, options, with_lines && !options.TooLate(), answer);
  const double ms = timer.Lap();
  answer.timing.verify_ms += ms;
  answer.timing.total_ms += ms;
}

}  // namespace

Answer LocalizeImage(const MapIndex& index, const cv::Mat& grey, const LocalizeOptions& options) {
  options.Check();
  if (AsksPanoramas(index, grey)) {
    Answer answer = AskPanoramas(index, grey, options);
    // Lines cost as much as features: a place that the appearance settled goes without.
    AddTimedBuilding(index, grey, answer.decided_by != "panorama_signature", options, answer);
    if (options.deadline && answer.stage.empty()) answer.stage = "decide";
    return answer;
  }
  LapTimer timer;
  const Features query = ExtractFeatures(
      grey, {index.map().info.feature_type, options.max_features, options.contrast_threshold});
  const double extract_ms = timer.Lap();
  Answer answer =
      options.TooLate() ? Undecided("extract") : LocalizeFeatures(index, query, options);
  Sign(index, answer);
  answer.timing.extract_ms = extract_ms;
  answer.timing.total_ms += extract_ms;
  AddTimedBuilding(index, grey, true, options, answer);
  return answer;
}

namespace {

// What came of decoding, which no map has a part in.
struct Decoded {
  cv::Mat grey;
  std::optional<Answer> refusal;  // instead of the image
  double ms = 0;
};

Decoded Decode(std::span<const uint8_t> bytes, const LocalizeOptions& options) {
  LapTimer timer;
  Decoded decoded;
  try {
    decoded.grey = DecodeGrey(bytes, options.limits);
    if (options.TooLate()) decoded.refusal = Undecided("decode");
  } catch (const MapError& error) {
    if (error.code() != ErrorCode::kBadImage && error.code() != ErrorCode::kImageTooLarge) throw;
    decoded.refusal.emplace();
    decoded.refusal->verdict = Verdict::kBadImage;
    decoded.refusal->decided_by = InfoOf(error.code()).name;
    decoded.refusal->message = error.what();
  }
  decoded.ms = timer.Lap();
  return decoded;
}

void Finish(const MapIndex& index, const std::string& name, double decode_ms, Answer& answer) {
  Sign(index, answer);
  answer.image = name;
  answer.timing.decode_ms = decode_ms;
  answer.timing.total_ms += decode_ms;
}

// Features of an image by their type, and how long they took.
class FeatureCache {
 public:
  explicit FeatureCache(const cv::Mat& grey) : grey_(grey) {}

  const std::pair<Features, double>& Of(FeatureType type, const LocalizeOptions& options) {
    const auto it = cache_.find(type);
    if (it != cache_.end()) return it->second;
    LapTimer timer;
    Features features =
        ExtractFeatures(grey_, {type, options.max_features, options.contrast_threshold});
    const double ms = timer.Lap();
    return cache_.emplace(type, std::pair(std::move(features), ms)).first->second;
  }

 private:
  const cv::Mat& grey_;
  std::map<FeatureType, std::pair<Features, double>> cache_;
};

}  // namespace

Answer Localize(const MapIndex& index, std::span<const uint8_t> bytes, const std::string& name,
                const LocalizeOptions& options) {
  const Decoded decoded = Decode(bytes, options);
  Answer answer = decoded.refusal ? *decoded.refusal : LocalizeImage(index, decoded.grey, options);
  Finish(index, name, decoded.ms, answer);
  return answer;
}

std::vector<Answer> LocalizeAcross(const std::vector<const MapIndex*>& maps,
                                   std::span<const uint8_t> bytes, const std::string& name,
                                   const LocalizeOptions& options) {
  options.Check();
  const Decoded decoded = Decode(bytes, options);
  FeatureCache cache(decoded.grey);
  std::vector<Answer> answers;
  for (const MapIndex* index : maps) {
    Answer answer;
    if (decoded.refusal) {
      answer = *decoded.refusal;
    } else if (AsksPanoramas(*index, decoded.grey)) {
      answer = LocalizeImage(*index, decoded.grey, options);
    } else {
      const auto& [features, extract_ms] = cache.Of(index->map().info.feature_type, options);
      answer =
          options.TooLate() ? Undecided("extract") : LocalizeFeatures(*index, features, options);
      answer.timing.extract_ms = extract_ms;
      answer.timing.total_ms += extract_ms;
      AddTimedBuilding(*index, decoded.grey, true, options, answer);
    }
    Finish(*index, name, decoded.ms, answer);
    answers.push_back(std::move(answer));
  }
  return answers;
}

}  // namespace waystone
