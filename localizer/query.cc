// SPDX-License-Identifier: Apache-2.0
#include "localizer/query.h"

#include <cmath>
#include <span>

#include "core/base/check.h"
#include "core/base/error.h"
#include "core/base/text.h"
#include "core/image/decode.h"
#include "core/image/exif.h"

namespace waystone {
namespace {

std::string Quoted(const std::string& text) { return "'" + text.substr(0, 40) + "'"; }

const Sequence* FindCameraSequence(const MapData& map, const std::string& name) {
  for (const Sequence& sequence : map.sequences) {
    if (sequence.name == name && sequence.camera) return &sequence;
  }
  return nullptr;
}

Camera StoredCamera(const MapData& map, const std::string& name, const cv::Size& image) {
  const Sequence* sequence = FindCameraSequence(map, name);
  if (!sequence) {
    std::string names;
    for (const Sequence& other : map.sequences) {
      if (other.camera) names += (names.empty() ? "" : ", ") + Quoted(other.name);
    }
    throw MapError(ErrorCode::kBadCamera, "the map has no camera " + Quoted(name) +
                                              (names.empty() ? "; it was built without cameras"
                                                             : "; its cameras are " + names));
  }
  const Camera& camera = *sequence->camera;
  if (camera.width != image.width || camera.height != image.height) {
    throw MapError(ErrorCode::kBadCamera,
                   "the camera " + Quoted(name) + " has " + SizeText(camera.width, camera.height) +
                       " pixels"
                       ", the image has " +
                       SizeText(image.width, image.height) +
                       " pixels"
                       "; send the image unscaled, or send fx, fy, cx and cy");
  }
  return camera;
}

std::span<const uint8_t> BytesOf(const QueryImage& image) {
  return {reinterpret_cast<const uint8_t*>(image.bytes.data()), image.bytes.size()};
}

// Throws MapError(kBadImage).
cv::Size ReadSize(const QueryImage& image) {
  if (!image.grey.empty()) return image.grey.size();
  const ImageHeader header = ReadImageHeader(BytesOf(image));
  return {header.width, header.height};
}

Camera Pinhole(int width, int height, double focal_px) {
  return {CameraModel::kPinhole,
          width,
          height,
          {focal_px, focal_px, (width - 1) / 2.0, (height - 1) / 2.0}};
}

std::optional<QueryCamera> CameraByExif(const QueryImage& image) {
  const std::optional<ExifCamera> exif = ReadExifCamera(BytesOf(image));
  if (!exif) return std::nullopt;
  return QueryCamera{Pinhole(exif->width, exif->height, exif->focal_px), CameraSource::kExif};
}

QueryCamera NamedCamera(const QueryRequest& request, const MapData& map, const cv::Size& size) {
  if (request.stored_camera) {
    return {StoredCamera(map, *request.stored_camera, size), CameraSource::kStored};
  }
  if (request.intrinsics) {
    const Intrinsics& k = *request.intrinsics;
    return {{CameraModel::kPinhole, size.width, size.height, {k.fx, k.fy, k.cx, k.cy}},
            CameraSource::kIntrinsics};
  }
  const double focal_px = size.width / 2.0 / std::tan(*request.fov_rad / 2);
  return {Pinhole(size.width, size.height, focal_px), CameraSource::kFov};
}

}  // namespace

const char* NameOf(CameraSource source) {
  switch (source) {
    case CameraSource::kStored:
      return "stored";
    case CameraSource::kFov:
      return "fov";
    case CameraSource::kIntrinsics:
      return "intrinsics";
    case CameraSource::kExif:
      return "exif";
  }
  WS_CHECK(false, "unknown source of a camera");
}

bool NamesCamera(const QueryRequest& request) {
  return request.intrinsics || request.fov_rad || request.stored_camera;
}

std::optional<QueryCamera> ResolveCamera(const QueryRequest& request, const MapData& map,
                                         const QueryImage& image) {
  if (!NamesCamera(request)) return CameraByExif(image);
  try {
    return NamedCamera(request, map, ReadSize(image));
  } catch (const MapError& error) {
    if (error.code() != ErrorCode::kBadImage) throw;
    return std::nullopt;
  }
}

}  // namespace waystone
