// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include "core/image/decode.h"
#include "core/image/exif.h"
#include "tests/fuzz/fuzz_targets.h"

namespace waystone {

// A camera is sound, and of the size that the image's header has.
bool FuzzExif(FuzzInput input) {
  const auto camera = ReadExifCamera(input);
  if (!camera) return false;
  Require(camera->width > 0 && camera->height > 0, "a camera has a size");
  const double diagonals = camera->focal_px / std::hypot(camera->width, camera->height);
  Require(diagonals > 3 / 43.3 && diagonals < 3000 / 43.2, "a focal length is of 3 to 3000 mm");
  const auto header = ReadOrRefuse([&] { return ReadImageHeader(input); });
  Require(!header || (header->width == camera->width && header->height == camera->height),
          "the camera has the image's size");
  return true;
}

}  // namespace waystone
