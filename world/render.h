// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

#include "core/base/options.h"
#include "core/camera/camera.h"
#include "world/world.h"

namespace waystone {

// Effects of a real camera on the picture. The truth (ids, depth) stays sharp.
struct RenderOptions {
  double lens_blur_px = 0.0;
  double noise_sigma = 0.0;
  uint64_t noise_seed = 0;
  double exposure_gain = 1.0;
  // How the camera moves while the shutter is open: x_open = motion x_close, camera frame. The
  // requested pose is the one in the middle.
  Eigen::Isometry3d motion = Eigen::Isometry3d::Identity();
  int motion_samples = 1;
  int edge_rays = 2;
  // Whether to return the depth too.
  bool depth = false;

  static constexpr auto Fields(const auto& use) {
    return use(OptionField{"lens_blur_px", &RenderOptions::lens_blur_px, Closed(0, 20), "px",
                           "Standard deviation of the lens blur; 0 is a perfect lens."},
               OptionField{
                   "noise_sigma", &RenderOptions::noise_sigma, Closed(0, 100), "grey levels",
                   "Standard deviation of the sensor noise, which is independent for every pixel."},
               OptionField{"noise_seed", &RenderOptions::noise_seed, AnyValue(), "",
                           "Random seed of the noise; use a different one for every frame."},
               OptionField{"exposure_gain", &RenderOptions::exposure_gain, Closed(0.05, 20), "",
                           "Factor applied to the light; values are clipped at 255."},
               OptionField{"motion_samples", &RenderOptions::motion_samples, Closed(1, 64), "",
                           "Number of images averaged over the motion, each of which costs as much "
                           "as a frame. 1 gives no motion blur."},
               OptionField{"edge_rays", &RenderOptions::edge_rays, Closed(1, 8), "",
                           "Number of rays along each side of a pixel where two surfaces meet; 1 "
                           "leaves jagged edges, 2 costs a few percent."});
  }
  // Throws MapError(kBadOptions) for a value out of its range.
  void Check() const;
};

// A share of a motion: 0 is none of it, 1 all of it; negative shares go the other way. Pure;
// thread-safe.
Eigen::Isometry3d PartOfMotion(const Eigen::Isometry3d& motion, double share);

struct RenderedFrame {
  cv::Mat grey;       // CV_8UC1
  cv::Mat plane_ids;  // CV_16UC1, the plane at each pixel's centre
  cv::Mat face_ids;   // CV_16UC1, the face at each pixel's centre
  cv::Mat depth;      // CV_32FC1, metres along the optical axis (from the centre for an
                      // equirectangular camera); empty unless asked for
};

// Renders for one camera, of any model. Computes the camera's rays once; immutable, so any number
// of threads may render with one renderer. A frame is rendered on the calling thread only and is
// the same on any thread.
class Renderer {
 public:
  // Throws MapError(kBadCamera) for an invalid camera (CheckCamera).
  explicit Renderer(const Camera& camera);

  const Camera& camera() const { return camera_; }

  // World frame: x east, y north, z up, metres. Camera frame: x right, y down, z forward. The pose
  // must lie inside the world (World::IsInside) or a CheckFailure is thrown; motion blur leaves out
  // what lies outside. Throws MapError(kBadOptions) for bad options.
  RenderedFrame Render(const World& world, const Eigen::Isometry3d& world_from_camera,
                       const RenderOptions& options = {}) const;

 private:
  class Pass;
  // The mean of the pictures along the options' motion.
  cv::Mat MeanLight(const World& world, const Eigen::Isometry3d& world_from_camera,
                    const RenderOptions& options) const;

  Camera camera_;
  std::vector<Eigen::Vector3f> rays_;  // unit, camera frame, row-major
  std::vector<float> cones_rad_;       // angle between neighbouring rays
};

// The same for a single frame. Thread-safe.
RenderedFrame Render(const World& world, const Camera& camera,
                     const Eigen::Isometry3d& world_from_camera, const RenderOptions& options = {});

}  // namespace waystone
