// SPDX-License-Identifier: Apache-2.0
#include "api/lines_json.h"

#include <optional>

#include "api/layer_json.h"
#include "core/base/error.h"
#include "core/camera/image_plane.h"
#include "core/camera/rig.h"
#include "core/image/decode.h"
#include "core/manhattan/directed_segments.h"

namespace waystone {
namespace {

cv::Mat PictureOf(const std::vector<uint8_t>& picture) {
  if (!picture.empty()) return DecodeGrey(picture);
  throw MapError(ErrorCode::kNotFound, "this map stores no images; rebuild it without --no-images");
}

std::optional<Camera> CameraOf(const MapIndex& index, SequenceId id) {
  const Sequence* sequence = index.FindSequence(id);
  return sequence ? sequence->camera : std::nullopt;
}

// The layer's rotation of a frame, if it is reliable.
std::optional<Eigen::Matrix3d> RigFromBuilding(const OrientationFrame* frame) {
  if (!frame || !frame->reliable) return std::nullopt;
  return Eigen::Matrix3d(frame->rotation->building_from_rig.conjugate());
}

// `scale` takes pixels of the picture to those of the answer; (0, 0) is the centre of the first
// pixel in both.
Json LinesJson(const cv::Mat& picture, const Camera& camera, const OrientationFrame* frame,
               double scale) {
  const char* const axes[] = {"x", "y", "z"};
  const auto rig_from_building = RigFromBuilding(frame);
  const DirectedSegments found = FindDirectedSegments(picture, camera, rig_from_building);
  const auto point = [scale](const Eigen::Vector2d& px) {
    return Eigen::Vector2d(scale * (px.array() + 0.5) - 0.5);
  };
  Json json;
  json["of"] = rig_from_building ? "frame" : "picture";
  json["reliable"] = found.reliable;
  json["lines"] = Json::array();
  for (const DirectedSegment& line : found.segments) {
    const std::vector<Eigen::Vector2d> ends{point(line.segment.a), point(line.segment.b)};
    json["lines"].push_back({{"axis", line.axis < 0 ? Json(nullptr) : Json(axes[line.axis])},
                             {"points", ToJson(ends)}});
  }
  return json;
}

Json Sized(int width, int height, const Json& lines) {
  Json json;
  json["width"] = width;
  json["height"] = height;
  json.update(lines);
  return json;
}

}  // namespace

Json LinesJson(const MapIndex& index, const Keyframe& keyframe) {
  const std::optional<Camera> camera = CameraOf(index, keyframe.sequence);
  if (!camera) {
    throw MapError(ErrorCode::kNotAvailable,
                   "line directions require a camera, and this keyframe's sequence has none; build "
                   "the map with --camera");
  }
  if (camera->model == CameraModel::kEquirectangular) {
    throw MapError(ErrorCode::kNotAvailable,
                   "the stored copy of the panorama is too small for line detection; request the "
                   "lines of a node of the orientation layer instead");
  }
  const cv::Mat picture = PictureOf(keyframe.picture);
  return Sized(keyframe.width, keyframe.height,
               LinesJson(picture, ScaledCamera(*camera, picture.cols),
                         index.FindFrame(keyframe.sequence, keyframe.frame),
                         static_cast<double>(keyframe.width) / picture.cols));
}

Json LinesJson(const MapIndex& index, const OrientationNode& node) {
  const cv::Mat picture = PictureOf(node.picture);
  const OrientationFrame* frame = FrameOf(OrientationOf(index), node.frame);
  const std::optional<Camera> camera =
      frame ? CameraOf(index, frame->sequence) : std::optional<Camera>();
  // The picture of a rig that sees all around is its front face.
  const bool face = !camera || camera->model == CameraModel::kEquirectangular;
  const Camera seen =
      face ? CubeRig(picture.cols).cameras.front().camera : ScaledCamera(*camera, picture.cols);
  return Sized(picture.cols, picture.rows, LinesJson(picture, seen, frame, 1));
}

}  // namespace waystone
