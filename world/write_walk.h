// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>

#include "core/base/options.h"
#include "core/camera/camera.h"
#include "world/render.h"
#include "world/rig.h"
#include "world/walk.h"
#include "world/world.h"

namespace waystone {

struct WriteWalkOptions {
  bool pinhole = true;
  bool rig = false;
  bool panorama = false;
  // The pinhole camera; without distortion.
  Camera camera = PinholeCamera(640, 480, 1.1);
  int rig_width_px = 320;
  int panorama_width_px = 1024;
  // "jpg" or "png".
  std::string format = "jpg";
  int jpeg_quality = 95;
  bool plane_ids = true;
  // Lens, noise and exposure. Each frame's noise has its own seed, derived from noise_seed and the
  // frame's number; motion comes from the walk.
  RenderOptions render;
  double shutter = 0.5;
  double exposure_swing = 0.0;

  static constexpr auto Fields(const auto& use) {
    return use(
        OptionField{"pinhole", &WriteWalkOptions::pinhole, AnyValue(), "",
                    "Write the images of a pinhole camera."},
        OptionField{"rig", &WriteWalkOptions::rig, AnyValue(), "",
                    "Write the images of the rig of six faces."},
        OptionField{"panorama", &WriteWalkOptions::panorama, AnyValue(), "",
                    "Write equirectangular panoramas."},
        OptionField{"rig_width_px", &WriteWalkOptions::rig_width_px, AtLeast(1), "px",
                    "Width of a rig's face."},
        OptionField{"panorama_width_px", &WriteWalkOptions::panorama_width_px, AtLeast(1), "px",
                    "Width of a panorama."},
        OptionField{"jpeg_quality", &WriteWalkOptions::jpeg_quality, Closed(1, 100), "",
                    "JPEG quality. Higher values take more bytes."},
        OptionField{"plane_ids", &WriteWalkOptions::plane_ids, AnyValue(), "",
                    "Write the plane id of every pixel of the pinhole images (16-bit PNG)."},
        OptionGroup{"render", &WriteWalkOptions::render},
        OptionField{"shutter", &WriteWalkOptions::shutter, Closed(0, 1), "",
                    "Share of the time between two frames for which the shutter is open; takes "
                    "effect only with render.motion_samples above 1."},
        OptionField{"exposure_swing", &WriteWalkOptions::exposure_swing, Closed(0, 3), "",
                    "The exposure swings slowly between 1 / (1 + x) and 1 + x; 0 is constant."});
  }
  // Throws MapError(kBadOptions) for a value out of its range.
  void Check() const;
};

// Called with the number of frames done so far and the total, by one thread at a time.
using WriteProgress = std::function<void(int done, int total)>;

// The options for rendering frame `frame` of a walk. Pure; thread-safe.
RenderOptions FrameRenderOptions(const Walk& walk, int frame, const WriteWalkOptions& options);

// Writes a walk and its truth into `dir`, which is made if it isn't there and must be empty:
//
//   README.txt           what each file is
//   plan.txt             the floor plan
//   poses.csv            frame,time_s,x,y,z,qx,qy,qz,qw: world_from_camera
//   planes.csv           id,kind,x,y,z,nx,ny,nz: a point and the normal
//   adjacency.csv        plane,neighbour
//   camera.yaml          the pinhole camera
//   images/000000.jpg    its pictures
//   plane_ids/000000.png the plane each pixel shows
//   visible.csv          frame,plane,pixels
//   rig/front/000000.jpg ..., rig.yaml, panorama/000000.jpg
//
// Frames are rendered in parallel (TBB); the files are the same on any number of threads. Throws
// MapError: kBadOptions, kFileExists for a folder that isn't empty, kFileUnwritable.
void WriteWalk(const World& world, const Walk& walk, const std::filesystem::path& dir,
               const WriteWalkOptions& options = {}, const WriteProgress& progress = {});

}  // namespace waystone
