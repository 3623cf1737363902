// SPDX-License-Identifier: Apache-2.0
#include <tbb/parallel_for.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <iostream>
#include <map>
#include <numeric>
#include <vector>

#include "bench/accuracy/common.h"
#include "bench/accuracy/misclassification.h"
#include "bench/accuracy/plane_labels.h"
#include "bench/accuracy/settings.h"
#include "bench/accuracy/world_source.h"
#include "bench/accuracy/world_truth.h"
#include "core/base/error.h"
#include "core/base/random.h"
#include "core/features/match.h"
#include "core/homography/homography.h"
#include "world/rig.h"
#include "world/truth.h"

namespace waystone::bench {
namespace {

constexpr int kWidth_px = 640;
constexpr int kHeight_px = 480;
constexpr int kPairsOfAWorld = 4;
constexpr double kBadError = 0.1;

struct LabelledPair {
  MatchedPoints points;
  std::vector<int> truth;  // plane of each match, 0 for none
};

Camera PairCamera() { return PinholeCamera(kWidth_px, kHeight_px, 1.1); }

// Numbers the planes from 1; those with fewer matches than the builder requires become 0.
void NumberPlanes(std::vector<int>& truth, int min_matches) {
  std::map<int, int> counts;
  for (int label : truth) ++counts[label];
  std::map<int, int> numbers = {{0, 0}};
  for (const auto& [label, count] : counts) {
    if (label == 0) continue;
    const bool counted = count >= min_matches;
    numbers[label] = 0;
    if (counted) {
      numbers[label] = 1 + static_cast<int>(std::ranges::count_if(
                               numbers, [](const auto& other) { return other.second > 0; }));
    }
  }
  for (int& label : truth) label = numbers[label];
}

// Two frames of a walk through a rendered building, matched as the builder does, in pixels of their
// working images. The truth is the plane that is drawn at the feature and whose true homography
// confirms the match.
LabelledPair RenderPair(const World& world, const WorldSource& source, const Walk& walk, int first,
                        int second, const BuildOptions& options) {
  const RenderedFrame a = source.Render(first);
  const RenderedFrame b = source.Render(second);
  const Features of_a = ExtractFeatures(a.grey, options.features);
  const Features of_b = ExtractFeatures(b.grey, options.features);
  const Eigen::Isometry3d& pose_a = walk.frames[first].world_from_camera;
  const Eigen::Isometry3d& pose_b = walk.frames[second].world_from_camera;
  LabelledPair pair;
  for (const Match& match :
       MatchDescriptors(of_a.descriptors, of_b.descriptors, of_a.type, options.planes.match)) {
    const Eigen::Vector2d from = PositionOf(of_a.keypoints[match.a]);
    const Eigen::Vector2d to = PositionOf(of_b.keypoints[match.b]);
    const Eigen::Vector2d x_a = Apply(ImageFromWorking(of_a), from);
    const Eigen::Vector2d x_b = Apply(ImageFromWorking(of_b), to);
    int label = 0;
    double least = kTrueMatch_px;
    for (int id : PlanesNear(a.plane_ids, x_a)) {
      if (id == 0) continue;
      const Eigen::Matrix3d b_from_a =
          PlaneHomography(world.PlaneById(id), *source.camera(), pose_a, pose_b);
      const Eigen::Vector3d there = b_from_a * x_a.homogeneous();
      if (there.z() <= 0) continue;
      const double error = (there.hnormalized() - x_b).norm();
      if (error < least) {
        least = error;
        label = id;
      }
    }
    pair.points.from.push_back(from);
    pair.points.to.push_back(to);
    pair.truth.push_back(label);
  }
  NumberPlanes(pair.truth, options.planes.segmentation.min_inliers);
  return pair;
}

std::vector<LabelledPair> RenderPairs(uint64_t seed, const BuildOptions& options) {
  const World world(seed % 2 == 0 ? DemoPlan() : OtherPlan(),
                    {.seed = seed, .bare_walls = 0.2, .trim = seed % 4 < 2});
  const Walk walk = DemoWalk(world.plan(), {.step_m = 0.1, .seed = seed});
  const Renderer renderer(PairCamera());
  const WorldSource source(world, renderer, walk);
  Random random(seed);
  std::vector<LabelledPair> pairs;
  while (pairs.size() < kPairsOfAWorld) {
    const int gap = 4 + random.Below(8);
    const int first = random.Below(source.size() - gap);
    pairs.push_back(RenderPair(world, source, walk, first, first + gap, options));
  }
  return pairs;
}

// A camera that has moved, and a plane it looks at.
struct MadeMotion {
  Eigen::Matrix3d k = CalibrationMatrix(PairCamera());
  Eigen::Matrix3d b_from_a;  // rotation
  Eigen::Vector3d t;         // metres, in b

