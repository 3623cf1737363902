// SPDX-License-Identifier: Apache-2.0
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <iostream>
#include <iterator>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "bench/accuracy/common.h"
#include "bench/accuracy/panorama_places.h"
#include "bench/accuracy/stopwatch.h"
#include "builder/appearance/describe_panorama.h"
#include "builder/calibration/appearance_calibration.h"
#include "core/base/error.h"
#include "core/base/random.h"
#include "core/camera/cube_faces.h"
#include "core/geometry/angle.h"
#include "core/image/decode.h"
#include "localizer/appearance/appearance.h"
#include "localizer/appearance/photo.h"

namespace waystone::bench {
namespace {

constexpr double kRight_m = 2.5;    // an answer nearer than this is right
constexpr double kNeighbour_m = 2;  // a place with another one within this is queried
constexpr int kRenderedPlaces = 120;
constexpr uint64_t kSeed = 1;
constexpr int kSearchedNodes = 10'000;
constexpr int kSearches = 200;
constexpr int kRuns = 20;           // whose median time is printed
constexpr double kNodeNoise = 0.1;  // of made signatures, relative

MapData DataOf(AppearanceLayer layer) {
  MapData map;
  map.info.name = "places";
  map.sequences.push_back({SequenceId{1}, "places", "panorama", 0, 0, {}});
  map.appearance = std::move(layer);
  return map;
}

// The layer of all places with their true poses, and what each showed in full.
struct PlaceMap {
  AppearanceLayer layer;
  std::vector<BearingFeatures> features;
  NodeFeatureOptions chosen_by;

  // What a node keeps when the walk didn't pass another one, as must be when that one is the query.
  NodeFeatures ChosenFor(size_t node, size_t left_out) const {
    NodeFeatureChooser chooser(chosen_by);
    const auto beside = [&](size_t at, int step) {
      at += step;
      return at == left_out ? at + step : at;  // before the first it is beyond the last
    };
    const size_t before = beside(node, -1);
    const size_t after = beside(node, 1);
    if (before < features.size()) chooser.Next(features[before]);
    chooser.Next(features[node]);
    return after < features.size() ? chooser.Next(features[after]) : chooser.Last();
  }

