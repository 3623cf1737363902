// SPDX-License-Identifier: Apache-2.0
#include "builder/appearance/describe_panorama.h"

#include <string>

#include "builder/frames/shrink.h"
#include "core/base/error.h"
#include "core/image/encode.h"

namespace waystone {
namespace {

constexpr int kSmallestImage_px = 16;

std::vector<uint8_t> SmallPicture(const cv::Mat& grey, const DescribeOptions& options) {
  return EncodePicture(ShrinkToWidth(grey, options.image_width), options.image_quality);
}

bool IsWholeSphere(const Panorama& panorama) {
  return panorama.band == ElevationBand{} && panorama.grey.cols == 2 * panorama.grey.rows;
}

LayerMirror MirrorOf(const cv::Mat& image, const PanoramaOptions& options) {
  return {image.cols,    image.rows, options.columns, options.mirror_band, options.mirror_clockwise,
          options.mirror};
}

void Describe(const Panorama& panorama, const DescribeOptions& options,
              DescribedPanorama& described) {
  described.signature = Signature(panorama, options.signature);
  SignatureOptions of_trajectory = options.signature;
  of_trajectory.rows = options.trajectory_rows;
  described.trajectory_signature = Signature(panorama, of_trajectory);
  described.band = UsedBand(panorama, options.signature);
  if (options.features.max_kept > 0 && IsWholeSphere(panorama)) {
    described.features = ExtractPanoramaFeatures(panorama.grey, options.features.extract);
  }
  if (options.image_width > 0) described.picture = SmallPicture(panorama.grey, options);
}

}  // namespace

void DescribeOptions::Check() const {
  CheckFields("describe", *this);
  panorama.Check();
  signature.Check();
  features.Check();
  SignatureOptions of_trajectory = signature;
  of_trajectory.rows = trajectory_rows;
  of_trajectory.Check();
  if (image_width == 0 || image_width >= kSmallestImage_px) return;
  throw MapError(ErrorCode::kBadOptions, "describe.image_width is " + std::to_string(image_width) +
                                             "; it must be 0 or between 16 and 4096 px");
}

std::unique_ptr<DescribedPanorama> DescribePanorama(const Frame& frame,
                                                    const DescribeOptions& options) {
  auto described = std::make_unique<DescribedPanorama>();
  described->info = frame.info;
  described->error = frame.error;
  if (frame.grey.empty()) return described;
  try {
    Describe(ToPanorama(frame.grey, options.panorama), options, *described);
    if (KindOf(frame.grey, options.panorama) == PanoramaKind::kMirror) {
      described->mirror = MirrorOf(frame.grey, options.panorama);
    }
  } catch (const MapError& error) {
    described->error = error.what();
  }
  return described;
}

}  // namespace waystone