  explicit MadeMotion(Random& random) {
    b_from_a =
        Eigen::AngleAxisd(random.Uniform(-0.2, 0.2), Eigen::Vector3d::UnitY()) *
        Eigen::AngleAxisd(random.Uniform(-0.05, 0.05), Eigen::Vector3d::UnitX()).toRotationMatrix();
    const double angle = random.Uniform(0, 2 * std::numbers::pi);
    t = random.Uniform(0.3, 1.0) * Eigen::Vector3d(std::cos(angle), 0.2, std::sin(angle)) * 0.8;
  }

  // Of the plane through a point `depth` metres in front of camera a (Hartley and Zisserman, 13.2).
  Eigen::Matrix3d Homography(const Eigen::Vector3d& normal, double depth) const {
    return HomographyAt(normal, normal.z() * depth);
  }

  // Of the plane normal^T x = distance.
  Eigen::Matrix3d HomographyAt(const Eigen::Vector3d& normal, double distance) const {
    return k * (b_from_a + t * normal.transpose() / distance) * k.inverse();
  }
};

Eigen::Vector3d FacingNormal(Random& random) {
  return Eigen::Vector3d(random.Uniform(-0.7, 0.7), random.Uniform(-0.4, 0.4), 1).normalized();
}

Eigen::Vector2d AnyPixel(Random& random) {
  return {random.Uniform(0, kWidth_px), random.Uniform(0, kHeight_px)};
}

void AddMatch(LabelledPair& pair, const Eigen::Vector2d& from, const Eigen::Vector2d& to,
              int label) {
  pair.points.from.push_back(from);
  pair.points.to.push_back(to);
  pair.truth.push_back(label);
}

// `count` matches of a plane inside a rectangle of image a, with 0.5 px of noise.
void AddPlane(LabelledPair& pair, const Eigen::Matrix3d& b_from_a, const Eigen::Vector2d& corner,
              const Eigen::Vector2d& size, int count, int label, Random& random) {
  for (int i = 0; i < count; ++i) {
    const Eigen::Vector2d from =
        corner + Eigen::Vector2d(random.Uniform() * size.x(), random.Uniform() * size.y());
    const Eigen::Vector2d to = (b_from_a * from.homogeneous()).hnormalized() +
                               0.5 * Eigen::Vector2d(random.Normal(), random.Normal());
    AddMatch(pair, from, to, label);
  }
}

void AddOutliers(LabelledPair& pair, int count, Random& random) {
  for (int i = 0; i < count; ++i) {
    const Eigen::Vector2d from = AnyPixel(random);
    AddMatch(pair, from, AnyPixel(random), 0);
  }
}

LabelledPair OnePlaneAndAsManyOutliers(uint64_t seed) {
  Random random(seed);
  const MadeMotion motion(random);
  const int count = 40 + random.Below(160);
  LabelledPair pair;
  AddPlane(pair, motion.Homography(FacingNormal(random), random.Uniform(2, 5)), {0, 0},
           {kWidth_px, kHeight_px}, count, 1, random);
  AddOutliers(pair, count, random);
  return pair;
}

// One to three small planes of 20 to 40 matches, which hide what is behind them, and a fifth of
// outliers.
LabelledPair SmallPlanesInFrontOfALargeOne(uint64_t seed) {
  Random random(seed);
  const MadeMotion motion(random);
  const double depth = random.Uniform(3, 6);
  LabelledPair behind;
  AddPlane(behind, motion.Homography(FacingNormal(random), depth), {0, 0}, {kWidth_px, kHeight_px},
           150 + random.Below(150), 1, random);
  const int small = 1 + random.Below(3);
  const Eigen::Vector2d size(140, 140);
  std::vector<Eigen::Vector2d> corners;
  LabelledPair pair;
  for (int p = 0; p < small; ++p) {  // each in its own third of the image
    corners.emplace_back(p * kWidth_px / 3.0 + random.Uniform(10, 60), random.Uniform(20, 300));
    AddPlane(pair, motion.Homography(FacingNormal(random), depth * random.Uniform(0.4, 0.8)),
             corners.back(), size, 20 + random.Below(21), 2 + p, random);
  }
  for (int i = 0; i < behind.points.size(); ++i) {
    const Eigen::Vector2d& x = behind.points.from[i];
    const bool hidden = std::ranges::any_of(corners, [&](const Eigen::Vector2d& corner) {
      return ((x - corner).array() > 0).all() && ((x - corner).array() < size.array()).all();
    });
    if (!hidden) AddMatch(pair, x, behind.points.to[i], 1);
  }
  AddOutliers(pair, pair.points.size() / 4, random);
  return pair;
}

// Noise of a match with a long tail, as lenses and detectors give it: Student's distribution with
// four degrees of freedom.
Eigen::Vector2d LongTailedNoise(double scale_px, Random& random) {
  double chi2 = 0;
  for (int i = 0; i < 4; ++i) {
    const double n = random.Normal();
    chi2 += n * n;
  }
  const double x = random.Normal();
  const double y = random.Normal();
  return scale_px / std::sqrt(chi2 / 4) * Eigen::Vector2d(x, y);
}

// Two to five walls side by side that meet at vertical edges, half of the time above a floor: a
// building as photos show it. The lens distorts, noise and density of matches differ, and 10 to
// 60 % of all matches are wrong.
class WallsSideBySide {
 public:
  explicit WallsSideBySide(uint64_t seed)
      : random_(seed),
        motion_(random_),
        distortion_(random_.Uniform(-0.03, 0.015)),
        noise_px_(random_.Uniform(0.3, 1.2)) {
    motion_.t *= random_.Uniform(1, 3);
  }

