// SPDX-License-Identifier: Apache-2.0
#include "builder/orientation/view.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "core/base/error.h"

namespace waystone {
namespace {

cv::Mat Thumbnail(const cv::Mat& grey, int width) {
  if (width == 0 || grey.empty() || grey.cols <= width) return width == 0 ? cv::Mat() : grey;
  const double height = static_cast<double>(grey.rows) * width / grey.cols;
  cv::Mat small;
  cv::resize(grey, small, {width, std::max(1, static_cast<int>(std::lround(height)))}, 0, 0,
             cv::INTER_AREA);
  return small;
}

}  // namespace

OrientationSequence SequenceOf(SequenceId id, RigSequence sequence) {
  const auto shared = std::make_shared<const RigSequence>(std::move(sequence));
  const auto next = [shared, i = 0]() mutable -> std::optional<OrientationMoment> {
    if (i == static_cast<int>(shared->moments.size())) return std::nullopt;
    const RigMoment& moment = shared->moments[i];
    return OrientationMoment{.info = {i++, moment.source, moment.time_s},
                             .load = [shared, &moment] { return ReadMoment(*shared, moment); }};
  };
  return {.id = id, .rig = shared->rig, .next = next};
}

std::vector<cv::Mat> SourceRig::ImagesOf(const std::vector<cv::Mat>& loaded) const {
  return panorama ? FacesOfPanorama(loaded.front(), rig.cameras.front().camera.width) : loaded;
}

std::optional<SourceRig> RigOfSource(const Source& source) {
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

OrientationSequence SequenceOf(SequenceId id, Source& source) {
  const std::optional<SourceRig> head = RigOfSource(source);
  if (!head) {
    throw MapError(
        ErrorCode::kBadCamera,
        source.name() + " has no camera, which the orientation layer requires; use --camera");
  }
  const auto next = [&source, head]() -> std::optional<OrientationMoment> {
    std::optional<EncodedFrame> encoded = source.NextEncoded();
    if (!encoded) return std::nullopt;
    const FrameInfo info = encoded->info();
    return OrientationMoment{.info = info, .load = [frame = std::move(*encoded), head] {
                               return head->ImagesOf(frame.Load());
                             }};
  };
  return {.id = id, .rig = head->rig, .next = next};
}

OrientationView LookAt(const Rig& rig, const FrameInfo& info, std::span<const cv::Mat> images,
                       const OrientationOptions& options) {
  OrientationView view;
  view.info = info;
  for (size_t c = 0; c < images.size(); ++c) {
    CheckImageSize(rig.cameras[c], images[c].cols, images[c].rows);
    const auto found = GreatCirclesOf(rig, static_cast<int>(c),
                                      DetectSegments(images[c], options.segments), options.circles);
    view.lines.insert(view.lines.end(), found.begin(), found.end());
  }
  view.frame = FindManhattanFrame(view.lines, options.manhattan);
  view.features = ExtractBearings(rig, images, options.bearings);
  view.thumbnail = Thumbnail(images[0], options.image_width);
  return view;
}

OrientationView LookAt(const Rig& rig, const OrientationMoment& moment,
                       const OrientationOptions& options) {
  try {
    return LookAt(rig, moment.info, moment.load(), options);
  } catch (const MapError& error) {
    OrientationView view;
    view.info = moment.info;
    view.error = error.what();
    return view;
  }
}

}  // namespace waystone
