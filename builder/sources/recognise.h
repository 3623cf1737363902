// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "builder/sources/image_list.h"

// One function a kind of source: inside builder/sources only.
namespace waystone {

// Each gives nothing for a folder that isn't laid out as its dataset, and throws
// MapError(kBadSource), with file and line, for one that is but whose lists can't be understood.
std::optional<ImageList> RecogniseTum(const std::filesystem::path& folder);
std::optional<ImageList> RecogniseKitti(const std::filesystem::path& folder);
std::optional<ImageList> RecogniseEuroc(const std::filesystem::path& folder);

// A folder with the faces of a rig (front, right, back, left and perhaps up and down), a folder a
// moment or a folder a face, as panoramas; nothing for another folder. Throws MapError(kBadSource)
// when a face is missing somewhere.
std::unique_ptr<Source> RecogniseRigPanoramas(const std::filesystem::path& folder,
                                              const SourceOptions& options);

// A folder with the images of a calibrated rig: rig.yaml in or beside it, or options.camera_file
// with several cameras, and a folder or file called like each. Nothing for another folder, and for
// rigs of 90 degree faces, which see panoramas. Throws MapError(kBadCamera, kBadSource) for a rig
// file that can't be read, images that lack a partner, and a camera without images.
std::unique_ptr<Source> RecogniseCameraRig(const std::filesystem::path& folder,
                                           const SourceOptions& options);

// The images in a folder, or of a pattern. Throw MapError(kBadSource) when there are none.
ImageList ListFolder(const std::filesystem::path& folder);
ImageList ListPattern(const std::string& pattern);
bool HasWildcard(const std::string& path);

// Throws MapError(kBadSource) when FFmpeg gives no frame of it.
std::unique_ptr<Source> OpenVideo(const std::filesystem::path& path, const SourceOptions& options);

// The last part of a path, also of "walk/", "." and "..".
std::string NameOfPath(const std::filesystem::path& path);

// Reads a camera file where there is one, for ImageList::own_camera; empty where there is none.
std::function<Camera()> CameraFileIfThere(const std::filesystem::path& path);

}  // namespace waystone
