// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <span>

namespace waystone {

// What a photo's EXIF data says about the camera.
struct ExifCamera {
  int width = 0;        // px, of the image itself
  int height = 0;       // px
  double focal_px = 0;  // of a camera without distortion, pixels of this image
};

// Reads a JPEG's, WebP's or HEIC's 35 mm equivalent focal length (tag FocalLengthIn35mmFilm), which
// stands for the diagonal of 24 x 36 mm whatever the sensor's shape. Looks only at the segments
// before a JPEG's image data: a photo takes microseconds. Nothing for other formats, for photos
// without the tag or with a value outside 3 to 3000 mm, for damaged data, and for a photo that was
// cropped or turned after it was taken: its shape isn't the one in the EXIF data. Never throws,
// never reads outside `bytes`. Thread-safe.
std::optional<ExifCamera> ReadExifCamera(std::span<const uint8_t> bytes);

// How a JPEG, WebP or HEIC is to be turned or mirrored for display: the tag Orientation, 1 to 8; 1
// (leave as it is) where it is missing or invalid. Never throws, never reads outside `bytes`.
// Thread-safe.
int ReadExifOrientation(std::span<const uint8_t> bytes);

}  // namespace waystone
