// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "core/base/clock.h"
#include "core/base/ids.h"
#include "core/camera/camera.h"
#include "core/geometry/pose2.h"
#include "localizer/planes/image_features.h"
#include "schema/map_data.h"

// Requests to the localizer, without files, JSON or HTTP. All functions are thread-safe.
namespace waystone {

// An image of a query.
struct QueryImage {
  std::string name;
  std::string bytes;  // encoded (JPEG, PNG, ...)
  cv::Mat grey = {};  // decoded already (8-bit grey): the bytes are not looked at
  std::shared_ptr<ImageFeatures> features = {};  // already extracted from the bytes; may be null
};

// Focal lengths and principal point of an image without distortion, px.
struct Intrinsics {
  double fx = 0;
  double fy = 0;
  double cx = 0;
  double cy = 0;
};

// The probability that a robot is at a node of the appearance layer, and its heading there.
struct NodeBelief {
  AppearanceNodeId node;
  double probability = 0;  // in [0, 1]
  double heading_rad = 0;  // in the layer's frame
  double sigma_rad = 0;    // of the heading

  bool operator==(const NodeBelief&) const = default;
};

// What a client kept of the answer before this query.
struct PreviousAnswer {
  std::optional<KeyframeId> keyframe;
  std::optional<double> heading_rad;
  std::optional<std::string> map_version;
  std::optional<std::vector<NodeBelief>> belief;

  bool operator==(const PreviousAnswer&) const = default;
};

// Near a point of a frame in which maps have poses.
struct PositionHint {
  std::string frame;       // PoseLayer::frame, or "appearance" for maps of panoramas without poses
  std::vector<double> at;  // x, y, and z where it is known; in the frame's units
  double radius = 0;       // in the same
};

// Restricts a query of all maps of a registry to some of them.
struct MapHints {
  std::optional<PositionHint> position;
  std::vector<std::string> tags;            // of maps that were published with all of them
  std::optional<std::string> previous_map;  // queried in any case
};

// One query: images in their order, and what is known about them.
struct QueryRequest {
  std::vector<QueryImage> images;  // one at least
  // At most one of these three defines the camera; else the first image's EXIF data may.
  std::optional<Intrinsics> intrinsics;
  std::optional<double> fov_rad;             // horizontal
  std::optional<std::string> stored_camera;  // name of a sequence of the map
  std::optional<KeyframeId> prior_keyframe;  // where the client believes it is
  std::optional<PreviousAnswer> previous;
  // For each image, in order, the motion since the image or answer before it, in the units of the
  // map's layer; nothing where it isn't known. Empty when none was given.
  std::vector<std::optional<Pose2>> odometry;
  std::optional<MapHints> hints;  // for queries of all maps
  std::optional<int> top_k;       // list that many candidates
  bool debug = false;             // explain the answer
  std::optional<int> deadline_ms;
  // When deadline_ms starts; unset: when the session begins.
  std::optional<Clock::time_point> received;
};

// The source of a query's camera.
enum class CameraSource { kStored, kFov, kIntrinsics, kExif };
const char* NameOf(CameraSource source);  // "stored", "fov", "intrinsics", "exif"

struct QueryCamera {
  Camera camera;
  CameraSource source = CameraSource::kExif;
};

// Whether the request itself defines the camera.
bool NamesCamera(const QueryRequest& request);

// The camera of an image from the request and the map, or else from the image's EXIF data, without
// distortion. Nothing where neither has one, and for bytes that aren't an image, which the answer
// reports. Throws MapError(kBadCamera) for a name that the map doesn't have, and for a stored
// camera of another size.
std::optional<QueryCamera> ResolveCamera(const QueryRequest& request, const MapData& map,
                                         const QueryImage& image);

}  // namespace waystone