  PanoramaQuery Query(size_t place, bool verify) const {
    PanoramaQuery query{layer.nodes[place].signature, std::nullopt};
    if (verify) query.features = features[place];
    return query;
  }
};

// As the builder would make it with the true poses: the places in the order of their walk.
PlaceMap MapOf(const std::vector<PanoramaPlace>& places) {
  PlaceMap map;
  map.layer.metres_per_unit = 1;
  const DescribeOptions describe;
  map.layer.described = describe.signature;
  map.layer.nodes.resize(places.size());
  map.features.resize(places.size());
  tbb::parallel_for(size_t{0}, places.size(), [&](size_t i) {
    AppearanceNode& node = map.layer.nodes[i];
    node.id = AppearanceNodeId{static_cast<int64_t>(i) + 1};
    node.sequence = SequenceId{1};
    node.frame = static_cast<int>(i);
    node.source = places[i].name;
    node.pose = {places[i].position_m.x(), places[i].position_m.y(), places[i].yaw_rad};
    node.signature = Signature(places[i].grey, map.layer.described);
    map.features[i] = ExtractPanoramaFeatures(places[i].grey, describe.features.extract);
  });
  map.chosen_by = describe.features;
  tbb::parallel_for(size_t{0}, places.size(), [&](size_t i) {
    map.layer.nodes[i].features = map.ChosenFor(i, places.size());
  });
  return map;
}

struct Asked {
  Answer answer;
  bool in_map = false;  // another place is near enough
  bool right = false;
  double error_m = 0;
  double heading_error_deg = 0;
};

bool HasNeighbour(const std::vector<PanoramaPlace>& places, size_t of) {
  for (size_t i = 0; i < places.size(); ++i) {
    if (i == of || (!places[of].hidden.empty() && places[of].hidden[i])) continue;
    if ((places[i].position_m - places[of].position_m).norm() <= kNeighbour_m) return true;
  }
  return false;
}

void TakeErrors(const PanoramaPlace& place, Asked& asked) {
  const Pose2& pose = asked.answer.panorama->pose;
  asked.error_m = (Eigen::Vector2d(pose.x, pose.y) - place.position_m).norm();
  asked.heading_error_deg =
      std::abs(WrappedAngle(pose.theta_rad - place.yaw_rad)) * kDegreesPerRadian;
  asked.right = asked.error_m <= kRight_m;
}

// The map as if the walk hadn't passed this place, except for the node itself.
std::shared_ptr<const MapIndex> Without(const MapIndex& index, const PlaceMap& map, size_t place) {
  MapData data = index.map();
  for (const size_t beside : {place - 1, place + 1}) {
    if (beside >= map.features.size()) continue;
    data.appearance->nodes[beside].features = map.ChosenFor(beside, place);
  }
  return MapIndex::Build(std::move(data));
}

// Every third place calibrates the verdict, and the others are queries.
constexpr size_t kCalibrateEvery = 3;

std::vector<size_t> ListAsked(size_t places) {
  std::vector<size_t> asked;
  for (size_t i = 0; i < places; ++i) {
    if (i % kCalibrateEvery != 0) asked.push_back(i);
  }
  return asked;
}

// Queries with places, each on the map without that place.
std::vector<Asked> LeaveOneOut(const MapIndex& index, const PlaceMap& map,
                               const std::vector<PanoramaPlace>& places,
                               const PanoramaQueryOptions& options) {
  const std::vector<size_t> which = ListAsked(places.size());
  std::vector<Asked> asked(which.size());
  tbb::parallel_for(size_t{0}, which.size(), [&](size_t q) {
    const size_t i = which[q];
    std::vector<bool> left_out(places.size(), false);
    left_out[i] = true;
    Asked& result = asked[q];
    result.answer =
        LocatePanorama(*Without(index, map, i), map.Query(i, options.verify), options, left_out);
    result.in_map = HasNeighbour(places, i);
    TakeErrors(places[i], result);
  });
  return asked;
}

std::vector<Answer> AskForeign(const MapIndex& index, const PlaceMap& foreign,
                               const PanoramaQueryOptions& options) {
  std::vector<Answer> answers(foreign.features.size());
  tbb::parallel_for(size_t{0}, answers.size(), [&](size_t i) {
    answers[i] = LocatePanorama(index, foreign.Query(i, options.verify), options);
  });
  return answers;
}

// Share of the places in the map that are right and surer than every wrong answer.
double RecallAtFullPrecision(const std::vector<Asked>& asked, const std::vector<Answer>& foreign) {
  double surest_wrong = -1;
  for (const Answer& answer : foreign) surest_wrong = std::max(surest_wrong, answer.probability);
  int in_map = 0;
  for (const Asked& one : asked) {
    if (!one.right) surest_wrong = std::max(surest_wrong, one.answer.probability);
    in_map += one.in_map;
  }
  const auto recalled = std::ranges::count_if(asked, [&](const Asked& one) {
    return one.in_map && one.right && one.answer.probability > surest_wrong;
  });
  return in_map == 0 ? 0 : static_cast<double>(recalled) / in_map;
}

nlohmann::json ScoreJson(const std::string& name, const std::vector<Asked>& asked,
                         const std::vector<Answer>& foreign) {
  int in_map = 0;
  int right = 0;
  int localized = 0;
  int localized_wrong = 0;
  std::vector<double> headings;
  std::vector<double> errors;
  for (const Asked& one : asked) {
    const bool said = one.answer.verdict == Verdict::kLocalized;
    localized += said && one.in_map;
    localized_wrong += said && !one.right;
    if (said && !one.right) {
      std::printf("wrong: node %s, %.2f m off, sigma %.2f m, %.2f stated; another place %s near\n",
                  one.answer.panorama->node.source.c_str(), one.error_m, one.answer.panorama->sigma,
                  one.answer.probability, one.in_map ? "is" : "isn't");
    }
    in_map += one.in_map;
    if (!one.in_map || !one.right) continue;
    ++right;
    headings.push_back(one.heading_error_deg);
    errors.push_back(one.error_m);
  }
  const auto false_accepts = std::ranges::count_if(
      foreign, [](const Answer& answer) { return answer.verdict == Verdict::kLocalized; });
  const double share = in_map == 0 ? 0 : static_cast<double>(right) / in_map;
  const double recall = RecallAtFullPrecision(asked, foreign);
  std::printf(
      "%-22s %d asked for, %.1f %% within %.1f m (median %.2f m), heading %.2f deg; recall at 100 "
      "%% precision %.1f %%; localized %d, wrong %d; false accepts %td of %zu\n",
      name.c_str(), in_map, 100 * share, kRight_m, Quantile(errors, 0.5), Quantile(headings, 0.5),
      100 * recall, localized, localized_wrong, false_accepts, foreign.size());
  return {{"places", asked.size()},
          {"asked", in_map},
          {"right", share},
          {"position_median_m", Quantile(errors, 0.5)},
          {"heading_median_deg", Quantile(headings, 0.5)},
          {"heading_p90_deg", Quantile(headings, 0.9)},
          {"recall_at_full_precision", recall},
          {"localized", localized},
          {"localized_wrong", localized_wrong},
          {"foreign", foreign.size()},
          {"false_accepts", false_accepts}};
}

// The map's own panoramas, spread over it, as a build calibrates by them.
std::vector<AppearanceSampleFrame> SamplesOf(const PlaceMap& map) {
  std::vector<AppearanceSampleFrame> samples;
  for (size_t i = 0; i < map.features.size(); i += kCalibrateEvery) {
    const AppearanceNode& node = map.layer.nodes[i];
    samples.push_back({node.signature, map.features[i], node.pose, static_cast<int>(i),
                       node.sequence, FrameInfo{node.frame, node.source, node.time_s}});
  }
  return samples;
}

nlohmann::json ModelJson(const AppearanceVerdict& model) {
  nlohmann::json json = {{"intercept", model.intercept},
                         {"positives", model.positives},
                         {"negatives", model.negatives}};
  for (const VerdictTerm& term : model.terms) json[term.name] = term.weight;
  return json;
}

// The layer with its verdict, as a build calibrates it.
MapData Calibrate(const PlaceMap& map) {
  MapData data = DataOf(map.layer);
  const AppearanceCalibrationOptions calibration;
  ProgressReporter silent;
  CalibrateAppearanceLayer(data, SamplesOf(map), calibration, silent);
  return data;
}

PanoramaQueryOptions QueryOptions(bool verify) {
  PanoramaQueryOptions options;
  options.verify = verify;
  return options;
}

const char* KindOf(bool verify) { return verify ? "verified" : "appearance"; }

nlohmann::json ScoreMap(const std::string& name, const std::vector<PanoramaPlace>& places,
                        const PlaceMap& map, const PlaceMap& foreign) {
  MapData data = Calibrate(map);
  const AppearanceVerdict models[] = {*data.appearance->verdict,
                                      *data.appearance->verified_verdict};
  const auto index = MapIndex::Build(std::move(data));
  std::printf("%s: a place is %.2f m large\n", name.c_str(), index->appearance().spacing());
  nlohmann::json json;
  for (const bool verify : {false, true}) {
    const PanoramaQueryOptions options = QueryOptions(verify);
    const char* kind = KindOf(verify);
    json[kind] = ScoreJson(name + ", " + kind, LeaveOneOut(*index, map, places, options),
                           AskForeign(*index, foreign, options));
    json[kind]["model"] = ModelJson(models[verify]);
  }
  return json;
}

// Made flats, each a map of its own, also queried with the places of the one before. Nothing was
// chosen by these seeds.
nlohmann::json ScoreFlats() {
  constexpr uint64_t kFlats = 6;
  constexpr uint64_t kFirstFlat = 101;
  std::vector<Asked> asked[2];
  std::vector<Answer> answers[2];
  PlaceMap before = MapOf(InWalkOrder(RenderFlatPlaces(kFirstFlat + kFlats)));
  for (uint64_t seed = kFirstFlat; seed < kFirstFlat + kFlats; ++seed) {
    const std::vector<PanoramaPlace> places = InWalkOrder(RenderFlatPlaces(seed));
    PlaceMap map = MapOf(places);
    const auto index = MapIndex::Build(Calibrate(map));
    for (const bool verify : {false, true}) {
      const PanoramaQueryOptions options = QueryOptions(verify);
      std::ranges::move(LeaveOneOut(*index, map, places, options),
                        std::back_inserter(asked[verify]));
      std::ranges::move(AskForeign(*index, before, options), std::back_inserter(answers[verify]));
    }
    before = std::move(map);
  }
  nlohmann::json json;
  for (const bool verify : {false, true}) {
    const char* kind = KindOf(verify);
    json[kind] = ScoreJson(std::string("flats, ") + kind, asked[verify], answers[verify]);
  }
  return json;
}

// A square photo of 90 degrees to the front of each place: a rig's own face where there is one,
// otherwise rendered from the panorama.
cv::Mat FrontOf(const PanoramaPlace& place, const std::filesystem::path& rigs) {
  const std::filesystem::path face = rigs / place.name / "front.jpg";
  if (std::filesystem::exists(face)) return DecodeGrey(ReadBytes(face));
  constexpr double kOfWidth = 0.318;
  return FaceOf(place.grey, CubeFace::kFront, static_cast<int>(kOfWidth * place.grey.cols));
}

// The camera of a square photo of 90 degrees.
Camera PhotoCamera(int width_px) {
  const double middle = (width_px - 1) / 2.0;
  return {
      CameraModel::kPinhole, width_px, width_px, {width_px / 2.0, width_px / 2.0, middle, middle}};
}

// Perspective photos queried against the panoramas, each without its own place.
nlohmann::json ScorePhotos(const std::string& name, const std::vector<PanoramaPlace>& places,
                           const PlaceMap& map, const std::vector<PanoramaPlace>& foreign,
                           const std::filesystem::path& rigs) {
  const auto index = MapIndex::Build(Calibrate(map));
  const std::vector<size_t> which = ListAsked(places.size());
  std::vector<Asked> asked(which.size());
  tbb::parallel_for(size_t{0}, which.size(), [&](size_t q) {
    const size_t i = which[q];
    std::vector<bool> left_out(places.size(), false);
    left_out[i] = true;
    const cv::Mat photo = FrontOf(places[i], rigs);
    Asked& result = asked[q];
    result.answer =
        LocalizePhoto(*Without(*index, map, i), photo, PhotoCamera(photo.cols), {}, {}, left_out);
    result.in_map = HasNeighbour(places, i);
    if (!result.answer.panorama) return;
    TakeErrors(places[i], result);
  });
  std::vector<Answer> answers(foreign.size());
  tbb::parallel_for(size_t{0}, foreign.size(), [&](size_t i) {
    const cv::Mat photo = FrontOf(foreign[i], {});
    answers[i] = LocalizePhoto(*index, photo, PhotoCamera(photo.cols), {});
  });
  return ScoreJson(name + ", photos", asked, answers);
}

template <typename Work>
double MedianMs(int runs, const Work& work) {
  std::vector<double> times;
  for (int run = 0; run < runs; ++run) {
    const Stopwatch watch;
    work(run);
    times.push_back(1e3 * watch.cpu_s());
  }
  return Quantile(times, 0.5);
}

// Many nodes: those of a layer, each magnitude scaled at random.
AppearanceLayer Multiplied(const AppearanceLayer& layer, int count) {
  AppearanceLayer many;
  many.described = layer.described;
  Random random(kSeed);
  for (int i = 0; i < count; ++i) {
    AppearanceNode node;
    node.pose = {static_cast<double>(i), 0, 0};
    node.signature = layer.nodes[i % layer.nodes.size()].signature;
    for (Eigen::half& value : node.signature.magnitudes.reshaped()) {
      const double noisy = static_cast<float>(value) * (1 + kNodeNoise * random.Normal());
      value = Eigen::half(static_cast<float>(std::abs(noisy)));
    }
    many.nodes.push_back(std::move(node));
  }
  return many;
}

nlohmann::json Times(const std::vector<PanoramaPlace>& places, AppearanceLayer layer) {
  cv::Mat image;
  cv::resize(places[0].grey, image, {1024, 512}, 0, 0, cv::INTER_LINEAR);
  std::vector<uint8_t> jpeg;
  cv::imencode(".jpg", image, jpeg);
  const AppearanceIndex many(Multiplied(layer, kSearchedNodes));
  const auto index = MapIndex::Build(DataOf(std::move(layer)));
  const auto ask = [&](bool fine, bool verify) {
    LocalizeOptions options;
    options.panorama.fine_heading = fine;
    options.panorama.verify = verify;
    return MedianMs(kRuns, [&](int) { Localize(*index, jpeg, "query", options); });
  };
  const std::vector<AppearanceNode>& nodes = index->map().appearance->nodes;
  nlohmann::json times = {
      {"decode_ms", MedianMs(kRuns, [&](int) { DecodeGrey(jpeg); })},
      {"search_10000_ms",
       MedianMs(kSearches, [&](int run) { many.Nearest(nodes[run % nodes.size()].signature, 8); })},
      {"query_phases_ms", ask(false, false)},
      {"query_ms", ask(true, false)},
      {"query_verified_ms", ask(true, true)}};
  for (const auto& [name, value] : times.items()) {
    std::printf("%s %.3f  ", name.c_str(), value.get<double>());
  }
  std::printf("\n");
  return times;
}

}  // namespace

int RunKidnapped(const Args& args) {
  if (args.size() > 1) throw MapError(ErrorCode::kUsage, "kidnapped takes one folder at most");
  cv::setNumThreads(1);
  const std::vector<PanoramaPlace> rendered = InWalkOrder(RenderPlaces(kRenderedPlaces, kSeed));
  const PlaceMap world = MapOf(rendered);
  nlohmann::json json = {{"bench", "kidnapped"}};
  if (args.empty()) {
    json["world"] = ScoreMap("world", rendered, world, {});
  } else {
    const std::vector<PanoramaPlace> places = InWalkOrder(ReadPlaces(args[0]));
    const PlaceMap map = MapOf(places);
    json["places"] = ScoreMap("places", places, map, world);
    json["photos"] =
        ScorePhotos("places", places, map, rendered, std::filesystem::path(args[0]) / "rig");
    json["world"] = ScoreMap("world", rendered, world, map);
  }
  json["flats"] = ScoreFlats();
  json["times"] = Times(rendered, world.layer);
  std::cout << json.dump() << std::endl;
  return 0;
}

}  // namespace waystone::bench
