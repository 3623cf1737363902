// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>

#include "core/camera/camera.h"
#include "world/render.h"
#include "world/rig.h"
#include "world/walk.h"
#include "world/world.h"

namespace waystone {

struct WriteWalkOptions {
  // Which pictures are written: one pinhole camera, the six-face rig, the panorama.
  bool pinhole = true;
  bool rig = false;
  bool panorama = false;
  // The pinhole camera; without distortion.
  Camera camera = PinholeCamera(640, 480, 1.1);
  // Width of a rig's face, and of the panorama, px.
  int rig_width_px = 320;
  int panorama_width_px = 1024;
  // "jpg" or "png".
  std::string format = "jpg";
  // JPEG quality, 1 to 100.
  int jpeg_quality = 95;
  // Whether to write the plane id of every pixel of the pinhole pictures (16 bit PNG).
  bool plane_ids = true;
  // Lens, noise and exposure. Each frame's noise has a seed of its own, made from noise_seed and
  // the frame's number; motion comes from the walk.
  RenderOptions render;
  // Part of the time between two frames that the shutter is open, 0 to 1; it counts only with
  // render.motion_samples above 1.
  double shutter = 0.5;
  // The exposure swings slowly between 1 / (1 + x) and 1 + x, 0 to 3; 0 is constant.
  double exposure_swing = 0.0;

  // Throws MapError(kBadOptions) for a value out of its range.
  void Check() const;
};

// Called with the frames done so far and their number, by one thread at a time.
using WriteProgress = std::function<void(int done, int total)>;

// The options that frame `frame` of a walk is rendered with.
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
