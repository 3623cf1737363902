// SPDX-License-Identifier: Apache-2.0
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <iostream>
#include <limits>
#include <numbers>
#include <optional>

#include "bench/accuracy/common.h"
#include "bench/accuracy/look_alike_buildings.h"
#include "bench/accuracy/settings.h"
#include "bench/accuracy/world_source.h"
#include "core/base/error.h"
#include "core/camera/image_plane.h"
#include "localizer/planes/locate.h"
#include "localizer/planes/sightings.h"
#include "localizer/verdict/keyframe_verdict.h"
#include "localizer/verdict/logistic_fit.h"

namespace waystone::bench {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

// Bound on a right place's median transfer error of the inliers, as a share of the width.
constexpr double kRight = 40.0 / 640;

// What a map was queried with: places of its own storey, the same places a storey higher, where
// much looks alike, or another building.
enum class AskedOf { kOwn, kLookAlike, kForeign };
constexpr const char* kAskedOfNames[] = {"own", "look-alike", "foreign"};

struct LookAlikeSample {
  int building = 0;
  AskedOf asked = AskedOf::kOwn;
  bool right = false;      // the best place
  bool localized = false;  // the product's verdict
  int plane_inliers = 0;
  std::optional<KeyframeEvidence> evidence;  // of a verified keyframe
  double probability = 0;                    // of the best place, by the default model
};

// Whether the inliers show one and the same surface of the world: by the median distance between
// where the map has them and where they are.
bool ShowsTheSame(const World& world, const Camera& camera, const Eigen::Isometry3d& query,
                  const Eigen::Isometry3d& keyframe, const VerifiedKeyframe& verified) {
  std::vector<double> errors;
  for (size_t i = 0; i < verified.query_points.size(); ++i) {
    const auto ray = Unproject(camera, verified.query_points[i]);
    const Vector3d direction = query.linear() * ray;
    const Vector3d x =
        query.translation() + world.Cast(query.translation(), direction).t * direction;
    const auto there = Project(camera, keyframe.inverse() * x);
    errors.push_back(there ? (*there - verified.keyframe_points[i]).norm() : 1e9);
  }
  return Quantile(errors, 0.5) <= kRight * camera.width;
}

class BuildingAsked {
 public:
  // The map has every so many images of the tour.
  BuildingAsked(int building, BuildOptions options, int width, int every)
      : building_(building), renderer_(LookAlikeCamera(width)) {
    map_walk_ = EveryNth(MapTour(world_), every);
    std::vector<std::unique_ptr<Source>> sources;
    sources.push_back(std::make_unique<WorldSource>(world_, renderer_, map_walk_));
    options.images = false;
    index_ = MapIndex::Build(BuildMap(sources, options, {}).map);
    features_ = QueryFeatureOptions(*index_, {});
    working_camera_ = ScaledCamera(
        renderer_.camera(), WorkingSize({width, 3 * width / 4}, features_.working_pixels).width);
  }

  std::vector<LookAlikeSample> Ask() const {
    std::vector<LookAlikeSample> samples;
    AskWorld(world_, AskedOf::kOwn, samples);
    AskWorld(StoreyOf(building_, 1), AskedOf::kLookAlike, samples);
    AskWorld(World(PlanOf(building_ + 1), DrawBuilding(building_ + 5000)), AskedOf::kForeign,
             samples);
    return samples;
  }

 private:
  void AskWorld(const World& world, AskedOf asked, std::vector<LookAlikeSample>& samples) const {
    const Walk walk = QueryTour(world, building_);
    std::vector<LookAlikeSample> of_world(walk.frames.size());
    tbb::parallel_for(size_t{0}, of_world.size(), [&](size_t i) {
      const Features query = ExtractFeatures(
          Photograph(renderer_, world, walk.frames[i].world_from_camera, 1000 * building_ + i),
          features_);
      of_world[i] = AskFrame(query, asked, walk.frames[i].world_from_camera);
    });
    samples.insert(samples.end(), of_world.begin(), of_world.end());
  }

  LookAlikeSample AskFrame(const Features& query, AskedOf asked,
                           const Eigen::Isometry3d& world_from_query) const {
    LookAlikeSample sample;
    sample.building = building_;
    sample.asked = asked;
    const PlaneQueryOptions options;
    sample.localized =
        LocateByPlanes(*index_, query, options, {}, false).verdict == Verdict::kLocalized;
    // No answer contains what the verdict's model judges.
    const Shortlist shortlist = VoteForPlaces(*index_, query, options);
    const std::vector<VerifiedPlane> tried = TryPlanes(*index_, query, shortlist.planes, options);
    std::vector<Place> places = FindPlaces(*index_, tried, options);
    JoinKeyframes(*index_, query, VerifyKeyframes(*index_, query, shortlist, places, options),
                  options, places);
    if (places.empty()) return sample;
    const Place& best = places.front();
    sample.plane_inliers = best.evidence.inliers;
    sample.probability = best.probability;
    if (!best.keyframe) return sample;
    sample.evidence = best.keyframe_evidence;
    const int frame = static_cast<int>(index_->map().keyframes[best.keyframe->keyframe].frame);
    sample.right = asked == AskedOf::kOwn &&
                   ShowsTheSame(world_, working_camera_, world_from_query,
                                map_walk_.frames[frame].world_from_camera, *best.keyframe);
    return sample;
  }

