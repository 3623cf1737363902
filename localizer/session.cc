// SPDX-License-Identifier: Apache-2.0
#include "localizer/session.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <span>
#include <utility>

#include "core/base/check.h"
#include "core/base/clock.h"
#include "core/base/error.h"
#include "core/geometry/angle.h"
#include "localizer/appearance/appearance.h"
#include "localizer/known_features.h"
#include "localizer/localizer.h"

namespace waystone {
namespace {

// Ranks verdicts by how informative they are, the most informative first.
int RankOf(Verdict verdict) {
  switch (verdict) {
    case Verdict::kLocalized:
      return 0;
    case Verdict::kAmbiguous:
      return 1;
    case Verdict::kNotInMap:
      return 2;
    case Verdict::kUndecided:
      return 3;
    case Verdict::kBadImage:
      return 4;
  }
  WS_CHECK(false, "unknown verdict");
}

bool IsBetter(const Answer& a, const Answer& b) {
  if (a.verdict != b.verdict) return RankOf(a.verdict) < RankOf(b.verdict);
  return a.probability > b.probability;
}

size_t FindBestImage(const RequestAnswer& answer) {
  size_t best = 0;
  for (size_t i = 1; i < answer.images.size(); ++i) {
    if (IsBetter(answer.images[i].front(), answer.images[best].front())) best = i;
  }
  return best;
}

std::span<const uint8_t> EncodedBytes(const QueryImage& image) {
  return {reinterpret_cast<const uint8_t*>(image.bytes.data()), image.bytes.size()};
}

std::vector<Answer> AskIndices(const std::vector<const MapIndex*>& indices, const QueryImage& image,
                               const LocalizeOptions& options) {
  if (!image.grey.empty()) return LocalizeAcross(indices, image.grey, image.name, options);
  const std::span<const uint8_t> bytes = EncodedBytes(image);
  if (!image.features) return LocalizeAcross(indices, bytes, image.name, options);
  return LocalizeAcross(indices, bytes, image.name, options, *image.features);
}

// From its header; nothing for bytes that aren't an image.
std::optional<cv::Size> SizeOf(const QueryImage& image) {
  if (!image.grey.empty()) return image.grey.size();
  try {
    const ImageHeader header = ReadImageHeader(EncodedBytes(image));
    return cv::Size(header.width, header.height);
  } catch (const MapError& error) {
    if (error.code() != ErrorCode::kBadImage) throw;
    return std::nullopt;
  }
}

// Bytes that aren't an image fit either way.
bool LooksLikePhoto(const MapIndex& index, const QueryImage& image) {
  const std::optional<cv::Size> size = SizeOf(image);
  return size && !IsForPanoramas(index, *size);
}

// The belief of a previous answer; nothing without one of this version of the map.
std::optional<FilterState> TakeBelief(const std::optional<PreviousAnswer>& previous,
                                      const MapData& map) {
  if (!previous || !previous->belief) return std::nullopt;
  if (previous->map_version && *previous->map_version != map.info.version) return std::nullopt;
  const std::vector<AppearanceNode>& nodes = map.appearance->nodes;
  FilterState belief;
  for (const NodeBelief& one : *previous->belief) {
    const auto node = std::ranges::lower_bound(nodes, one.node, {}, &AppearanceNode::id);
    if (node == nodes.end() || node->id != one.node) {
      throw MapError(ErrorCode::kBadRequest, "previous.belief: the map has no panorama " +
                                                 std::to_string(one.node.value) +
                                                 "; omit `previous` after the map has changed");
    }
    // At most half a turn: a whole one could be rounded to more than requests may have.
    const double heading_rad = std::remainder(one.heading_rad, 2 * kPi);
    belief.push_back(
        {static_cast<int>(node - nodes.begin()), one.probability, heading_rad, one.sigma_rad});
  }
  return belief;
}

// The belief for clients: rounded to fewer bytes, without entries that round to 0.
std::optional<std::vector<NodeBelief>> GiveBelief(const FilterState& belief, const MapData& map) {
  constexpr double kProbabilities = 1e6;  // steps; rounded down, so that the sum can't exceed 1
  constexpr double kAngles = 1e5;         // steps of a radian
  if (belief.empty()) return std::nullopt;
  const auto rounded = [](double angle_rad) { return std::round(angle_rad * kAngles) / kAngles; };
  std::vector<NodeBelief> given;
  for (const Belief& one : belief) {
    const double probability = std::floor(one.probability * kProbabilities) / kProbabilities;
    if (probability == 0) continue;
    given.push_back({map.appearance->nodes[one.node].id, probability, rounded(one.heading_rad),
                     std::max(1 / kAngles, rounded(one.sigma_rad))});
  }
  return given;
}

}  // namespace

Series::Series(QueriedMap map, LocalizeOptions options, FilterState previous)
    : map_(std::move(map)), options_(std::move(options)), belief_(std::move(previous)) {
  WS_CHECK(map_.index->HasAppearance(), "the map has no appearance layer");
}

Answer Series::Ask(const QueryImage& image, const std::optional<Pose2>& odometry) {
  if (LooksLikePhoto(*map_.index, image)) {
    Answer refused = RefuseImage(
        MapError(ErrorCode::kBadImage,
                 "not a panorama, which is twice as wide as high or as the map's mirror images; a "
                 "series takes panoramas only"));
    refused.map_version = map_.index->map().info.version;
    refused.image = image.name;
    refused.map = map_.name;
    return refused;
  }
  LocalizeOptions options = options_;
  options.series = SeriesContext{belief_, odometry, described_};
  Answer answer = AskIndices({map_.index.get()}, image, options).front();
  answer.map = map_.name;
  if (answer.verdict != Verdict::kBadImage && answer.verdict != Verdict::kUndecided) {
    belief_ = answer.belief;
    described_ = answer.described;
  }
  return answer;
}

Session::Session(QueryRequest request, std::vector<QueriedMap> maps, const LocalizeOptions& options,
                 bool is_lot)
    : request_(std::move(request)), maps_(std::move(maps)), options_(options), is_lot_(is_lot) {
  WS_CHECK(!maps_.empty() && !request_.images.empty(), "a request without a map or an image");
  const MapIndex& first = *maps_.front().index;
  if (request_.prior_keyframe && !first.FindKeyframe(*request_.prior_keyframe)) {
    throw MapError(ErrorCode::kBadRequest, "prior: the map has no keyframe " +
                                               std::to_string(request_.prior_keyframe->value));
  }
  camera_ = ResolveCamera(request_, first.map(), request_.images.front());
  if (camera_) options_.camera = camera_->camera;
  options_.explain = request_.debug;
  options_.finished = std::make_shared<std::atomic<Stage>>(Stage::kQueue);
  if (request_.deadline_ms) {
    options_.deadline =
        request_.received.value_or(Clock::now()) + std::chrono::milliseconds(*request_.deadline_ms);
  }
}

bool Session::AsksOnePanoramaMap() const {
  return maps_.size() == 1 && !is_lot_ && maps_.front().index->HasAppearance();
}

bool Session::HasPhotos() const {
  return std::ranges::any_of(request_.images, [&](const QueryImage& image) {
    return LooksLikePhoto(*maps_.front().index, image);
  });
}

bool Session::MayHavePhotos() const {
  return std::ranges::any_of(request_.images, [&](const QueryImage& image) {
    const std::optional<cv::Size> size = SizeOf(image);
    return size && MayBePhoto(*maps_.front().index, *size);
  });
}

RequestAnswer Session::Ask() const {
  if (AsksOnePanoramaMap() && !HasPhotos()) {
    const auto previous = TakeBelief(request_.previous, maps_.front().index->map());
    // Several images that may be photos are a series only with odometry or a belief.
    const bool several =
        request_.images.size() > 1 && (!request_.odometry.empty() || !MayHavePhotos());
    if (previous || several) return AskSeries(previous);
  }
  return AskEach();
}

RequestAnswer Session::AskSeries(const std::optional<FilterState>& previous) const {
  RequestAnswer result;
  result.series = true;
  result.used_previous = previous.has_value();
  Series series(maps_.front(), options_, previous.value_or(FilterState{}));
  for (size_t i = 0; i < request_.images.size(); ++i) {
    Answer answer = series.Ask(request_.images[i],
                               request_.odometry.empty() ? std::nullopt : request_.odometry[i]);
    if (answer.verdict != Verdict::kBadImage && answer.verdict != Verdict::kUndecided) {
      result.best = i;
    }
    result.images.push_back({std::move(answer)});
  }
  result.belief = GiveBelief(series.belief(), maps_.front().index->map());
  return result;
}

std::vector<Answer> Session::AskMaps(const QueryImage& image) const {
  std::vector<const MapIndex*> indices;
  for (const QueriedMap& map : maps_) indices.push_back(map.index.get());
  std::vector<Answer> answers = AskIndices(indices, image, options_);
  // Answers have the name by which a map is queried, not the one with which it was built.
  for (size_t i = 0; i < maps_.size(); ++i) answers[i].map = maps_[i].name;
  std::ranges::stable_sort(answers, IsBetter);
  return answers;
}

RequestAnswer Session::AskEach() const {
  RequestAnswer result;
  result.min_panorama_probability = options_.panorama.min_probability;
  const bool photos = AsksOnePanoramaMap() && HasPhotos();
  result.used_camera = std::ranges::any_of(maps_, [&](const QueriedMap& map) {
    const MapData& data = map.index->map();
    return data.orientation || data.poses || (photos && !map.index->HasKeyframeFeatures());
  });
  for (const QueryImage& image : request_.images) result.images.push_back(AskMaps(image));
  result.best = FindBestImage(result);
  if (AsksOnePanoramaMap()) {
    result.belief =
        GiveBelief(result.images[result.best].front().belief, maps_.front().index->map());
  }
  return result;
}

RequestAnswer Session::TimeOut() const {
  RequestAnswer result;
  for (const QueryImage& image : request_.images) {
    std::vector<Answer>& answers = result.images.emplace_back();
    for (const QueriedMap& map : maps_) {
      Answer& answer = answers.emplace_back(Undecided(*options_.finished));
      answer.image = image.name;
      answer.map = map.name;
      answer.map_version = map.index->map().info.version;
    }
  }
  return result;
}

RequestAnswer Joined(std::vector<RequestAnswer> lots) {
  RequestAnswer all = std::move(lots.front());
  for (size_t lot = 1; lot < lots.size(); ++lot) {
    all.used_camera |= lots[lot].used_camera;
    for (size_t i = 0; i < all.images.size(); ++i) {
      std::ranges::move(lots[lot].images.at(i), std::back_inserter(all.images[i]));
    }
  }
  for (std::vector<Answer>& answers : all.images) {
    std::ranges::sort(answers, {}, &Answer::map);  // ties are broken as by one session
    std::ranges::stable_sort(answers, IsBetter);
  }
  all.best = FindBestImage(all);
  return all;
}

namespace {

// Whether the map contains the place: once, or at several places that look alike.
bool IsRecognised(const Answer& answer, double min_panorama_probability) {
  if (answer.verdict == Verdict::kLocalized) return true;
  if (answer.verdict != Verdict::kAmbiguous) return false;
  // Planes give this verdict only where the best place is probable enough. Panoramas' places share
  // the answer's probability, so the best place's own one is checked.
  if (!answer.panorama || answer.panorama->candidates.empty()) return true;
  return answer.panorama->candidates.front().probability >= min_panorama_probability;
}

// A panorama's place has no keyframe.
void AppendPlaces(const Answer& answer, std::vector<PlaceCandidate>& places) {
  const PlaneAnswer& planes = answer.planes;
  if (planes.keyframe) {
    const int inliers =
        planes.candidates.empty() ? CountBestInliers(planes) : planes.candidates.front().inliers;
    places.push_back({*planes.keyframe, answer.probability, inliers});
  }
  places.insert(places.end(), planes.places.begin(), planes.places.end());
}

// An answer without what holds only for its own place.
Answer WithoutPlace(Answer answer) {
  if (answer.pose) answer.pose_reason = "several maps contain this place";
  answer.pose.reset();
  answer.planes.keyframe.reset();
  answer.heading.reset();
  answer.building.reset();
  answer.place_name.reset();
  answer.plan.reset();
  return answer;
}

}  // namespace

Answer OverallAnswer(const RequestAnswer& answer) {
  const std::vector<Answer>& maps = answer.images.at(answer.best);
  std::string names;
  std::vector<PlaceCandidate> places;
  int recognised = 0;
  for (const Answer& one : maps) {
    if (!IsRecognised(one, answer.min_panorama_probability)) continue;
    names += (recognised++ == 0 ? "" : ", ") + one.map;
    AppendPlaces(one, places);
  }
  if (recognised < 2) return maps.front();
  Answer best = WithoutPlace(maps.front());
  best.verdict = Verdict::kAmbiguous;
  best.decided_by = DecidedBy::kAmbiguousMaps;
  best.message = std::to_string(recognised) + " maps contain this place (" + names +
                 "); `maps` ranks them, query one of them for its full answer";
  best.planes.places = std::move(places);
  return best;
}

}  // namespace waystone
