// SPDX-License-Identifier: Apache-2.0
#include "localizer/localizer.h"

#include <utility>

#include "core/base/clock.h"
#include "core/base/error.h"
#include "core/camera/panorama.h"
#include "localizer/appearance/appearance.h"
#include "localizer/appearance/photo.h"
#include "localizer/known_features.h"
#include "localizer/orientation/building.h"
#include "localizer/planes/image_features.h"
#include "localizer/planes/locate.h"
#include "localizer/poses/locate_pose.h"
#include "localizer/poses/node_pose.h"
#include "localizer/verdict/answered_place.h"

namespace waystone {
namespace {

void Sign(const MapIndex& index, Answer& answer) {
  answer.map = index.map().info.name;
  answer.map_version = index.map().info.version;
}

// Whether the map's panoramas are queried rather than its planes.
bool AsksPanoramas(const MapIndex& index, const cv::Mat& grey, const LocalizeOptions& options) {
  const bool panoramic = options.series || IsForPanoramas(index, grey.size());
  return index.HasAppearance() && (panoramic || !index.HasKeyframeFeatures());
}

Answer AskPanoramas(const MapIndex& index, const cv::Mat& grey, const LocalizeOptions& options) {
  if (options.series) {
    SeriesOptions series;
    series.query = options.panorama;
    return LocalizeInSeries(index, grey, *options.series, series);
  }
  if (IsForPanoramas(index, grey.size())) return LocalizePanorama(index, grey, options.panorama);
  return LocalizePhoto(index, grey, options.camera, options.panorama, options.deadline);
}

// Its time counts as verification.
void AddTimedBuilding(const MapIndex& index, const cv::Mat& grey, const LocalizeOptions& options,
                      Answer& answer) {
  LapTimer timer;
  BuildingQuery query;
  // Panoramas need no camera. A wide photo that planes answered has one.
  const bool of_panorama = answer.panorama && IsForPanoramas(index, grey.size());
  if (!of_panorama) query.camera = options.camera;
  // Lines take as long as features, so they are skipped where the appearance settled the place. A
  // mirror's image has no straight lines.
  const bool straight = !of_panorama || HasPanoramaShape(grey.size());
  query.with_lines =
      straight && answer.decided_by != DecidedBy::kPanoramaSignature && !options.TooLate();
  query.min_probability =
      answer.panorama ? options.panorama.min_probability : options.planes.gates.min_probability;
  AddBuilding(index, grey, query, options.building, answer);
  const double ms = timer.Lap();
  answer.timing.verify_ms += ms;
  answer.timing.total_ms += ms;
}

void AddTimedPose(const MapIndex& index, const Features& features, const LocalizeOptions& options,
                  Answer& answer) {
  LapTimer timer;
  AddPose(index, features, options.camera, options.pose, answer);
  const double ms = timer.Lap();
  answer.timing.pose_ms = ms;
  answer.timing.total_ms += ms;
}

// The answer by planes and landmarks.
Answer AskKeyframes(const MapIndex& index, const cv::Mat& grey, ImageFeatures& extracted,
                    const LocalizeOptions& options) {
  const auto& [features, extract_ms] =
      extracted.Extract(grey, QueryFeatureOptions(index, options.planes));
  options.Finish(Stage::kExtract);
  Answer answer =
      options.TooLate() ? Undecided(Stage::kExtract) : LocalizeFeatures(index, features, options);
  ToImagePixels(features, answer.planes);
  answer.timing.extract_ms = extract_ms;
  answer.timing.total_ms += extract_ms;
  return answer;
}

// Adds the name that people gave to the place of a localized answer.
void NamePlace(const MapIndex& index, Answer& answer) {
  const std::optional<AnsweredPlace> place = PlaceOf(answer);
  const NamedPlaces& names = index.names();
  if (!place || names.empty()) return;
  PlaceEvidence evidence;
  if (place->layer == PlaceLayer::kPlanes) {
    evidence.keyframe = KeyframeId{place->id};
    if (!answer.planes.recognised.empty()) evidence.plane = answer.planes.recognised.front().id;
    evidence.position = answer.pose ? names.PositionOf(answer.pose->frame_from_camera.translation())
                                    : names.PositionOf(*evidence.keyframe);
  } else {
    evidence.node = AppearanceNodeId{place->id};
    evidence.position = names.PositionOf(answer.panorama->pose);
  }
  if (const std::string* name = names.Find(evidence)) answer.place_name = *name;
}

// Adds the position on a floor plan: only from the query's own position, not from the nearest
// keyframe's.
void FindOnPlan(const MapIndex& index, Answer& answer) {
  if (answer.verdict != Verdict::kLocalized) return;
  if (answer.pose) {
    answer.plan = index.floor_plans().Find(answer.pose->frame_from_camera.translation());
  } else if (answer.panorama) {
    answer.plan = index.floor_plans().Find(answer.panorama->pose);
  }
}

// Where a decoded image was taken, by the layer that answers such images.
Answer AskLayers(const MapIndex& index, const cv::Mat& grey, ImageFeatures& extracted,
                 const LocalizeOptions& options) {
  Answer answer;
  bool by_panoramas = AsksPanoramas(index, grey, options);
  if (by_panoramas) {
    answer = AskPanoramas(index, grey, options);
    if (options.deadline && !answer.last_stage) answer.last_stage = Stage::kDecide;
  }
  const bool known = answer.verdict == Verdict::kLocalized || answer.verdict == Verdict::kAmbiguous;
  if (!by_panoramas || (!known && !options.series && MayBePhoto(index, grey.size()))) {
    const double before_ms = answer.timing.total_ms;
    answer = AskKeyframes(index, grey, extracted, options);
    answer.timing.total_ms += before_ms;
    by_panoramas = false;
  }
  AddTimedBuilding(index, grey, options, answer);
  // A panorama whose place the axes refuse gives no belief for the next one.
  if (answer.decided_by == DecidedBy::kBuildingAxes) {
    answer.belief = options.series ? options.series->previous : FilterState{};
  }
  // Last, since lines may still refuse the place.
  if (by_panoramas) {
    AddNodePose(index, answer);
  } else if (index.map().poses && options.TooLate()) {
    answer.pose_reason = answer.verdict == Verdict::kLocalized
                             ? "the deadline passed before the pose was estimated"
                             : "not localized";
  } else if (index.map().poses) {
    const auto& [features, ms] =
        extracted.Extract(grey, QueryFeatureOptions(index, options.planes));
    AddTimedPose(index, features, options, answer);
  }
  NamePlace(index, answer);
  FindOnPlan(index, answer);
  Sign(index, answer);
  return answer;
}

// The result of decoding, which doesn't depend on any map.
struct Decoded {
  cv::Mat grey;
  std::optional<Answer> refusal;  // instead of the image
  double ms = 0;
};

Decoded Decode(std::span<const uint8_t> bytes, const LocalizeOptions& options) {
  LapTimer timer;
  Decoded decoded;
  options.Finish(Stage::kQueue);
  try {
    if (options.TooLate()) {
      CheckLimits(ReadImageHeader(bytes), options.limits);  // undecodable images are reported first
      decoded.refusal = Undecided(Stage::kQueue);
    } else {
      decoded.grey = DecodeGrey(bytes, options.limits);
      options.Finish(Stage::kDecode);
      if (options.TooLate()) decoded.refusal = Undecided(Stage::kDecode);
    }
  } catch (const MapError& error) {
    if (error.code() != ErrorCode::kBadImage && error.code() != ErrorCode::kImageTooLarge) throw;
    decoded.refusal = RefuseImage(error);
  }
  if (decoded.refusal && options.series) decoded.refusal->belief = options.series->previous;
  decoded.ms = timer.Lap();
  return decoded;
}

}  // namespace

void LocalizeOptions::Check() const {
  limits.Check();
  planes.Check();
  panorama.Check();
  building.Check();
  CheckFields("pose", pose);
}

Answer LocalizeFeatures(const MapIndex& index, const Features& query,
                        const LocalizeOptions& options) {
  options.Check();
  Answer answer = LocateByPlanes(index, query, options.planes, options.deadline, options.explain);
  Sign(index, answer);
  return answer;
}

Answer LocalizeImage(const MapIndex& index, const cv::Mat& grey, const LocalizeOptions& options) {
  options.Check();
  ImageFeatures extracted;
  return AskLayers(index, grey, extracted, options);
}

namespace {

std::vector<Answer> AskDecoded(const std::vector<const MapIndex*>& maps, const Decoded& decoded,
                               const std::string& name, const LocalizeOptions& options,
                               ImageFeatures& extracted) {
  std::vector<Answer> answers;
  for (const MapIndex* index : maps) {
    Answer answer =
        decoded.refusal ? *decoded.refusal : AskLayers(*index, decoded.grey, extracted, options);
    Sign(*index, answer);
    answer.image = name;
    answer.timing.decode_ms = decoded.ms;
    answer.timing.total_ms += decoded.ms;
    answers.push_back(std::move(answer));
  }
  return answers;
}

}  // namespace

std::vector<Answer> LocalizeAcross(const std::vector<const MapIndex*>& maps,
                                   std::span<const uint8_t> bytes, const std::string& name,
                                   const LocalizeOptions& options) {
  ImageFeatures extracted;
  return LocalizeAcross(maps, bytes, name, options, extracted);
}

std::vector<Answer> LocalizeAcross(const std::vector<const MapIndex*>& maps,
                                   std::span<const uint8_t> bytes, const std::string& name,
                                   const LocalizeOptions& options, ImageFeatures& features) {
  options.Check();
  return AskDecoded(maps, Decode(bytes, options), name, options, features);
}

std::vector<Answer> LocalizeAcross(const std::vector<const MapIndex*>& maps, const cv::Mat& grey,
                                   const std::string& name, const LocalizeOptions& options) {
  options.Check();
  ImageFeatures extracted;
  return AskDecoded(maps, {.grey = grey, .refusal = {}}, name, options, extracted);
}

Answer Localize(const MapIndex& index, std::span<const uint8_t> bytes, const std::string& name,
                const LocalizeOptions& options) {
  return LocalizeAcross({&index}, bytes, name, options).front();
}

}  // namespace waystone