  int building_;
  FeatureOptions features_;
  World world_ = StoreyOf(building_, 0);
  Renderer renderer_;
  Camera working_camera_;  // in pixels of the working image
  Walk map_walk_;
  std::shared_ptr<const MapIndex> index_;
};

// The logistic regression over all samples with a verified keyframe; no factor's weight is
// negative. Right and wrong samples have the same total weight. Chance finds are among the wrong
// ones, although the product's other factor judges those, too.
KeyframeVerdictModel FitSigned(const std::vector<LookAlikeSample>& samples) {
  std::vector<LogisticSample> cases;
  double right = 0;
  for (const LookAlikeSample& sample : samples) {
    if (!sample.evidence) continue;
    cases.push_back({KeyframeFactorsOf(*sample.evidence), sample.right});
    right += sample.right;
  }
  const double wrong = static_cast<double>(cases.size()) - right;
  for (LogisticSample& one : cases) one.weight = 0.5 / (one.right ? right : wrong) * cases.size();
  constexpr Eigen::Index n = KeyframeFactors::SizeAtCompileTime;
  constexpr double kAny = std::numeric_limits<double>::infinity();
  LogisticPrior prior{Eigen::VectorXd::Zero(n), Eigen::VectorXd::Constant(n, 10),
                      Eigen::VectorXd::Zero(n), Eigen::VectorXd::Constant(n, kAny)};
  prior.sigma(0) = 30;
  prior.lower(0) = -kAny;
  return FitLogistic(cases, prior);
}

// Prints and returns what is localized.
nlohmann::ordered_json Count(const std::vector<LookAlikeSample>& samples, const char* model,
                             auto&& is_localized) {
  nlohmann::ordered_json json;
  for (const AskedOf asked : {AskedOf::kOwn, AskedOf::kLookAlike, AskedOf::kForeign}) {
    int all = 0;
    int localized = 0;
    int right = 0;
    for (const LookAlikeSample& sample : samples) {
      if (sample.asked != asked) continue;
      ++all;
      const bool sure = is_localized(sample);
      localized += sure;
      right += sure && sample.right;
    }
    const char* name = kAskedOfNames[static_cast<int>(asked)];
    std::printf("%s: %-10s %5d asked, %5d localized, %5d right\n", model, name, all, localized,
                right);
    json[name] = {{"asked", all}, {"localized", localized}, {"right", right}};
  }
  return json;
}

}  // namespace

int RunLookAlikes(const Args& raw) {
  Args args = raw;
  const int buildings = std::stoi(TakeOption(args, "buildings", "16"));
  const int first = std::stoi(TakeOption(args, "first", "1"));
  const bool budgets = TakeOption(args, "budgets", "no") == "yes";
  BuildOptions build = TakeBuildSettings(args);
  const int width = std::stoi(TakeOption(args, "width", "640"));
  const int every = std::max(1, std::stoi(TakeOption(args, "every", "1")));
  const bool each = TakeOption(args, "each", "no") == "yes";
  if (!args.empty()) {
    throw MapError(ErrorCode::kUsage,
                   "look-alikes takes --buildings N, --first SEED, --width N, --every N, --budgets "
                   "yes|no, --each yes|no and --set NAME=VALUE");
  }
  std::vector<LookAlikeSample> samples;
  for (int building = first; building < first + buildings; ++building) {
    if (budgets) build.planes.landmarks.max_kept = 30 + 10 * (building % 8);
    const std::vector<LookAlikeSample> more = BuildingAsked(building, build, width, every).Ask();
    samples.insert(samples.end(), more.begin(), more.end());
    for (const LookAlikeSample& sample : more) {
      if (!each) break;
      const KeyframeEvidence e = sample.evidence.value_or(KeyframeEvidence{});
      std::printf("sample %d %s %d %d %d %.1f %.1f %.4f %.4f %.4f %.4f\n", sample.building,
                  kAskedOfNames[static_cast<int>(sample.asked)], sample.localized, sample.right,
                  sample.plane_inliers, e.significance, e.independent_significance, e.found_share,
                  e.coverage, e.inlier_share, sample.probability);
    }
    std::fflush(stdout);
  }
  nlohmann::ordered_json json{
      {"bench", "look-alikes"}, {"buildings", buildings}, {"samples", samples.size()}};
  json["default"] = Count(samples, "default", [](const LookAlikeSample& s) { return s.localized; });
  const KeyframeVerdictModel fitted = FitSigned(samples);
  // By probability alone, without looking for rivals.
  json["fitted"] = Count(samples, "fitted", [&](const LookAlikeSample& s) {
    const double probability = s.evidence ? ComputeProbability(*s.evidence, fitted) : s.probability;
    return probability >= GateOptions{}.min_probability;
  });
  json["fit"] = std::vector<double>(fitted.begin(), fitted.end());
  std::cout << json.dump() << std::endl;
  return 0;
}

}  // namespace waystone::bench
