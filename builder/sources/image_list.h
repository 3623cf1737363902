// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "builder/sources/source.h"

// What folders, globs and the datasets have in common: a list of image files. Functions are
// thread-safe.
namespace waystone {

struct ListedImage {
  std::filesystem::path path;  // relative to the root of its list
  std::optional<double> time_s;
};

struct ImageList {
  std::string kind;   // Source::kind()
  std::string title;  // start of the announcement: "TUM sequence"
  std::string name;   // Source::name()
  std::filesystem::path root;
  std::vector<ListedImage> images;
  // Reads the source's own calibration, where it has one and no other is given. A width and height
  // of 0 mean those of the images.
  std::function<Camera()> own_camera;
};

// Opens the part of the list that the options select. Throws MapError(kBadSource) when none of it
// can be read, and kBadCamera when the camera is for images of another size.
std::unique_ptr<Source> OpenImageList(ImageList list, const SourceOptions& options);

// Frame numbers that the options select from a source of `frames` frames, for all kinds of source.
// Throws MapError(kBadSource) when that is none; `path` is for the message.
struct FrameRange {
  int first = 0;
  int last = 0;  // inclusive
  int every = 1;

  int size() const { return (last - first) / every + 1; }
};
FrameRange RangeOf(const SourceOptions& options, int frames, const std::string& path);

// ", 100 used" or nothing.
std::string UsedPart(int used, int frames);

// Throws MapError(kBadCamera) unless the camera's images are of this size.
void CheckCameraSize(const Camera& camera, int width, int height, const std::string& path);

}  // namespace waystone
