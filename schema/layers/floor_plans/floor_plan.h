// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

// Images of floor plans on which the map is drawn. FORMAT.md says how they are stored. All
// functions are pure; thread-safe.
namespace waystone {

// A point of the building that is known in both the plan and the map.
struct PlanAnchor {
  Eigen::Vector2d px = Eigen::Vector2d::Zero();  // of the image: (0, 0) is its upper left corner
  // Of the map as seen from above: in the frame and unit that polygons of named places are in
  // (NamedPolygon).
  Eigen::Vector2d at = Eigen::Vector2d::Zero();

  bool operator==(const PlanAnchor&) const = default;
};

// The part of a building that a plan shows: heights along HorizontalOf's up axis, in the unit of
// the pose layer.
struct PlanHeights {
  double low = 0;
  double high = 0;

  bool Hold(double height) const { return low <= height && height <= high; }
  bool operator==(const PlanHeights&) const = default;
};

struct FloorPlanImage {
  std::string name;  // as names of places are
  int width = 0;     // of the image, px
  int height = 0;
  std::vector<PlanAnchor> anchors;
  std::optional<PlanHeights> heights;  // nothing: all
  // JPEG, PNG or WebP, as it was given; empty where a map was read without pictures.
  std::vector<uint8_t> image;

  bool operator==(const FloorPlanImage&) const = default;
};

// Limits on the floor plans of a map.
inline constexpr size_t kMaxFloorPlans = 32;
inline constexpr size_t kMaxPlanAnchors = 100;                // of one plan
inline constexpr size_t kMaxPlanImageBytes = 8'000'000;       // of one plan
inline constexpr double kMaxPlanCoordinate = 1e9;             // of an anchor, absolute
inline constexpr double kMaxPlanHeight = kMaxPlanCoordinate;  // absolute

// Maps a point of the map as seen from above to the image: px = plan_from_frame * (x, y, 1). A
// rotation, a scale and a translation, with the rows of the image counted downwards.
struct PlanFit {
  Eigen::Matrix<double, 2, 3> plan_from_frame = Eigen::Matrix<double, 2, 3>::Zero();
  double px_per_unit = 0;
  double residual_px = 0;  // root mean square over the anchors

  Eigen::Vector2d Of(const Eigen::Vector2d& at) const {
    return plan_from_frame.leftCols<2>() * at + plan_from_frame.col(2);
  }
};

// The least-squares fit of the anchors, in which FindAnchorProblem must find no problem.
PlanFit FitPlan(const std::vector<PlanAnchor>& anchors);

// Why no plan of this size can be fitted to the anchors: there are fewer than two or too many, some
// are outside the image or too far away, some coincide, all (three or more) are on one line, they
// are mirrored, or they are off their fit by more than a twentieth of the distance that they span.
// Nothing where a plan can be fitted.
std::optional<std::string> FindAnchorProblem(const std::vector<PlanAnchor>& anchors, int width,
                                             int height);

// The size of a plan's image, px, or why the bytes can't be one: they are too many, not a JPEG, PNG
// or WebP that is complete by its header, or exceed the limits on images (DecodeLimits).
struct PlanImageSize {
  int width = 0;
  int height = 0;
  std::string problem;  // empty where there is none
};
PlanImageSize InspectPlanImage(std::span<const uint8_t> image);

}  // namespace waystone
