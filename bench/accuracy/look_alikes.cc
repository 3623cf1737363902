// SPDX-License-Identifier: Apache-2.0
#include <tbb/parallel_for.h>

#include <cmath>
#include <cstdio>
#include <iostream>
#include <limits>
#include <numbers>
#include <optional>

#include "bench/accuracy/common.h"
#include "bench/accuracy/relight.h"
#include "bench/accuracy/settings.h"
#include "bench/accuracy/world_source.h"
#include "core/base/error.h"
#include "core/camera/image_plane.h"
#include "localizer/planes/sightings.h"
#include "localizer/verdict/keyframe_verdict.h"
#include "localizer/verdict/logistic_fit.h"
#include "world/rig.h"

namespace waystone::bench {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

// Median transfer error of the inliers of a place that is right, as a share of the width.
constexpr double kRight = 40.0 / 640;
constexpr int kMapFrames = 48;
constexpr int kQueries = 30;

// What was asked of a map: places of its own storey, the same places a storey higher, where much
// looks alike, or another building.
enum class AskedOf { kOwn, kLookAlike, kForeign };
constexpr const char* kAskedOfNames[] = {"own", "look-alike", "foreign"};

struct LookAlikeSample {
  int building = 0;
  AskedOf asked = AskedOf::kOwn;
  bool right = false;
  bool localized = false;
  int plane_inliers = 0;
  std::optional<KeyframeEvidence> evidence;  // of a verified keyframe
  double probability = 0;                    // by the default model
};

// A building that varies with its seed: how bare its walls are, how rich its looks, how large its
// posters are, how many of them show one picture, and how many hang on every storey.
WorldOptions DrawBuilding(uint64_t seed) {
  Random random(seed * 7919 + 11);
  WorldOptions options;
  options.seed = seed;
  options.texel_m = 0.006;
  options.trim = random.Uniform() < 0.7;
  options.texture_richness = random.Uniform(0.03, 0.5);
  options.bare_walls = random.Uniform(0.0, 0.8);
  options.poster_probability = random.Uniform(0.3, 0.9);
  options.repeat_poster = random.Uniform(0, 0.2);
  options.poster_width_m = random.Uniform(0.25, 0.8);
  options.poster_height_m = random.Uniform(0.3, 1.2);
  options.alike_share = random.Uniform(0.3, 0.9);
  return options;
}

Walk MapTour(const World& world) {
  WalkOptions options;
  options.gaze_rad = 0.4;
  return SpreadOver(DemoWalk(world.plan(), options), kMapFrames);
}

// A step aside and a look elsewhere, where there is room for it.
Eigen::Isometry3d StepAside(const World& world, const Eigen::Isometry3d& world_from_camera,
                            Random& random) {
  Eigen::Isometry3d aside = world_from_camera;
  aside.linear() = Eigen::AngleAxisd(random.Uniform(-0.6, 0.6), Vector3d::UnitZ()) * aside.linear();
  aside.translation() += Vector3d(random.Uniform(-0.8, 0.8), random.Uniform(-0.8, 0.8), 0);
  return world.IsInside(aside.translation()) ? aside : world_from_camera;
}

// Another visit: another height, gaze and hand.
Walk QueryTour(const World& world, uint64_t seed) {
  Random random(seed * 31 + 7);
  WalkOptions options;
  options.height_m = random.Uniform(1.35, 1.65);
  options.gaze_rad = random.Uniform(0.2, 0.8);
  options.gaze_period_m = random.Uniform(4, 9);
  options.seed = seed + 100;
  Walk tour = SpreadOver(DemoWalk(world.plan(), options), kQueries);
  for (WalkFrame& frame : tour.frames) {
    frame.world_from_camera = StepAside(world, frame.world_from_camera, random);
  }
  return tour;
}

// Whether the inliers show one and the same surface of the world: median distance between where the
// map has them and where they are.
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
  BuildingAsked(int building, BuildOptions options, int width)
      : building_(building),
        features_(options.features),
        renderer_(PinholeCamera(width, 3 * width / 4, 1.1)),
        working_camera_(
            ScaledCamera(renderer_.camera(),
                         WorkingSize({width, 3 * width / 4}, features_.working_pixels).width)) {
    std::vector<std::unique_ptr<Source>> sources;
    sources.push_back(std::make_unique<WorldSource>(world_, renderer_, map_walk_));
    options.images = false;
    options.planes.landmarks.max_kept = 30 + 10 * (building_ % 8);
    index_ = MapIndex::Build(BuildMap(sources, options, {}).map);
  }

  std::vector<LookAlikeSample> Ask() const {
    WorldOptions above = options_;
    above.storey = 1;
    WorldOptions elsewhere = DrawBuilding(building_ + 5000);
    std::vector<LookAlikeSample> samples;
    AskWorld(world_, AskedOf::kOwn, samples);
    AskWorld(World(plan_, above), AskedOf::kLookAlike, samples);
    AskWorld(World(building_ % 2 == 0 ? OtherPlan() : DemoPlan(), elsewhere), AskedOf::kForeign,
             samples);
    return samples;
  }

