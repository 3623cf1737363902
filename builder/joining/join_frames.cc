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

// Cameras of keyframes of either map in the frames of both, in which `to` is expressed already.
std::vector<CameraInFrames> CommonCameras(const std::vector<Recognition>& recognitions,
                                          const std::vector<MapData>& maps, size_t to,
                                          size_t from) {
  std::vector<CameraInFrames> cameras;
  for (const Recognition& recognition : recognitions) {
    const bool forth = recognition.asked == to && recognition.asking == from;
    const bool back = recognition.asked == from && recognition.asking == to;
    if (!forth && !back) continue;
    const MapData& asking = maps[recognition.asking];
    for (const RecognisedKeyframe& one : recognition.keyframes) {
      const KeyframePose* own = asking.poses->Find(asking.keyframes[one.asking].id);
      if (own == nullptr || !one.pose) continue;
      const Eigen::Isometry3d given = own->frame_from_camera();
      const Eigen::Isometry3d& found = one.pose->frame_from_camera;
      cameras.push_back({forth ? found : given, forth ? given : found, PositionSigma(*one.pose)});
    }
  }
  return cameras;
}

// The change into the frame of the maps that are `done`, by the first of them that gives one.
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

// Of keyframes, along what is up.
double MeanHeight(const PoseLayer& layer, const Horizontal& view) {
  double sum = 0;
  for (const KeyframePose& pose : layer.keyframes) sum += view.up.dot(pose.position);
  return layer.keyframes.empty() ? 0 : sum / static_cast<double>(layer.keyframes.size());
}

// Expresses a map in the frame of `to`: poses, and areas of named places, as high as the keyframes.
void ChangeMap(const FrameChange& change, const PoseLayer& to, MapData& map) {
  const Horizontal from = HorizontalOf(*map.poses);
  const double height = MeanHeight(*map.poses, from);
  const Horizontal view = HorizontalOf(to);
  for (NamedPlace& place : map.names) {
    for (NamedPolygon& polygon : place.polygons) {
      for (Eigen::Vector2d& corner : polygon) {
        const Eigen::Vector3d at =
            corner.x() * from.right + corner.y() * from.top + height * from.up;
        corner = view.Of(change.scale * change.rotation * at + change.translation);
      }
    }
  }
  ChangeFrame(change, *map.poses);
  map.poses->frame = to.frame;
  map.poses->unit = to.unit;
}

// Poses in the changed map's frame that its answers gave change with it.
void ChangeAnswers(const FrameChange& change, size_t map, std::vector<Recognition>& recognitions) {
  for (Recognition& recognition : recognitions) {
    if (recognition.asked != map) continue;
    for (RecognisedKeyframe& one : recognition.keyframes) {
      if (!one.pose) continue;
      Eigen::Isometry3d& pose = one.pose->frame_from_camera;
      pose.linear() = change.rotation * pose.linear();
      pose.translation() = change.scale * change.rotation * pose.translation() + change.translation;
      one.pose->covariance.topRows<3>() *= change.scale;
      one.pose->covariance.leftCols<3>() *= change.scale;
    }
  }
}

}  // namespace

std::optional<size_t> JoinFrames(const std::vector<Recognition>& given, bool keep_first,
                                 std::vector<MapData>& maps) {
  const std::optional<size_t> kept = ChooseFrame(maps, keep_first);
  if (!kept) return std::nullopt;
  std::vector<Recognition> recognitions = given;
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
              " have poses in frames that can't be aligned: fewer than 3 keyframes, or "
              "less than half, agree on how they lie; build one of them without --poses");
    }
    const size_t map = *aligned;
    ChangeMap(*change, *maps[*kept].poses, maps[map]);
    ChangeAnswers(*change, map, recognitions);
    left.erase(aligned);
    done.push_back(map);
  }
  return kept;
}

}  // namespace waystone
