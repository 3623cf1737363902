// SPDX-License-Identifier: Apache-2.0
#include "builder/report/overlay.h"

#include <Eigen/LU>
#include <algorithm>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <vector>

#include "builder/report/colours.h"
#include "core/homography/homography.h"

namespace waystone {
namespace {

constexpr int kPictureWidth = 640;   // px, of the pictures on the page
constexpr int kMaxHeight = 4096;     // px, of one of a narrow image
constexpr int kDotRadius = 3;        // px
constexpr int kSubPixelBits = 4;     // cv::polylines takes fractions of a pixel this fine
constexpr double kFarAwayPx = 2000;  // beyond which a line's end isn't drawn
const cv::Scalar kNoPicture(90, 90, 90);

cv::Mat Canvas(const Keyframe& keyframe) {
  const double scale = std::min(static_cast<double>(kPictureWidth) / std::max(1, keyframe.width),
                                static_cast<double>(kMaxHeight) / std::max(1, keyframe.height));
  const cv::Size size(std::max(1, static_cast<int>(scale * keyframe.width)),
                      std::max(1, static_cast<int>(scale * keyframe.height)));
  cv::Mat picture;
  if (!keyframe.picture.empty()) picture = cv::imdecode(keyframe.picture, cv::IMREAD_COLOR);
  if (picture.empty()) return {size, CV_8UC3, kNoPicture};
  cv::resize(picture, picture, size, 0, 0, cv::INTER_CUBIC);
  return picture;
}

// A plane as one keyframe sees it, in the canvas's pixels.
class Projection {
 public:
  Projection(const Plane& plane, const PlaneView& view, double canvas_from_keyframe)
      : keyframe_from_reference_(view.reference_from_keyframe.inverse()),
        scale_(canvas_from_keyframe) {
    for (const PlaneFeature& feature : plane.features) {
      inside_ += Eigen::Vector2d(feature.reference.x_px, feature.reference.y_px);
    }
    inside_ /= std::max<double>(1, static_cast<double>(plane.features.size()));
  }

  // Nothing for a point that the keyframe would see behind itself, or that lies far out.
  std::optional<cv::Point2d> At(const Eigen::Vector2d& x_reference) const {
    if (!OnSameSide(keyframe_from_reference_, x_reference, inside_)) return std::nullopt;
    const Eigen::Vector2d x = Apply(keyframe_from_reference_, x_reference) * scale_;
    if (!(x.cwiseAbs().maxCoeff() < kFarAwayPx)) return std::nullopt;
    return cv::Point2d(x.x(), x.y());
  }

 private:
  Eigen::Matrix3d keyframe_from_reference_;
  Eigen::Vector2d inside_ = Eigen::Vector2d::Zero();
  double scale_;
};

cv::Point Fixed(const cv::Point2d& p) {
  constexpr double kUnit = 1 << kSubPixelBits;
  return {static_cast<int>(p.x * kUnit), static_cast<int>(p.y * kUnit)};
}

void DrawOutline(cv::Mat& canvas, const Plane& plane, const Projection& project,
                 const cv::Scalar& colour) {
  for (size_t i = 0; i < plane.outline.size(); ++i) {
    const auto a = project.At(plane.outline[i]);
    const auto b = project.At(plane.outline[(i + 1) % plane.outline.size()]);
    if (!a || !b) continue;
    cv::line(canvas, Fixed(*a), Fixed(*b), colour, 2, cv::LINE_AA, kSubPixelBits);
  }
}

void DrawFeatures(cv::Mat& canvas, const Plane& plane, const Projection& project,
                  const cv::Scalar& colour) {
  for (const PlaneFeature& feature : plane.features) {
    const auto at = project.At({feature.reference.x_px, feature.reference.y_px});
    if (!at || !cv::Rect2d(0, 0, canvas.cols, canvas.rows).contains(*at)) continue;
    cv::circle(canvas, Fixed(*at), kDotRadius << kSubPixelBits, colour, cv::FILLED, cv::LINE_AA,
               kSubPixelBits);
  }
}

}  // namespace

cv::Mat DrawPlanes(const MapData& map, const std::vector<PlaneId>& surface_of_plane,
                   const Keyframe& keyframe) {
  cv::Mat canvas = Canvas(keyframe);
  const double scale = static_cast<double>(canvas.cols) / std::max(1, keyframe.width);
  for (size_t p = 0; p < map.planes.size(); ++p) {
    const Plane& plane = map.planes[p];
    const cv::Scalar colour = ColourOf(surface_of_plane[p]);
    for (const PlaneView& view : plane.views) {
      if (view.keyframe != keyframe.id) continue;
      const Projection project(plane, view, scale);
      DrawOutline(canvas, plane, project, colour);
      DrawFeatures(canvas, plane, project, colour);
    }
  }
  return canvas;
}

}  // namespace waystone
