// SPDX-License-Identifier: Apache-2.0
#include "localizer/orientation/building.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/calib3d.hpp>
#include <opencv2/core/eigen.hpp>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "core/base/error.h"
#include "core/camera/cube_faces.h"
#include "core/camera/image_plane.h"
#include "core/geometry/decompose_homography.h"
#include "core/geometry/rotation.h"
#include "core/manhattan/cube_rotations.h"
#include "schema/layers/orientation/orientation_trajectory.h"
#include "schema/layers/planes/keyframe_camera.h"

namespace waystone {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

// Eigenvalues of H^T H that differ by less are those of a camera that only turned.
constexpr double kPureRotation = 1e-3;

// Points of the image planes that both cameras see ahead.
struct Rays {
  std::vector<cv::Point2d> query;
  std::vector<cv::Point2d> reference;
};

Rays ComputeRays(const RecognisedPlane& plane, const Camera& camera, const Camera& reference,
                 size_t first, size_t step) {
  Rays rays;
  for (size_t i = first; i < plane.query_points.size(); i += step) {
    const auto q = OnImagePlane(camera, plane.query_points[i]);
    const auto r = OnImagePlane(reference, plane.reference_points[i]);
    if (!q || !r) continue;
    rays.query.emplace_back(q->x(), q->y());
    rays.reference.emplace_back(r->x(), r->y());
  }
  return rays;
}

// The homography's sign is fixed by points ahead of both cameras: r . H q > 0.
Matrix3d TakeAhead(const Matrix3d& reference_from_query, const Rays& rays) {
  double ahead = 0;
  for (size_t i = 0; i < rays.query.size(); ++i) {
    const Vector3d q(rays.query[i].x, rays.query[i].y, 1);
    const Vector3d r(rays.reference[i].x, rays.reference[i].y, 1);
    ahead += r.dot(reference_from_query * q);
  }
  return ahead < 0 ? Matrix3d(-reference_from_query) : reference_from_query;
}

// The two rotations reference_from_query of H = R + t n^T. Either may be right.
std::vector<Matrix3d> DecomposeRotations(const Rays& rays) {
  constexpr size_t kFewest = 8;
  if (rays.query.size() < kFewest) return {};
  const cv::Mat h = cv::findHomography(rays.query, rays.reference, 0);
  if (h.empty()) return {};
  Matrix3d reference_from_query;
  cv::cv2eigen(h, reference_from_query);
  reference_from_query = TakeAhead(reference_from_query, rays);
  std::vector<Matrix3d> rotations;
  for (const PlaneMotion& motion : DecomposeHomography(reference_from_query, kPureRotation)) {
    rotations.push_back(motion.b_from_a);
  }
  return rotations;
}

// The rotation among `all` that is nearest to r, as an angle; pi where there is none.
double NearestAngle(const Matrix3d& r, const std::vector<Matrix3d>& all) {
  double nearest = std::numbers::pi;
  for (const Matrix3d& other : all) nearest = std::min(nearest, RotationAngle(r, other));
  return nearest;
}

void AddThroughPlane(const MapIndex& index, const RecognisedPlane& plane, const Camera& camera,
                     double min_sigma_rad, std::vector<BuildingGuess>& guesses) {
  const Keyframe& keyframe = *index.FindKeyframe(plane.reference.id);
  const Sequence& sequence = *index.FindSequence(keyframe.sequence);
  const OrientationFrame* frame = index.FindFrame(keyframe.sequence, keyframe.frame);
  if (!sequence.camera || !frame || !frame->reliable) return;
  const Camera reference = *CameraOfKeyframe(sequence, keyframe);
  const std::vector<Matrix3d> odd = DecomposeRotations(ComputeRays(plane, camera, reference, 1, 2));
  const std::vector<Matrix3d> even =
      DecomposeRotations(ComputeRays(plane, camera, reference, 0, 2));
  for (const Matrix3d& r : DecomposeRotations(ComputeRays(plane, camera, reference, 0, 1))) {
    // Two halves of the matches differ by twice the sigma of all of them.
    const double halves = 0.5 * (NearestAngle(r, odd) + NearestAngle(r, even));
    guesses.push_back({.building_from_query = frame->rotation->building_from_rig * r,
                       .sigma_rad = std::max(min_sigma_rad, halves),
                       .weight = plane.inliers});
  }
}

void AddThroughNode(const MapIndex& index, const Answer& answer,
                    std::vector<BuildingGuess>& guesses) {
  const std::vector<AppearanceNode>& nodes = index.map().appearance->nodes;
  if (!answer.heading) return;
  const AppearanceNodeId id = answer.panorama->node.id;
  const auto node = std::ranges::lower_bound(nodes, id, {}, &AppearanceNode::id);
  const OrientationFrame* frame = index.FindFrame(node->sequence, node->frame);
  if (!frame || !frame->reliable) return;
  const Matrix3d building_from_node = frame->rotation->building_from_rig.toRotationMatrix();
  std::optional<Matrix3d> query_from_node;
  for (const NodeCandidate& candidate : answer.panorama->candidates) {
    if (candidate.node.id == id) query_from_node = candidate.query_from_node;
  }
  const double turned = answer.panorama->pose.theta_rad - node->pose.theta_rad;
  const Matrix3d upright = Eigen::AngleAxisd(turned, Vector3d::UnitZ()).toRotationMatrix();
  guesses.push_back(
      {.building_from_query = query_from_node
                                  ? Matrix3d(building_from_node * query_from_node->transpose())
                                  : Matrix3d(upright * building_from_node),
       .sigma_rad =
           std::hypot(answer.heading->sigma_rad, std::sqrt(frame->rotation->covariance(2, 2))),
       .weight = 1});
}

// The guess with which most others agree, if it is the only one or its rivals mean the same.
const BuildingGuess* Agreed(const std::vector<BuildingGuess>& guesses, double agree_rad) {
  const auto support = [&](const BuildingGuess& guess) {
    int weight = 0;
    for (const BuildingGuess& other : guesses) {
      const double apart = RotationAngle(guess.building_from_query, other.building_from_query);
      weight += apart <= agree_rad ? other.weight : 0;
    }
    return weight;
  };
  if (guesses.empty()) return nullptr;
  const auto best = std::ranges::max_element(guesses, {}, support);
  const int most = support(*best);
  for (const BuildingGuess& other : guesses) {
    const double apart = RotationAngle(best->building_from_query, other.building_from_query);
    if (apart > agree_rad && support(other) == most) return nullptr;
  }
  return &*best;
}

BuildingView MakeView(const Matrix3d& building_from_query, double sigma_rad) {
  BuildingView view;
  view.building_from_query = Eigen::Quaterniond(building_from_query).normalized();
  const auto heading_rad = HeadingOf({view.building_from_query, Matrix3d::Zero()});
  if (heading_rad) view.heading = Heading{*heading_rad, sigma_rad, HeadingFrame::kBuilding};
  return view;
}

}  // namespace