  LabelledPair Make() {
    const int walls = 2 + random_.Below(4);
    const double bottom_px =
        random_.Uniform() < 0.5 ? kHeight_px : random_.Uniform(0.7, 0.9) * kHeight_px;
    Eigen::Vector3d left = Edge(0);
    double left_px = 0;
    for (int wall = 1; wall <= walls; ++wall) {
      const double right_px =
          wall == walls ? kWidth_px : (wall + random_.Uniform(-0.25, 0.25)) * kWidth_px / walls;
      const Eigen::Vector3d right = Edge(right_px);
      const Eigen::Vector3d normal = (right - left).cross(Eigen::Vector3d::UnitY()).normalized();
      AddMatches(motion_.HomographyAt(normal, normal.dot(left)), {left_px, 0},
                 {right_px - left_px, bottom_px}, 16 + random_.Below(100), wall);
      left = right;
      left_px = right_px;
    }
    if (bottom_px < kHeight_px) {
      constexpr double kEyeHeight = 1.5;  // metres
      AddMatches(motion_.HomographyAt(Eigen::Vector3d::UnitY(), kEyeHeight), {0, bottom_px},
                 {kWidth_px, kHeight_px - bottom_px}, 20 + random_.Below(60), walls + 1);
    }
    const double wrong = random_.Uniform(0.1, 0.6);
    AddOutliers(pair_, static_cast<int>(wrong / (1 - wrong) * pair_.points.size()), random_);
    return std::move(pair_);
  }

 private:
  // Where a vertical edge that is seen in this column crosses the horizon.
  Eigen::Vector3d Edge(double column_px) {
    return random_.Uniform(3, 9) *
           (motion_.k.inverse() * Eigen::Vector3d(column_px, 0.5 * kHeight_px, 1));
  }

  void AddMatches(const Eigen::Matrix3d& b_from_a, const Eigen::Vector2d& corner,
                  const Eigen::Vector2d& size, int count, int label) {
    for (int i = 0; i < count; ++i) {
      const double x = random_.Uniform() * size.x();
      const double y = random_.Uniform() * size.y();
      const Eigen::Vector2d from = corner + Eigen::Vector2d(x, y);
      const Eigen::Vector3d to = b_from_a * from.homogeneous();
      if (to.z() <= 0) continue;  // behind the camera
      AddMatch(pair_, Distorted(from),
               Distorted(to.hnormalized()) + LongTailedNoise(noise_px_, random_), label);
    }
  }

