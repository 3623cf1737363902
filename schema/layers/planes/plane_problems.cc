// SPDX-License-Identifier: Apache-2.0
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <complex>
#include <string>
#include <unordered_map>
#include <unordered_set>

#include "core/features/descriptor_codes.h"
#include "core/geometry/linear_algebra.h"
#include "schema/layers/layer_blobs.h"
#include "schema/layers/layer_problems.h"
#include "schema/layers/planes/index_features.h"

namespace waystone {
namespace {

using Eigen::Matrix3d;

// How many features with the largest descriptors fit one row of SQLite (10^9 bytes).
constexpr size_t kMaxFeatures = 6'000'000;
// Condition number of a homography with pixels scaled by the image's size. Beyond it the inverse
// keeps too few digits to map pixels back.
constexpr double kMaxCondition = 1e8;
// Error, relative to 1 or to the value, of a homology's double eigenvalue from 1 and of its third
// one from what is stored. Measured homologies are noisy: their double eigenvalue splits into a
// pair, whose squared distance is allowed in addition.
constexpr double kEigenvalueTolerance = 1e-3;

template <class IdType>
std::string Text(IdType id) {
  return std::to_string(id.value);
}

bool IsFinite(const Keypoint& keypoint) {
  return std::isfinite(keypoint.x_px) && std::isfinite(keypoint.y_px) &&
         std::isfinite(keypoint.scale_px) && std::isfinite(keypoint.angle_rad);
}

// Condition number (in the Frobenius norm) after scaling pixels of both images to about one.
// Infinite or NaN for a singular matrix.
double ComputeCondition(const Matrix3d& to_from, double to_px, double from_px) {
  const Matrix3d scaled = Eigen::Vector3d(1 / to_px, 1 / to_px, 1).asDiagonal() * to_from *
                          Eigen::Vector3d(from_px, from_px, 1).asDiagonal();
  return scaled.norm() * scaled.inverse().norm();
}

// Whether `h` has the eigenvalues (1, 1, third), whichever of the three the third one is.
bool HasEigenvalues(const Matrix3d& h, double third, double tolerance) {
  const Eigen::Vector3cd values = ComputeEigenvalues3x3(h);
  const double imaginary = values.imag().cwiseAbs().maxCoeff();
  for (int i = 0; i < 3; ++i) {
    const std::complex<double> p = values((i + 1) % 3);
    const std::complex<double> q = values((i + 2) % 3);
    const double noise = std::max(std::abs(p - q), imaginary);
    const double allowed = tolerance + noise * noise;
    if (std::abs(0.5 * (p + q).real() - 1) <= allowed &&
        std::abs(values(i).real() - third) <= allowed * std::max(1.0, std::abs(third))) {
      return true;
    }
  }
  return false;
}

class PlaneProblemFinder {
 public:
  PlaneProblemFinder(const MapData& map, std::vector<MapProblem>& problems)
      : map_(map), problems_(problems) {}

  void Find() {
    CheckIds("keyframes", map_.keyframes, problems_);
    CheckIds("planes", map_.planes, problems_);
    for (const Keyframe& keyframe : map_.keyframes) CheckKeyframe(keyframe);
    for (const Plane& plane : map_.planes) CheckPlane(plane);
    CheckEdges();
    CheckIndex();
    if (map_.verdict) CheckVerdict(*map_.verdict);
  }

 private:
  void Require(bool holds, const std::string& where, const std::string& message) {
    if (!holds) problems_.push_back({where, message});
  }

  void CheckKeyframe(const Keyframe& keyframe) {
    const std::string where = "keyframes " + Text(keyframe.id);
    image_px_[keyframe.id] = std::max({keyframe.width, keyframe.height, 1});
    Require(HasSequence(map_, keyframe.sequence), where,
            "no such sequence: " + Text(keyframe.sequence));
    Require(keyframe.stretch >= 0 && keyframe.frame >= 0, where,
            "stretch " + std::to_string(keyframe.stretch) + " or frame " +
                std::to_string(keyframe.frame) + " is below 0");
    Require(keyframe.width > 0 && keyframe.height > 0, where,
            "its image is " + std::to_string(keyframe.width) + "x" +
                std::to_string(keyframe.height) + " pixels");
    Require(std::isfinite(keyframe.time_s.value_or(0)), where, "its time is not finite");
    CheckLandmarks(keyframe);
  }

  void CheckLandmarks(const Keyframe& keyframe) {
    const std::string where = "keyframe_landmarks " + Text(keyframe.id);
    const Landmarks& landmarks = keyframe.landmarks;
    Require(landmarks.codes.rows() == landmarks.size(), where,
            std::to_string(landmarks.codes.rows()) + " codes for " +
                std::to_string(landmarks.size()) + " landmarks");
    const int bytes = CodeBytes(map_.info.feature_type);
    Require(landmarks.size() == 0 || landmarks.codes.bytes() == bytes, where,
            "codes of " + std::to_string(landmarks.codes.bytes()) + " bytes; " +
                std::string(NameOf(map_.info.feature_type)) + " has " + std::to_string(bytes));
  }

  void CheckPlane(const Plane& plane) {
    const std::string where = "planes " + Text(plane.id);
    planes_.insert(plane.id);
    Require(image_px_.contains(plane.reference), where,
            "there is no keyframe " + Text(plane.reference) + " for its reference");
    CheckFeatures(plane);
    const bool finite = std::all_of(plane.outline.begin(), plane.outline.end(),
                                    [](const auto& vertex) { return vertex.allFinite(); });
    Require(finite, where, "a vertex of its outline is not finite");
    CheckViews(plane);
  }

