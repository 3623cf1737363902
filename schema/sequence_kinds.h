// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <string_view>

namespace waystone {

// What a sequence's images are, as a map stores it (FORMAT.md).
inline constexpr const char* kFolderKind = "folder";    // a list of images
inline constexpr const char* kVideoKind = "video";      // a video file
inline constexpr const char* kTumKind = "tum";          // a TUM RGB-D sequence
inline constexpr const char* kKittiKind = "kitti";      // a KITTI odometry sequence
inline constexpr const char* kEurocKind = "euroc";      // a EuRoC sequence
inline constexpr const char* kRigKind = "rig";          // panoramas joined from a rig's images
inline constexpr const char* kCamerasKind = "cameras";  // images of the first of several cameras

inline constexpr std::array<std::string_view, 7> kSequenceKinds{
    kFolderKind, kVideoKind, kTumKind, kKittiKind, kEurocKind, kRigKind, kCamerasKind};

}  // namespace waystone
