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

std::vector<cv::Mat> Decoded(const EncodedFrame& encoded) {
  const Frame frame = encoded.Decode();
  if (frame.grey.empty()) throw MapError(ErrorCode::kBadImage, frame.error);
  return {frame.grey};
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

OrientationSequence SequenceOf(SequenceId id, Source& source) {
  if (!source.camera()) {
    throw MapError(
        ErrorCode::kBadCamera,
        source.name() + " has no camera; the orientation layer needs one, give --camera");
  }
  const bool panorama = source.camera()->model == CameraModel::kEquirectangular;
  const int face_px = std::max(1, source.camera()->width / 4);
  const auto next = [&source, panorama, face_px]() -> std::optional<OrientationMoment> {
    std::optional<EncodedFrame> encoded = source.NextEncoded();
    if (!encoded) return std::nullopt;
    const FrameInfo info = encoded->info();
    return OrientationMoment{.info = info,
                             .load = [frame = std::move(*encoded), panorama, face_px] {
                               std::vector<cv::Mat> images = Decoded(frame);
                               return panorama ? FacesOfPanorama(images[0], face_px) : images;
                             }};
  };
  return {.id = id, .rig = panorama ? CubeRig(face_px) : RigOfOne(*source.camera()), .next = next};
}

OrientationView LookAt(const Rig& rig, const OrientationMoment& moment,
                       const OrientationOptions& options) {
  OrientationView view;
  view.info = moment.info;
  try {
    const std::vector<cv::Mat> images = moment.load();
    for (size_t c = 0; c < images.size(); ++c) {
      CheckImageSize(rig.cameras[c], images[c].cols, images[c].rows);
      const auto found = GreatCirclesOf(
          rig, static_cast<int>(c), DetectSegments(images[c], options.segments), options.circles);
      view.lines.insert(view.lines.end(), found.begin(), found.end());
    }
    view.frame = FindManhattanFrame(view.lines, options.manhattan);
    view.features = ExtractBearings(rig, images, options.bearings);
    view.thumbnail = Thumbnail(images[0], options.image_width);
  } catch (const MapError& error) {
    view = OrientationView();
    view.info = moment.info;
    view.error = error.what();
  }
  return view;
}

}  // namespace waystone