std::vector<BuildingGuess> GuessRotation(const MapIndex& index, const Answer& answer,
                                         const std::optional<Camera>& camera,
                                         const BuildingOptions& options) {
  std::vector<BuildingGuess> guesses;
  if (answer.panorama) {
    AddThroughNode(index, answer, guesses);
  } else if (camera) {
    for (const RecognisedPlane& plane : answer.planes.recognised) {
      AddThroughPlane(index, plane, *camera, options.min_plane_sigma_rad, guesses);
    }
  }
  return guesses;
}

BuildingView ViewBuilding(const std::vector<BuildingGuess>& guesses, const ManhattanFrame& lines,
                          const BuildingOptions& options) {
  BuildingView view;
  if (guesses.empty()) return view;
  if (lines.reliable() && lines.rival <= options.max_clear_rival) {
    const auto off = [&](const BuildingGuess& guess) {
      return CubeAngle(lines.rig_from_axes, guess.building_from_query.transpose());
    };
    const BuildingGuess& nearest = *std::ranges::min_element(guesses, {}, off);
    const double disagreement_rad = off(nearest);
    if (disagreement_rad <= options.max_disagreement_rad) {
      const ManhattanFrame axes = Renumbered(lines, nearest.building_from_query.transpose());
      const Matrix3d building_from_query = axes.rig_from_axes.transpose();
      const Matrix3d covariance =
          building_from_query * axes.covariance * building_from_query.transpose();
      view = MakeView(building_from_query, std::sqrt(covariance(2, 2)));
      view.lines = axes.lines;
    }
    view.disagreement_rad = disagreement_rad;
    return view;
  }
  if (const BuildingGuess* agreed = Agreed(guesses, 0.5 * options.max_disagreement_rad)) {
    view = MakeView(agreed->building_from_query, agreed->sigma_rad);
  }
  return view;
}

