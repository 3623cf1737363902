// SPDX-License-Identifier: Apache-2.0
#include "builder/joining/join_frames.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>

#include "builder/joining/align_frames.h"
#include "builder/joining/joinable.h"
#include "core/base/error.h"
#include "schema/layers/poses/horizontal.h"

namespace waystone {
namespace {

// The map whose frame is kept; nothing where no map has poses.
std::optional<size_t> ChooseFrame(const std::vector<MapData>& maps, bool keep_first) {
  std::optional<size_t> chosen;
  for (size_t i = 0; i < maps.size(); ++i) {
    if (!maps[i].poses) continue;
    if (keep_first || maps[i].poses->unit == LengthUnit::kMetres) return i;
    if (!chosen) chosen = i;
  }
  return chosen;
}

// Of the position, on each axis.
double PositionSigma(const QueryPose& pose) {
  return std::sqrt(std::max(0.0, pose.covariance.topLeftCorner<3, 3>().trace() / 3));
}

// Cameras of keyframes of either map in the frames of both; `to` has already been converted.
std::vector<CameraInFrames> CommonCameras(const std::vector<Recognition>& recognitions,
                                          const std::vector<MapData>& maps, size_t to,
                                          size_t from) {
  std::vector<CameraInFrames> cameras;
  for (const Recognition& recognition : recognitions) {
    const bool forth = recognition.asked == to && recognition.asking == from;
    const bool back = recognition.asked == from && recognition.asking == to;
    if (!forth && !back) continue;
    const MapData& asking = maps[recognition.asking];
    const auto add = [&](const CameraPose* own, const std::optional<QueryPose>& answered) {
      if (own == nullptr || !answered) return;
      const Eigen::Isometry3d given = own->frame_from_camera();
      const Eigen::Isometry3d& found = answered->frame_from_camera;
      cameras.push_back(
          {forth ? found : given, forth ? given : found, PositionSigma(*answered), back});
    };
    for (const RecognisedKeyframe& one : recognition.keyframes) {
      add(asking.poses->Find(asking.keyframes[one.asking].id), one.pose);
    }
    for (const RecognisedNode& one : recognition.nodes) {
      add(asking.poses->Find(asking.appearance->nodes[one.asking].id), one.in_frame);
    }
  }
  return cameras;
}

// The change into the frame of the maps that are `done`, from the first of them that yields one.
std::optional<FrameChange> FindChange(const std::vector<Recognition>& recognitions,
                                      const std::vector<MapData>& maps,
                                      const std::vector<size_t>& done, size_t from) {
  for (const size_t to : done) {
    const bool same_unit = maps[to].poses->unit == LengthUnit::kMetres &&
                           maps[from].poses->unit == LengthUnit::kMetres;
    auto change = AlignFrames(CommonCameras(recognitions, maps, to, from), same_unit);
    if (change) return change;
  }
  return std::nullopt;
}

// The mean height of keyframes and panoramas.
double MeanHeight(const PoseLayer& layer, const Horizontal& view) {
  double sum = 0;
  for (const KeyframePose& pose : layer.keyframes) sum += view.up.dot(pose.position);
  for (const NodePose& pose : layer.nodes) sum += view.up.dot(pose.position);
  const size_t count = layer.keyframes.size() + layer.nodes.size();
  return count == 0 ? 0 : sum / static_cast<double>(count);
}

// A change of frame as seen from above, as high as the keyframes and panoramas.
class ChangeFromAbove {
 public:
  ChangeFromAbove(const FrameChange& change, const PoseLayer& from, const PoseLayer& to)
      : change_(change),
        from_(HorizontalOf(from)),
        to_(HorizontalOf(to)),
        height_(MeanHeight(from, from_)) {}

  Eigen::Vector2d operator()(const Eigen::Vector2d& point) const {
    const Eigen::Vector3d at = point.x() * from_.right + point.y() * from_.top + height_ * from_.up;
    return to_.Of(change_.scale * change_.rotation * at + change_.translation);
  }

