// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "api/json.h"
#include "core/camera/camera.h"
#include "core/geometry/pose2.h"
#include "core/image/decode.h"
#include "schema/map_data.h"
#include "server/http/message.h"

namespace waystone {

struct RequestLimits {
  // Images of one request, 1 to 64: a rig's, or a series. Each costs a query.
  int max_images = 8;
  // Longest deadline that a client may set, ms.
  int max_deadline_ms = 60'000;

  void Check() const;  // throws MapError(kBadOptions)
};

struct QueryImage {
  std::string name;
  std::string bytes;  // encoded
};

// Focal lengths and principal point of an image without distortion, px.
struct Intrinsics {
  double fx = 0;
  double fy = 0;
  double cx = 0;
  double cy = 0;
};

// What a client asks: the body's images in their order, and what it knows about them.
struct LocalizeRequest {
  std::vector<QueryImage> images;  // one at least
  // At most one of these three says what the camera is.
  std::optional<Intrinsics> intrinsics;
  std::optional<double> fov_rad;             // horizontal
  std::optional<std::string> stored_camera;  // name of a sequence of the map
  std::optional<int64_t> prior_keyframe;     // where the client believes to be
  // The answer before this one, as its client keeps it: {"keyframe": id, "heading_rad": angle,
  // "map_version": text, "belief": [{"node": id, "probability", "heading_rad", "sigma_rad"}]},
  // each optional. Null without one.
  Json previous;
  // Of each image, in their order, the motion since the image or answer before it, in the units of
  // the map's layer; nothing where it isn't known. Empty when none was given.
  std::vector<std::optional<Pose2>> odometry;
  std::optional<int> top_k;  // list that many candidates
  bool debug = false;        // explain the answer
  std::optional<int> deadline_ms;
};

// Reads and parses a request by its Content-Type:
//   image/*, application/octet-stream, none: the image; the rest as query parameters;
//   multipart/form-data: parts `image` (one or more) and `request`, a JSON object;
//   application/json: the same object with "images": [{"name", "data": base64}].
// Throws MapError: kUnsupportedMedia, kPayloadTooLarge, and kBadRequest with the field at fault for
// what is unknown, out of range or contradicts itself.
LocalizeRequest ReadLocalizeRequest(const HttpRequest& request, const RequestLimits& limits);

// The object of a request, without images: for logs. ParseRequestObject reads it again.
Json RequestObject(const LocalizeRequest& request);
LocalizeRequest ParseRequestObject(const Json& object, const RequestLimits& limits);

// The camera of an image by what the request says and the map stores; nothing when it says nothing.
// Throws MapError(kBadCamera) for a name that the map doesn't have, and for one of another size.
std::optional<Camera> CameraOf(const LocalizeRequest& request, const MapData& map,
                               const ImageHeader& image);

// The camera by the image's own EXIF data, without distortion; nothing for images that say nothing.
std::optional<Camera> CameraByExif(const QueryImage& image);

// The camera of an image by the request or else by the image itself; nothing without one, or for
// bytes that are no image, whose answer says so. Throws as CameraOf.
std::optional<Camera> CameraFor(const LocalizeRequest& request, const MapData& map,
                                const QueryImage& image);

}  // namespace waystone
