// SPDX-License-Identifier: Apache-2.0
#include "builder/orientation/view.h"

#include "builder/frames/shrink.h"

namespace waystone {

std::unique_ptr<OrientationView> ObserveOrientation(const Rig& rig, const FrameInfo& info,
                                                    std::span<const cv::Mat> images,
                                                    const OrientationOptions& options) {
  auto view = std::make_unique<OrientationView>();
  view->info = info;
  for (size_t c = 0; c < images.size(); ++c) {
    CheckImageSize(rig.cameras[c], images[c].cols, images[c].rows);
    const auto found = FindGreatCircles(
        rig, static_cast<int>(c), DetectSegments(images[c], options.segments), options.circles);
    view->lines.insert(view->lines.end(), found.begin(), found.end());
  }
  view->frame = FindManhattanFrame(view->lines, options.manhattan);
  view->features = ExtractBearings(rig, images, options.bearings);
  if (options.image_width > 0) view->thumbnail = ShrinkToWidth(images[0], options.image_width);
  return view;
}

}  // namespace waystone
