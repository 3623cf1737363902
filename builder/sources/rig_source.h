// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "core/base/options.h"
#include "core/camera/rig.h"
#include "core/image/decode.h"

namespace waystone {

// Reads a rig file, recognising by its keys
//   Kalibr's camchain: cam0, cam1, ... with T_cn_cnm1 (x_cn = T x_cn-1); the rig is cam0
//   our own:
//     cameras:
//       - name: front                        # also its folder or file
//         camera_model: PINHOLE              # and its parameters, as in a camera file
//         ...
//         rig_from_camera_xyzw: [0, 0, 0, 1] # rotation of x_rig = R x_camera + t
//         rig_from_camera_m: [0, 0, 0]       # t; may be left out
//   a camera file of any kind that ReadCameraFile knows: a rig of one.
// Throws MapError(kBadCamera) with the file, the camera and what to do. Thread-safe, as all
// functions here.
Rig ReadRigFile(const std::filesystem::path& path);

// Whether a file describes a rig rather than one camera: Kalibr's with a second camera, or our own
// list. Throws MapError(kBadCamera) for a file that can't be read.
bool HasSeveralCameras(const std::filesystem::path& path);

// One moment of a rig.
struct RigMoment {
  std::string source;  // relative to the sequence: "017", "000012.jpg"
  std::optional<double> time_s;
  std::vector<std::filesystem::path> images;  // one per camera; for a panorama the one image
};

// A rig's images in order.
struct RigSequence {
  std::string
      layout;  // "parallel folders", "numbered folders", "one moment", "images", "panoramas"
  Rig rig;
  std::vector<RigMoment> moments;
};

struct RigOptions {
  // A rig or camera file; wins over rig.yaml and camera.yaml in or beside the folder.
  std::optional<std::filesystem::path> rig_file;
  double max_time_gap_s = 0.02;
  double face_share = 0.25;
  DecodeLimits limits = {};

  static constexpr int kUnlistedMembers = 1;  // rig_file, which is there or not
  static constexpr auto Fields(const auto& use) {
    return use(OptionField{"max_time_gap_s", &RigOptions::max_time_gap_s, Closed(0, 10), "s",
                           "For parallel folders whose files are named by time stamps: images up "
                           "to this far apart belong to one moment. Higher values pair images of "
                           "cameras that aren't triggered together."},
               OptionField{"face_share", &RigOptions::face_share, Closed(0.05, 1), "",
                           "Width of the faces into which a panorama is split, as a share of its "
                           "width. A quarter is as sharp as the panorama at the horizon."},
               OptionGroup{"limits", &RigOptions::limits});
  }
  void Check() const;  // throws MapError(kBadOptions)
};

// Recognises how a folder holds the images of a rig:
//   one folder a camera (FRONT/000.jpg, BACK/000.jpg; also in a folder rig/)   parallel folders, by
//                                      order, or by time where all names are time stamps
//   one folder a moment (000/front.jpg, 000/back.jpg)                          numbered folders
//   one file a camera (front.jpg, back.jpg)                                    one moment
//   images, and a camera                                                       a rig of one
//   images, and an equirectangular camera or none and twice as wide as high    panoramas: six faces
// A single image file is a sequence of one. Without a rig file, folders or files named front,
// right, back, left and perhaps up and down are faces of 90 degrees (CubeRig).
// Throws MapError: kBadOptions; kBadSource for folders of different lengths, a missing image of a
// camera, or none of these layouts; kBadCamera for a rig file that doesn't fit.
RigSequence OpenRigSequence(const std::filesystem::path& path, const RigOptions& options = {});

// The images of a moment, one per camera (CV_8UC1). Throws MapError(kBadImage, kImageTooLarge,
// kFileUnreadable), naming the file, also for an image that doesn't have its camera's size.
std::vector<cv::Mat> ReadMoment(const RigSequence& sequence, const RigMoment& moment,
                                const DecodeLimits& limits = {});

// The faces (f = width / 2) of an equirectangular panorama for CubeRig(width_px), in its order.
std::vector<cv::Mat> FacesOfPanorama(const cv::Mat& panorama, int width_px);

}  // namespace waystone
