// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "builder/sources/image_list.h"

// One function per kind of source: internal to builder/sources. All are thread-safe but ListPattern
// (glob(3) isn't).
namespace waystone {

// Each returns nothing for a folder that isn't laid out as its dataset, and throws
// MapError(kBadSource), with file and line, for one that is but whose lists can't be parsed.
std::optional<ImageList> RecogniseTum(const std::filesystem::path& folder);
std::optional<ImageList> RecogniseKitti(const std::filesystem::path& folder);
std::optional<ImageList> RecogniseEuroc(const std::filesystem::path& folder);

// A folder with the faces of a rig (front, right, back, left and perhaps up and down), with one
// folder per moment or per face, as panoramas; nothing for another folder. Throws
// MapError(kBadSource) when a face is missing somewhere.
std::unique_ptr<Source> RecogniseRigPanoramas(const std::filesystem::path& folder,
                                              const SourceOptions& options);

// A folder with the images of a calibrated rig: rig.yaml in or beside it, or options.camera_file
// with several cameras, and a folder or file named after each. Nothing for other folders, and for
// rigs of 90 degree faces, which give panoramas. Throws MapError(kBadCamera, kBadSource) for a rig
// file that can't be read, images that lack a partner, and a camera without images.
std::unique_ptr<Source> RecogniseCameraRig(const std::filesystem::path& folder,
                                           const SourceOptions& options);

// The images in a folder, or of a pattern. Throw MapError(kBadSource) when there are none.
ImageList ListFolder(const std::filesystem::path& folder);
ImageList ListPattern(const std::string& pattern);
bool HasWildcard(const std::string& path);

// Throws MapError(kBadSource) when FFmpeg can't decode a frame.
std::unique_ptr<Source> OpenVideo(const std::filesystem::path& path, const SourceOptions& options);

// The last part of a path, also for "walk/", "." and "..".
std::string NameOfPath(const std::filesystem::path& path);

// Reads a camera file where there is one, for ImageList::own_camera; empty where there is none.
std::function<Camera()> CameraFileIfThere(const std::filesystem::path& path);

}  // namespace waystone