// The photo at the size at which its lines are detected, and its camera.
std::pair<cv::Mat, Camera> Reduced(const cv::Mat& grey, const Camera& camera, int working_pixels) {
  const cv::Size size = WorkingSize(grey.size(), working_pixels);
  if (size == grey.size()) return {grey, camera};
  const Camera scaled = ScaledCamera(camera, size.width);
  cv::Mat reduced;
  cv::resize(grey, reduced, {scaled.width, scaled.height}, 0, 0, cv::INTER_AREA);
  return {reduced, scaled};
}

ManhattanFrame DetectPhotoLines(const cv::Mat& grey, const Camera& camera,
                                const BuildingOptions& options) {
  const auto [image, scaled] = Reduced(grey, camera, options.working_pixels);
  return FindManhattanFrame(
      FindGreatCircles(RigOfOne(scaled), 0, DetectSegments(image, options.segments),
                       options.circles),
      options.manhattan);
}

ManhattanFrame DetectLines(const cv::Mat& grey, const std::optional<Camera>& camera,
                           const BuildingOptions& options) {
  if (camera) return DetectPhotoLines(grey, *camera, options);
  constexpr int kFaceShare = 4;
  const auto largest = static_cast<int>(std::sqrt(options.working_pixels / kCubeFaces));
  const int face_px = std::clamp(grey.cols / kFaceShare, 1, std::max(1, largest));
  const Rig rig = CubeRig(face_px);
  std::vector<GreatCircle> lines;
  for (int c = 0; c < std::ssize(rig.cameras); ++c) {
    const cv::Mat image = FaceOf(grey, static_cast<CubeFace>(c), face_px);
    CheckImageSize(rig.cameras[c], image.cols, image.rows);
    const auto found =
        FindGreatCircles(rig, c, DetectSegments(image, options.segments), options.circles);
    lines.insert(lines.end(), found.begin(), found.end());
  }
  return FindManhattanFrame(lines, options.manhattan);
}

int CountChances(const std::vector<BuildingGuess>& guesses, double apart_rad) {
  std::vector<Matrix3d> counted;  // query_from_building
  for (const BuildingGuess& guess : guesses) {
    const Matrix3d query_from_building = guess.building_from_query.transpose();
    const bool is_new = std::ranges::none_of(counted, [&](const Matrix3d& other) {
      return CubeAngle(other, query_from_building) <= apart_rad;
    });
    if (is_new) counted.push_back(query_from_building);
  }
  return static_cast<int>(counted.size());
}

// Bayes: axes of wrong places disagree by anything up to an eighth of a turn; each chance to agree
// makes a disagreement less likely.
void JudgeByAxes(int chances, double min_probability, const BuildingOptions& options,
                 Answer& answer) {
  const double limit = options.max_disagreement_rad;
  const double disagreement_rad = answer.building->disagreement_rad.value_or(0);
  if (disagreement_rad <= limit) return;
  const double disagree_by_chance = std::pow(1 - limit / (std::numbers::pi / 4), chances);
  const double right = answer.probability * options.true_disagreeing;
  const double wrong = (1 - answer.probability) * disagree_by_chance;
  // A disagreement never supports a place, however rare it is by chance.
  answer.probability = std::min(answer.probability, right / (right + wrong));
  if (answer.probability >= min_probability) return;
  const auto degrees = std::lround(disagreement_rad * 180 / std::numbers::pi);
  answer.verdict = Verdict::kNotInMap;
  answer.decided_by = DecidedBy::kBuildingAxes;
  answer.planes.keyframe.reset();
  answer.heading.reset();
  answer.planes.recognised.clear();
  answer.planes.epipolar.reset();
  answer.message = "the place matches, but the lines of the image are rotated by " +
                   std::to_string(degrees) +
                   " degrees relative to the axes of the map; send another image";
}

void AddBuilding(const MapIndex& index, const cv::Mat& grey, const BuildingQuery& query,
                 const BuildingOptions& options, Answer& answer) {
  if (!index.map().orientation || answer.verdict != Verdict::kLocalized) return;
  // Of several images of a request, only the first must have the camera's size.
  const bool fits =
      query.camera && grey.cols == query.camera->width && grey.rows == query.camera->height;
  const std::optional<Camera> camera = fits ? query.camera : std::nullopt;
  const std::vector<BuildingGuess> guesses = GuessRotation(index, answer, camera, options);
  if (guesses.empty()) return;
  const ManhattanFrame lines =
      query.with_lines ? DetectLines(grey, camera, options) : ManhattanFrame{};
  answer.building = ViewBuilding(guesses, lines, options);
  if (!answer.panorama) answer.heading = answer.building->heading;
  JudgeByAxes(CountChances(guesses, options.max_disagreement_rad), query.min_probability, options,
              answer);
}

}  // namespace waystone