  Eigen::Vector2d Distorted(const Eigen::Vector2d& x) const {
    const Eigen::Vector2d centre(0.5 * kWidth_px, 0.5 * kHeight_px);
    const Eigen::Vector2d from_centre = x - centre;
    const double r2 = (from_centre / (0.5 * kWidth_px)).squaredNorm();
    return centre + (1 + distortion_ * r2) * from_centre;
  }

  Random random_;
  MadeMotion motion_;
  double distortion_;
  double noise_px_;
  LabelledPair pair_;
};

nlohmann::ordered_json Report(const char* name, const std::vector<LabelledPair>& pairs,
                              const PlaneLayerOptions& options) {
  std::vector<double> errors(pairs.size());
  std::vector<int> found(pairs.size());
  std::vector<int> planes(pairs.size());
  tbb::parallel_for(size_t{0}, pairs.size(), [&](size_t i) {
    const std::vector<int> labels = LabelPlanes(pairs[i].points, options);
    errors[i] = Misclassification(pairs[i].truth, labels);
    if (labels.empty()) return;
    found[i] = std::ranges::max(labels);
    planes[i] = std::ranges::max(pairs[i].truth);
  });
  const double mean = std::accumulate(errors.begin(), errors.end(), 0.0) / errors.size();
  const auto bad = std::ranges::count_if(errors, [](double error) { return error > kBadError; });
  nlohmann::ordered_json json = {{"name", name},
                                 {"pairs", pairs.size()},
                                 {"planes", std::accumulate(planes.begin(), planes.end(), 0)},
                                 {"found", std::accumulate(found.begin(), found.end(), 0)},
                                 {"error_mean", mean},
                                 {"error_median", Quantile(errors, 0.5)},
                                 {"error_95", Quantile(errors, 0.95)},
                                 {"error_max", std::ranges::max(errors)},
                                 {"bad_share", static_cast<double>(bad) / errors.size()}};
  std::printf("%-34s %4zu pairs: mean error %.1f%%, median %.1f%%, 95%% %.1f%%, worst %.1f%%\n",
              name, pairs.size(), 100 * mean, 100 * Quantile(errors, 0.5),
              100 * Quantile(errors, 0.95), 100 * std::ranges::max(errors));
  return json;
}

}  // namespace

int RunRenderedPairs(const Args& raw) {
  Args args = raw;
  const BuildOptions options = TakeBuildSettings(args);
  const int count = std::stoi(TakeOption(args, "pairs", "200"));
  const int first = std::stoi(TakeOption(args, "first", "1"));
  if (!args.empty() || count < kPairsOfAWorld) {
    throw MapError(ErrorCode::kUsage, "rendered-pairs wants --pairs of at least 4, and no folders");
  }
  std::vector<std::vector<LabelledPair>> of_worlds(count / kPairsOfAWorld);
  tbb::parallel_for(size_t{0}, of_worlds.size(),
                    [&](size_t w) { of_worlds[w] = RenderPairs(first + w, options); });
  std::vector<LabelledPair> rendered;
  for (const auto& of_world : of_worlds) {
    rendered.insert(rendered.end(), of_world.begin(), of_world.end());
  }
  std::vector<LabelledPair> alone;
  std::vector<LabelledPair> in_front;
  std::vector<LabelledPair> walls;
  for (int i = 0; i < count; ++i) {
    alone.push_back(OnePlaneAndAsManyOutliers(first + i));
    in_front.push_back(SmallPlanesInFrontOfALargeOne(first + i));
    walls.push_back(WallsSideBySide(first + i).Make());
    NumberPlanes(walls.back().truth, options.planes.segmentation.min_inliers);
  }
  const nlohmann::ordered_json json = {
      {"bench", "rendered-pairs"},
      {"first", first},
      {"kinds",
       {Report("rendered", rendered, options.planes),
        Report("one plane and as many outliers", alone, options.planes),
        Report("small planes in front", in_front, options.planes),
        Report("walls side by side", walls, options.planes)}}};
  std::cout << json.dump() << std::endl;
  return 0;
}

}  // namespace waystone::bench
