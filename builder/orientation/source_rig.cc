// SPDX-License-Identifier: Apache-2.0
#include "builder/orientation/source_rig.h"

#include <algorithm>

#include "builder/sources/rig_source.h"

namespace waystone {

std::vector<cv::Mat> SourceRig::SplitIntoFaces(const std::vector<cv::Mat>& images) const {
  return panorama ? FacesOfPanorama(images.front(), rig.cameras.front().camera.width) : images;
}

std::optional<SourceRig> FindSourceRig(const Source& source) {
  constexpr int kFaceShare = 4;
  if (const std::optional<Rig> faces = source.faces()) return SourceRig{.rig = *faces};
  const std::optional<Camera>& camera = source.camera();
  const cv::Size size = camera ? cv::Size(camera->width, camera->height) : source.frame_size();
  const bool panorama = camera ? camera->model == CameraModel::kEquirectangular
                               : size.height > 0 && size.width == 2 * size.height;
  if (panorama) {
    return SourceRig{.rig = CubeRig(std::max(1, size.width / kFaceShare)), .panorama = true};
  }
  if (camera) return SourceRig{.rig = RigOfOne(*camera)};
  return std::nullopt;
}

}  // namespace waystone