  void CheckFeatures(const Plane& plane) {
    const std::string where = "plane_features " + Text(plane.id);
    const size_t count = plane.features.size();
    Require(count <= kMaxFeatures, where,
            std::to_string(count) + " features; " + std::to_string(kMaxFeatures) + " fit");
    Require(plane.descriptors.rows() == static_cast<int>(count), where,
            std::to_string(plane.descriptors.rows()) + " descriptors for " + std::to_string(count) +
                " features");
    const int bytes = DescriptorBytes(map_.info.feature_type);
    Require(count == 0 || plane.descriptors.bytes() == bytes, where,
            "descriptors of " + std::to_string(plane.descriptors.bytes()) + " bytes; " +
                std::string(NameOf(map_.info.feature_type)) + " has " + std::to_string(bytes));
    // One line per plane, not per feature.
    for (size_t i = 0; i < count; ++i) {
      const std::string finding = FeatureProblem(plane.features[i], plane.views.size());
      if (finding.empty()) continue;
      problems_.push_back({where, "feature " + std::to_string(i) + finding});
      return;
    }
  }

  // A vote where the feature should not have been visible is a match beyond the image's border or
  // one of a plane that was fused: at most one a view.
  static std::string FeatureProblem(const PlaneFeature& feature, size_t views) {
    if (!IsFinite(feature.reference)) return " is not finite";
    const bool possible = feature.votes >= 1 && feature.votes <= kMaxVotes &&
                          feature.visible >= 0 && feature.visible <= kMaxVotes &&
                          feature.votes - feature.visible <= static_cast<int64_t>(views);
    if (possible) return "";
    return " has " + std::to_string(feature.votes) + " votes, visible in " +
           std::to_string(feature.visible) + " of " + std::to_string(views) + " views";
  }

  void CheckViews(const Plane& plane) {
    KeyframeId last;
    bool has_reference = false;
    for (const PlaneView& view : plane.views) {
      const std::string where = "plane_views " + Text(plane.id) + "/" + Text(view.keyframe);
      Require(view.keyframe > last, where, "views must be unique and sorted by keyframe");
      Require(image_px_.contains(view.keyframe), where,
              "there is no keyframe " + Text(view.keyframe));
      Require(view.inliers >= 0, where, std::to_string(view.inliers) + " inliers");
      CheckHomography(view.reference_from_keyframe, plane.reference, view.keyframe, where);
      if (view.keyframe == plane.reference) {
        has_reference = true;
        Require(view.reference_from_keyframe == Matrix3d::Identity(), where,
                "the homography of the reference view is not the identity");
      }
      last = view.keyframe;
    }
    Require(has_reference, "planes " + Text(plane.id),
            "no view of its reference, keyframe " + Text(plane.reference));
  }

  // Returns whether it should be checked further.
  bool CheckHomography(const Matrix3d& to_from, KeyframeId to, KeyframeId from,
                       const std::string& where) {
    Require(to_from.allFinite(), where, "its matrix is not finite");
    if (!to_from.allFinite()) return false;
    const double condition = ComputeCondition(to_from, ImageSide(to), ImageSide(from));
    const bool invertible = condition <= kMaxCondition;  // not for NaN
    Require(invertible, where,
            "its matrix is singular: condition number " + std::to_string(condition));
    return invertible;
  }

  void CheckEdges() {
    std::pair<PlaneId, PlaneId> last;
    for (const Edge& edge : map_.edges) {
      const std::string where = "edges " + Text(edge.a) + "/" + Text(edge.b);
      Require(edge.a < edge.b, where, "a must be below b");
      Require(std::pair(edge.a, edge.b) > last, where, "edges must be unique and sorted by (a, b)");
      last = {edge.a, edge.b};
      for (const PlaneId plane : {edge.a, edge.b}) {
        Require(planes_.contains(plane), where, "no such plane: " + Text(plane));
      }
      for (const KeyframeId keyframe : {edge.from, edge.to}) {
        Require(image_px_.contains(keyframe), where, "there is no keyframe " + Text(keyframe));
      }
      CheckHomology(edge, where);
    }
  }

  void CheckHomology(const Edge& edge, const std::string& where) {
    Require(std::isfinite(edge.third_eigenvalue), where, "its third eigenvalue is not finite");
    if (!CheckHomography(edge.homology, edge.to, edge.to, where)) return;
    Require(HasEigenvalues(edge.homology, edge.third_eigenvalue, kEigenvalueTolerance), where,
            "its homology does not have the eigenvalues 1, 1 and " +
                std::to_string(edge.third_eigenvalue));
  }

  void CheckIndex() {
    if (!map_.index) return;
    const std::string problem =
        InvertedFileProblem(*map_.index, CountFeatures(map_), map_.info.feature_type);
    Require(problem.empty(), "search_index 1", problem);
  }

  void CheckVerdict(const VerdictModel& model) {
    const std::string where = "verdict_model 1";
    Require(std::isfinite(model.intercept) && std::isfinite(model.log_inliers) &&
                std::isfinite(model.inlier_share),
            where, "a weight is not finite");
    Require(!(model.log_inliers <= 0), where, "inliers count against a place");
    Require(model.positives >= 0 && model.negatives >= 0, where, "its sample counts are negative");
  }

  double ImageSide(KeyframeId keyframe) const {
    const auto found = image_px_.find(keyframe);
    return found == image_px_.end() ? 1000 : found->second;  // reported elsewhere
  }

  const MapData& map_;
  std::vector<MapProblem>& problems_;
  std::unordered_map<KeyframeId, int> image_px_;
  std::unordered_set<PlaneId> planes_;
};

}  // namespace

void FindPlaneProblems(const MapData& map, std::vector<MapProblem>& problems) {
  PlaneProblemFinder(map, problems).Find();
}

}  // namespace waystone
