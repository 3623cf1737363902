// SPDX-License-Identifier: Apache-2.0
#include "builder/sources/rig_source.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "builder/sources/files.h"
#include "builder/sources/recognise.h"
#include "builder/sources/rig_layouts.h"
#include "builder/sources/source.h"
#include "core/base/error.h"
#include "core/camera/cube_faces.h"

namespace waystone {
namespace {

namespace fs = std::filesystem;

constexpr const char* kRigFile = "rig.yaml";

// The first of these files that exists.
std::optional<fs::path> FirstThere(const std::vector<fs::path>& files) {
  std::error_code ignored;
  for (const fs::path& file : files) {
    if (fs::is_regular_file(file, ignored)) return file;
  }
  return std::nullopt;
}

// The camera of the images in a folder: beside them, or beside images/.
std::optional<Rig> CameraBeside(const fs::path& folder, const RigOptions& options) {
  if (options.rig_file) return ReadRigFile(*options.rig_file);
  std::vector<fs::path> files{folder / kCameraFile};
  if (NameOfPath(folder) == "images") files.push_back(folder / ".." / kCameraFile);
  const auto file = FirstThere(files);
  return file ? std::optional(ReadRigFile(*file)) : std::nullopt;
}

ImageHeader ReadFileHeader(const fs::path& path, const DecodeLimits& limits) {
  try {
    ImageHeader header = ReadImageHeader(ReadImageFile(path, limits, ErrorCode::kFileUnreadable));
    CheckLimits(header, limits);
    return header;
  } catch (const MapError& error) {
    throw MapError(error.code(), Quoted(path) + ": " + error.what());
  }
}

// The faces that a folder's names stand for, in CubeRig's order.
std::optional<Rig> FacesByName(const std::vector<std::string>& names, int width_px) {
  Rig rig = CubeRig(width_px);
  const auto has = [&](const std::string& name) {
    return std::ranges::find(names, name) != names.end();
  };
  for (int i = 0; i < kSideFaces; ++i) {
    if (!has(rig.cameras[i].name)) return std::nullopt;
  }
  std::erase_if(rig.cameras, [&](const RigCamera& camera) { return !has(camera.name); });
  return rig;
}

[[noreturn]] void RefuseWithoutRig(const fs::path& path) {
  throw MapError(ErrorCode::kBadSource,
                 Quoted(path) +
                     " has no calibration; provide a rig or camera file with --camera, "
                     "or add rig.yaml or camera.yaml to it");
}

bool IsPanorama(const Rig& rig) {
  return rig.cameras.size() == 1 && rig.cameras[0].camera.model == CameraModel::kEquirectangular;
}

// A list of images: panoramas become faces, others need their one camera.
RigSequence FromImages(const fs::path& path, std::vector<RigMoment> moments,
                       const std::optional<Rig>& given, const RigOptions& options) {
  const ImageHeader first = ReadFileHeader(moments.front().images.front(), options.limits);
  RigSequence sequence{.layout = "images", .rig = {}, .moments = std::move(moments)};
  if (given ? IsPanorama(*given) : first.width == 2 * first.height) {
    sequence.layout = "panoramas";
    sequence.rig = CubeRig(std::max(1, static_cast<int>(options.face_share * first.width)));
    return sequence;
  }
  if (!given) RefuseWithoutRig(path);
  if (given->cameras.size() != 1) {
    throw MapError(ErrorCode::kBadSource,
                   Quoted(path) + " has images of one camera, but the rig file has " +
                       std::to_string(given->cameras.size()) +
                       "; expected a folder with one subfolder or file per camera");
  }
  sequence.rig = *given;
  return sequence;
}

RigSequence FromCameras(const fs::path& path, const CameraImages& found,
                        const std::optional<Rig>& given, const RigOptions& options) {
  RigSequence sequence{.layout = found.layout, .rig = {}, .moments = {}};
  if (given) {
    sequence.rig = *given;
  } else {
    const int width = ReadFileHeader(found.images.front().front().path, options.limits).width;
    auto faces = FacesByName(found.cameras, width);
    if (!faces) RefuseWithoutRig(path);
    sequence.rig = *faces;
  }
  sequence.moments = GroupMoments(found, sequence.rig, path, options.max_time_gap_s);
  return sequence;
}

RigSequence OpenFolder(const fs::path& folder, const RigOptions& options) {
  const std::optional<Rig> rig = RigOfFolder(folder, options.rig_file);
  std::vector<std::string> names;
  for (const RigCamera& camera : (rig ? *rig : CubeRig(1)).cameras) names.push_back(camera.name);
  if (!rig || rig->cameras.size() > 1) {
    if (const auto found = FindCameraImages(folder, names)) {
      return FromCameras(folder, *found, rig, options);
    }
  }
  std::vector<RigMoment> moments = ListMoments(folder);
  if (moments.empty()) {
    throw MapError(ErrorCode::kBadSource,
                   "no rig images in " + Quoted(folder) +
                       "; expected one subfolder or file per camera, or images");
  }
  const std::optional<Rig> camera = CameraBeside(folder, options);
  return FromImages(folder, std::move(moments), camera, options);
}

cv::Mat ReadGrey(const fs::path& path, const DecodeLimits& limits) {
  try {
    return DecodeGrey(ReadImageFile(path, limits, ErrorCode::kFileUnreadable), limits);
  } catch (const MapError& error) {
    throw MapError(error.code(), Quoted(path) + ": " + error.what());
  }
}

}  // namespace

std::optional<Rig> RigOfFolder(const fs::path& folder, const std::optional<fs::path>& rig_file) {
  if (rig_file) return ReadRigFile(*rig_file);
  const auto file = FirstThere({folder / kRigFile, folder / ".." / kRigFile});
  return file ? std::optional(ReadRigFile(*file)) : std::nullopt;
}

void RigOptions::Check() const { CheckFields("rig", *this); }

RigSequence OpenRigSequence(const fs::path& path, const RigOptions& options) {
  options.Check();
  std::error_code ignored;
  if (fs::is_directory(path, ignored)) return OpenFolder(path, options);
  if (!fs::is_regular_file(path, ignored)) {
    throw MapError(ErrorCode::kBadSource, Quoted(path) + " does not exist; check the path");
  }
  const fs::path folder = path.has_parent_path() ? path.parent_path() : fs::path(".");
  const std::optional<Rig> given = CameraBeside(folder, options);
  return FromImages(path, {{.source = path.filename().string(), .time_s = {}, .images = {path}}},
                    given, options);
}

std::vector<cv::Mat> FacesOfPanorama(const cv::Mat& panorama, int width_px) {
  std::vector<cv::Mat> faces;
  for (int face = 0; face < kCubeFaces; ++face) {
    faces.push_back(FaceOf(panorama, static_cast<CubeFace>(face), width_px));
  }
  return faces;
}

std::vector<cv::Mat> ReadMoment(const RigSequence& sequence, const RigMoment& moment,
                                const DecodeLimits& limits) {
  std::vector<cv::Mat> images;
  if (sequence.layout == "panoramas") {
    const cv::Mat panorama = ReadGrey(moment.images.front(), limits);
    if (panorama.cols != 2 * panorama.rows) {
      throw MapError(ErrorCode::kBadImage, Quoted(moment.images.front()) + " has " +
                                               std::to_string(panorama.cols) + "x" +
                                               std::to_string(panorama.rows) +
                                               " pixels; a panorama is twice as wide as high");
    }
    return FacesOfPanorama(panorama, sequence.rig.cameras.front().camera.width);
  }
  for (size_t i = 0; i < moment.images.size(); ++i) {
    images.push_back(ReadGrey(moment.images[i], limits));
    try {
      CheckImageSize(sequence.rig.cameras[i], images.back().cols, images.back().rows);
    } catch (const MapError& error) {
      throw MapError(error.code(), Quoted(moment.images[i]) + ": " + error.what());
    }
  }
  return images;
}

}  // namespace waystone
