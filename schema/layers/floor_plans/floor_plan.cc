// SPDX-License-Identifier: Apache-2.0
#include "schema/layers/floor_plans/floor_plan.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstdio>

#include "core/base/error.h"
#include "core/base/text.h"
#include "core/image/decode.h"

namespace waystone {
namespace {

using Complex = std::complex<double>;

constexpr double kMinAnchorDistance = 1e-3;  // of the largest one
constexpr double kMinOffLine = 0.01;         // of the largest distance
constexpr double kMaxResidual = 0.05;        // of the largest distance

std::string NumberText(double value) {
  char text[40];
  (void)std::snprintf(text, sizeof text, "%.4g", value);
  return text;
}

std::string PointText(const Eigen::Vector2d& point) {
  return "(" + NumberText(point.x()) + ", " + NumberText(point.y()) + ")";
}

using Points = std::vector<Eigen::Vector2d>;

Points PixelsOf(const std::vector<PlanAnchor>& anchors) {
  Points points;
  for (const PlanAnchor& anchor : anchors) points.push_back(anchor.px);
  return points;
}

Points PlacesOf(const std::vector<PlanAnchor>& anchors) {
  Points points;
  for (const PlanAnchor& anchor : anchors) points.push_back(anchor.at);
  return points;
}

// Smallest and largest distances of two points, and of the rest from the line through the two that
// are farthest apart.
struct Spread {
  double largest = 0;
  double smallest = 0;
  double off_line = 0;
};

Spread SpreadOf(const Points& points) {
  Spread spread;
  spread.smallest = (points[1] - points[0]).norm();
  Eigen::Vector2d from = points[0], to = points[1];
  for (size_t i = 0; i < points.size(); ++i) {
    for (size_t j = i + 1; j < points.size(); ++j) {
      const double distance = (points[j] - points[i]).norm();
      spread.smallest = std::min(spread.smallest, distance);
      if (distance <= spread.largest) continue;
      spread.largest = distance;
      from = points[i];
      to = points[j];
    }
  }
  if (!(spread.largest > 0)) return spread;
  const Eigen::Vector2d along = (to - from) / spread.largest;
  for (const Eigen::Vector2d& point : points) {
    const Eigen::Vector2d offset = point - from;
    const double off = std::abs(along.x() * offset.y() - along.y() * offset.x());
    spread.off_line = std::max(spread.off_line, off);
  }
  return spread;
}

Eigen::Vector2d MeanOf(const Points& points) {
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  for (const Eigen::Vector2d& point : points) sum += point;
  return sum / static_cast<double>(points.size());
}

std::optional<std::string> FindBoundsProblem(const std::vector<PlanAnchor>& anchors, int width,
                                             int height) {
  for (const PlanAnchor& anchor : anchors) {
    // NaN, too, isn't within the bounds.
    const bool inside = anchor.px.x() >= 0 && anchor.px.x() <= width && anchor.px.y() >= 0 &&
                        anchor.px.y() <= height;
    if (!inside) {
      return "the anchor at pixel " + PointText(anchor.px) + " is outside of the image of " +
             SizeText(width, height) + " px";
    }
    if (!(anchor.at.cwiseAbs().maxCoeff() <= kMaxPlanCoordinate) || !anchor.at.allFinite()) {
      return "the anchor at pixel " + PointText(anchor.px) + " lies beyond 1e9 in the map";
    }
  }
  return std::nullopt;
}

// Of anchors on the plan or in the map.
std::optional<std::string> FindSpreadProblem(const Points& points, const char* where) {
  const Spread spread = SpreadOf(points);
  if (!(spread.smallest > kMinAnchorDistance * spread.largest)) {
    return std::string("two anchors are at the same point ") + where +
           "; choose points that are far apart";
  }
  if (points.size() > 2 && spread.off_line < kMinOffLine * spread.largest) {
    return "the " + std::to_string(points.size()) + " anchors are on one line " + where +
           "; choose one beside the line, or two alone";
  }
  return std::nullopt;
}

}  // namespace

PlanFit FitPlan(const std::vector<PlanAnchor>& anchors) {
  const Eigen::Vector2d px_mean = MeanOf(PixelsOf(anchors)), at_mean = MeanOf(PlacesOf(anchors));
  Complex product = 0;
  double square = 0;
  for (const PlanAnchor& anchor : anchors) {
    const Eigen::Vector2d px = anchor.px - px_mean, at = anchor.at - at_mean;
    product += std::conj(Complex(at.x(), at.y())) * Complex(px.x(), -px.y());  // y up in both
    square += at.squaredNorm();
  }
  const Complex turn = product / square;
  PlanFit fit;
  fit.px_per_unit = std::abs(turn);
  fit.plan_from_frame.leftCols<2>() << turn.real(), -turn.imag(), -turn.imag(), -turn.real();
  fit.plan_from_frame.col(2) = px_mean - fit.plan_from_frame.leftCols<2>() * at_mean;
  double off = 0;
  for (const PlanAnchor& anchor : anchors) off += (fit.Of(anchor.at) - anchor.px).squaredNorm();
  fit.residual_px = std::sqrt(off / static_cast<double>(anchors.size()));
  return fit;
}

std::optional<std::string> FindAnchorProblem(const std::vector<PlanAnchor>& anchors, int width,
                                             int height) {
  if (anchors.size() < 2 || anchors.size() > kMaxPlanAnchors) {
    return "it has " + std::to_string(anchors.size()) + " anchors; 2 to " +
           std::to_string(kMaxPlanAnchors) + " are needed";
  }
  if (auto problem = FindBoundsProblem(anchors, width, height)) return problem;
  if (auto problem = FindSpreadProblem(PixelsOf(anchors), "of the image")) return problem;
  if (auto problem = FindSpreadProblem(PlacesOf(anchors), "of the map")) return problem;
  const double allowed_px = kMaxResidual * SpreadOf(PixelsOf(anchors)).largest;
  const PlanFit fit = FitPlan(anchors);
  if (fit.residual_px <= allowed_px) return std::nullopt;
  std::vector<PlanAnchor> mirrored = anchors;
  for (PlanAnchor& anchor : mirrored) anchor.at.x() = -anchor.at.x();
  if (FitPlan(mirrored).residual_px <= allowed_px) {
    return "the anchors fit to a mirrored plan only; check the order and the signs of x and y "
           "(pixels count from the upper left corner)";
  }
  const PlanAnchor& worst = *std::ranges::max_element(
      anchors, {},
      [&fit](const PlanAnchor& anchor) { return (fit.Of(anchor.at) - anchor.px).norm(); });
  return "the anchors don't fit a plan that is drawn to scale: they are off by " +
         NumberText(fit.residual_px) + " px (at most " + NumberText(allowed_px) +
         " px), the most at pixel " + PointText(worst.px) + "; correct that one, or leave it out";
}

PlanImageSize InspectPlanImage(std::span<const uint8_t> image) {
  if (image.size() > kMaxPlanImageBytes) {
    return {0, 0,
            "has " + std::to_string(image.size()) + " bytes; at most " +
                std::to_string(kMaxPlanImageBytes) + " are allowed; scale it down"};
  }
  try {
    const ImageHeader header = ReadImageHeader(image);
    if (header.format != "jpeg" && header.format != "png" && header.format != "webp") {
      return {0, 0, "is a " + header.format + "; save it as PNG, JPEG or WebP"};
    }
    CheckLimits(header, {});
    return {header.width, header.height, ""};
  } catch (const MapError& error) {
    return {0, 0, error.what()};
  }
}

}  // namespace waystone
