// SPDX-License-Identifier: Apache-2.0
#include <tbb/parallel_for.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <iostream>
#include <numbers>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "bench/accuracy/common.h"
#include "bench/accuracy/panorama_places.h"
#include "builder/appearance_calibration.h"
#include "core/base/error.h"
#include "core/base/random.h"
#include "core/image/decode.h"
#include "localizer/appearance.h"

namespace waystone::bench {
namespace {

constexpr double kDegrees = 180 / std::numbers::pi;
constexpr double kRight_m = 2.5;    // an answer nearer than this is right
constexpr double kNeighbour_m = 2;  // a place with another one within this is asked for
constexpr int kRenderedPlaces = 120;
constexpr uint64_t kSeed = 1;
constexpr int kSearchedNodes = 10'000;
constexpr int kSearches = 200;
constexpr int kRuns = 20;           // whose median time is printed
constexpr double kNodeNoise = 0.1;  // of made signatures, relative

std::shared_ptr<const MapIndex> IndexOf(AppearanceLayer layer) {
  MapData map;
  map.info.name = "places";
  map.sequences.push_back({SequenceId{1}, "places", "panorama", 0, 0, {}});
  map.appearance = std::move(layer);
  return MapIndex::Build(std::move(map));
}

// The layer of all places with their true poses.
AppearanceLayer LayerOf(const std::vector<PanoramaPlace>& places, bool features) {
  AppearanceLayer layer;
  layer.metres_per_unit = 1;
  layer.nodes.resize(places.size());
  tbb::parallel_for(size_t{0}, places.size(), [&](size_t i) {
    AppearanceNode& node = layer.nodes[i];
    node.id = AppearanceNodeId{static_cast<int64_t>(i) + 1};
    node.sequence = SequenceId{1};
    node.frame = static_cast<int>(i);
    node.source = places[i].name;
    node.pose = {places[i].position_m.x(), places[i].position_m.y(), places[i].yaw_rad};
    node.signature = Signature(places[i].grey, layer.described);
    if (features) node.features = ToNodeFeatures(ExtractPanoramaFeatures(places[i].grey));
  });
  return layer;
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

// Each place asked for without itself.
std::vector<Asked> LeaveOneOut(const MapIndex& index, const std::vector<PanoramaPlace>& places,
                               const PanoramaQueryOptions& options) {
  std::vector<Asked> asked(places.size());
  tbb::parallel_for(size_t{0}, places.size(), [&](size_t i) {
    std::vector<bool> left_out(places.size(), false);
    left_out[i] = true;
    const PanoramaQuery query = QueryOfNode(index, static_cast<int>(i), options);
    Asked& result = asked[i];
    result.answer = LocatePanorama(index, query, options, left_out);
    result.in_map = HasNeighbour(places, i);
    const Pose2& pose = result.answer.panorama->pose;
    result.error_m = (Eigen::Vector2d(pose.x, pose.y) - places[i].position_m).norm();
    result.heading_error_deg =
        std::abs(WrappedAngle(pose.theta_rad - places[i].yaw_rad)) * kDegrees;
    result.right = result.error_m <= kRight_m;
  });
  return asked;
}

std::vector<Answer> AskForeign(const MapIndex& index, const AppearanceLayer& foreign,
                               const PanoramaQueryOptions& options) {
  const auto other = IndexOf(foreign);
  std::vector<Answer> answers(foreign.nodes.size());
  tbb::parallel_for(size_t{0}, answers.size(), [&](size_t i) {
    answers[i] = LocatePanorama(index, QueryOfNode(*other, static_cast<int>(i), options), options);
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
  return {{"asked", in_map},
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

nlohmann::json ScoreMap(const std::string& name, const std::vector<PanoramaPlace>& places,
                        AppearanceLayer layer, const AppearanceLayer& foreign) {
  nlohmann::json json;
  for (const bool verify : {false, true}) {
    PanoramaQueryOptions options;
    options.verify = verify;
    AppearanceCalibrationOptions calibration;
    calibration.query = options;
    layer.verdict = CalibrateAppearance(*IndexOf(layer), {}, calibration);
    const auto index = IndexOf(layer);
    json[verify ? "verified" : "appearance"] =
        ScoreJson(name + (verify ? ", verified" : ", appearance"),
                  LeaveOneOut(*index, places, options), AskForeign(*index, foreign, options));
    json[verify ? "verified" : "appearance"]["model"] = {
        layer.verdict->intercept, layer.verdict->terms[0].weight, layer.verdict->terms[1].weight};
  }
  return json;
}

template <typename Work>
double MedianMs(int runs, const Work& work) {
  std::vector<double> times;
  for (int run = 0; run < runs; ++run) {
    const auto start = std::chrono::steady_clock::now();
    work(run);
    const std::chrono::duration<double, std::milli> took = std::chrono::steady_clock::now() - start;
    times.push_back(took.count());
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
  const auto index = IndexOf(std::move(layer));
  const auto ask = [&](bool fine, bool verify) {
    LocalizeOptions options;
    options.panorama.fine_heading = fine;
    options.panorama.verify = verify;
    return MedianMs(kRuns, [&](int) { Localize(*index, jpeg, "query", options); });
  };
  const std::vector<AppearanceNode>& nodes = index->map().appearance->nodes;
  const nlohmann::json times = {
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
  const std::vector<PanoramaPlace> rendered = RenderPlaces(kRenderedPlaces, kSeed);
  const AppearanceLayer world = LayerOf(rendered, true);
  nlohmann::json json = {{"bench", "kidnapped"}};
  if (args.empty()) {
    json["world"] = ScoreMap("world", rendered, world, {});
  } else {
    const std::vector<PanoramaPlace> places = ReadPlaces(args[0]);
    const AppearanceLayer layer = LayerOf(places, true);
    json["places"] = ScoreMap("places", places, layer, world);
    json["world"] = ScoreMap("world", rendered, world, layer);
  }
  json["times"] = Times(rendered, world);
  std::cout << json.dump() << std::endl;
  return 0;
}

}  // namespace waystone::bench