 private:
  // Another camera's blur, noise and exposure, and for every other query another light, as the
  // query's seed has them.
  cv::Mat Photograph(const World& world, const Eigen::Isometry3d& world_from_camera,
                     uint64_t seed) const {
    Random random(seed);
    RenderOptions options;
    options.lens_blur_px = random.Uniform(0.5, 1.6);
    options.noise_sigma = random.Uniform(2, 8);
    options.noise_seed = seed;
    options.exposure_gain = random.Uniform(0.4, 1.2);
    const RenderedFrame frame = renderer_.Render(world, world_from_camera, options);
    return random.Uniform() < 0.5 ? frame.grey : Relight(frame, random);
  }

  void AskWorld(const World& world, AskedOf asked, std::vector<LookAlikeSample>& samples) const {
    const Walk walk = QueryTour(world, building_);
    std::vector<LookAlikeSample> of_world(walk.frames.size());
    tbb::parallel_for(size_t{0}, of_world.size(), [&](size_t i) {
      const Features query = ExtractFeatures(
          Photograph(world, walk.frames[i].world_from_camera, 1000 * building_ + i), features_);
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
    const Shortlist shortlist = VoteForPlaces(*index_, query, options);
    const std::vector<VerifiedPlane> tried = TryPlanes(*index_, query, shortlist.planes, options);
    std::vector<Place> places = FindPlaces(*index_, tried, options);
    JoinKeyframes(*index_, query, VerifyKeyframes(*index_, query, shortlist, places, options),
                  options, places);
    if (places.empty()) return sample;
    const Place& best = places.front();
    sample.localized = true;
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
  FloorPlan plan_ = building_ % 2 == 0 ? DemoPlan() : OtherPlan();
  WorldOptions options_ = DrawBuilding(building_);
  World world_{plan_, options_};
  Renderer renderer_;
  Camera working_camera_;  // in pixels of the working image
  Walk map_walk_ = MapTour(world_);
  std::shared_ptr<const MapIndex> index_;
};

// The logistic regression over all samples with a verified keyframe; no
// factor's weight is negative. Right and wrong samples weigh the same in sum.
Eigen::VectorXd FitSigned(const std::vector<LookAlikeSample>& samples) {
  std::vector<LogisticSample> cases;
  double right = 0;
  for (const LookAlikeSample& sample : samples) {
    if (!sample.evidence) continue;
    cases.push_back({KeyframeFactors(*sample.evidence), sample.right});
    right += sample.right;
  }
  const double wrong = static_cast<double>(cases.size()) - right;
  for (LogisticSample& one : cases) one.weight = 0.5 / (one.right ? right : wrong) * cases.size();
  const Eigen::Index n = KeyframeFactors({}).size();
  constexpr double kAny = std::numeric_limits<double>::infinity();
  LogisticPrior prior{Eigen::VectorXd::Zero(n), Eigen::VectorXd::Constant(n, 10),
                      Eigen::VectorXd::Zero(n), Eigen::VectorXd::Constant(n, kAny)};
  prior.sigma(0) = 30;
  prior.lower(0) = -kAny;
  return FitLogistic(cases, prior);
}

// Prints and returns what a model of the probability localizes.
nlohmann::ordered_json Count(const std::vector<LookAlikeSample>& samples, const char* model,
                             auto&& probability) {
  nlohmann::ordered_json json;
  for (const AskedOf asked : {AskedOf::kOwn, AskedOf::kLookAlike, AskedOf::kForeign}) {
    int all = 0;
    int localized = 0;
    int right = 0;
    for (const LookAlikeSample& sample : samples) {
      if (sample.asked != asked) continue;
      ++all;
      const bool sure = sample.localized && probability(sample) >= GateOptions{}.min_probability;
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
  const BuildOptions build = TakeBuildSettings(args);
  const int width = std::stoi(TakeOption(args, "width", "640"));
  const bool each = TakeOption(args, "each", "no") == "yes";
  if (!args.empty()) {
    throw MapError(ErrorCode::kUsage,
                   "look-alikes takes --buildings N, --first SEED, --width N, --each yes|no and "
                   "--set NAME=VALUE");
  }
  std::vector<LookAlikeSample> samples;
  for (int building = first; building < first + buildings; ++building) {
    const std::vector<LookAlikeSample> more = BuildingAsked(building, build, width).Ask();
    samples.insert(samples.end(), more.begin(), more.end());
    for (const LookAlikeSample& sample : more) {
      if (!each) break;
      const KeyframeEvidence e = sample.evidence.value_or(KeyframeEvidence{});
      std::printf("sample %d %s %d %d %d %.1f %.4f %.4f %.4f %.4f\n", sample.building,
                  kAskedOfNames[static_cast<int>(sample.asked)], sample.localized, sample.right,
                  sample.plane_inliers, e.significance, e.found_share, e.coverage, e.inlier_share,
                  sample.probability);
    }
    std::fflush(stdout);
  }
  nlohmann::ordered_json json{
      {"bench", "look-alikes"}, {"buildings", buildings}, {"samples", samples.size()}};
  json["default"] =
      Count(samples, "default", [](const LookAlikeSample& s) { return s.probability; });
  const Eigen::VectorXd fit = FitSigned(samples);
  json["fitted"] = Count(samples, "fitted", [&](const LookAlikeSample& s) {
    return s.evidence ? Logistic(fit.dot(KeyframeFactors(*s.evidence))) : s.probability;
  });
  json["fit"] = std::vector<double>(fit.begin(), fit.end());
  std::cout << json.dump() << std::endl;
  return 0;
}

}  // namespace waystone::bench