  Pose2 operator()(const Pose2& pose) const {
    const Eigen::Vector2d at = (*this)(Eigen::Vector2d(pose.x, pose.y));
    const Eigen::Vector3d ahead =
        std::cos(pose.theta_rad) * from_.right + std::sin(pose.theta_rad) * from_.top;
    const Eigen::Vector2d turned = to_.Of(change_.rotation * ahead);
    return {at.x(), at.y(), std::atan2(turned.y(), turned.x())};
  }

 private:
  const FrameChange& change_;
  Horizontal from_;
  Horizontal to_;
  double height_;
};

// An appearance layer that is in the frame of the map's poses.
void ChangeLayer(const FrameChange& change, const ChangeFromAbove& above, const PoseLayer& to,
                 AppearanceLayer& layer) {
  for (AppearanceNode& node : layer.nodes) node.pose = above(node.pose);
  for (AppearanceEdge& edge : layer.edges) {
    edge.a_from_b.x *= change.scale;
    edge.a_from_b.y *= change.scale;
  }
  layer.metres_per_unit = to.unit == LengthUnit::kMetres ? std::optional<double>(1) : std::nullopt;
}

// Expresses a map in the frame of `to`.
void ChangeMap(const FrameChange& change, const ChangeFromAbove& above, const PoseLayer& to,
               MapData& map) {
  for (NamedPlace& place : map.names) {
    for (NamedPolygon& polygon : place.polygons) {
      for (Eigen::Vector2d& corner : polygon) corner = above(corner);
    }
  }
  if (!map.poses->nodes.empty()) ChangeLayer(change, above, to, *map.appearance);
  ChangeFrame(change, *map.poses);
  map.poses->frame = to.frame;
  map.poses->unit = to.unit;
}

void ChangeAnswer(const FrameChange& change, std::optional<QueryPose>& answered) {
  if (!answered) return;
  Eigen::Isometry3d& pose = answered->frame_from_camera;
  pose.linear() = change.rotation * pose.linear();
  pose.translation() = change.scale * change.rotation * pose.translation() + change.translation;
  answered->covariance.topRows<3>() *= change.scale;
  answered->covariance.leftCols<3>() *= change.scale;
}

// Converts the answers of the changed map; with `layer`, those in its appearance layer too.
void ChangeAnswers(const FrameChange& change, const ChangeFromAbove& above, bool layer, size_t map,
                   std::vector<Recognition>& recognitions) {
  for (Recognition& recognition : recognitions) {
    if (recognition.asked != map) continue;
    for (RecognisedKeyframe& one : recognition.keyframes) ChangeAnswer(change, one.pose);
    for (RecognisedNode& one : recognition.nodes) {
      ChangeAnswer(change, one.in_frame);
      if (!layer) continue;
      one.pose = above(one.pose);
      one.position_sigma *= change.scale;
    }
  }
}

}  // namespace

std::optional<size_t> JoinFrames(std::vector<Recognition>& recognitions, bool keep_first,
                                 std::vector<MapData>& maps) {
  const std::optional<size_t> kept = ChooseFrame(maps, keep_first);
  if (!kept) return std::nullopt;
  std::vector<size_t> done{*kept};
  std::vector<size_t> left;
  for (size_t i = 0; i < maps.size(); ++i) {
    if (i != *kept && maps[i].poses) left.push_back(i);
  }
  while (!left.empty()) {
    std::optional<FrameChange> change;
    const auto aligned = std::ranges::find_if(left, [&](size_t i) {
      change = FindChange(recognitions, maps, done, i);
      return change.has_value();
    });
    if (aligned == left.end()) {
      throw MapError(
          ErrorCode::kBadRequest,
          Named(maps[left.front()]) + " and " + Named(maps[*kept]) +
              " have poses in frames that can't be aligned: fewer than 3 keyframes or panoramas, "
              "or less than half, agree on how they lie; build one of them without --poses");
    }
    const size_t map = *aligned;
    const PoseLayer& to = *maps[*kept].poses;
    const ChangeFromAbove above(*change, *maps[map].poses, to);
    const bool layer = !maps[map].poses->nodes.empty();
    ChangeMap(*change, above, to, maps[map]);
    ChangeAnswers(*change, above, layer, map, recognitions);
    left.erase(aligned);
    done.push_back(map);
  }
  return kept;
}

}  // namespace waystone
