// SPDX-License-Identifier: Apache-2.0
#include <opencv2/imgcodecs.hpp>

#include "core/image/decode.h"
#include "tests/fuzz/fuzz_targets.h"

namespace waystone {
namespace {

// Small enough to be decoded ten thousand times.
constexpr DecodeLimits kSmallImages{.max_pixels = 1 << 17,
                                    .max_scans = 12,
                                    .max_scan_pixels = 1 << 19,
                                    .max_decode_bytes = 1 << 20,
                                    .max_inflated_bytes = 1 << 20,
                                    .max_hevc_bytes = 1 << 14};

// What libjpeg, libpng and OpenCV's own decoders make of the bytes; empty where they refuse.
cv::Mat DecodeByLibrary(FuzzInput input) {
  try {
    const cv::Mat encoded(1, static_cast<int>(input.size()), CV_8UC1,
                          const_cast<uint8_t*>(input.data()));
    return cv::imdecode(encoded, cv::IMREAD_GRAYSCALE | cv::IMREAD_IGNORE_ORIENTATION);
  } catch (const cv::Exception&) {
    return {};
  }
}

}  // namespace

// The header read by us and the image decoded by the libraries have one size, so that limits are
// those of what is decoded; what is decoded is what the library decoded.
bool FuzzImage(FuzzInput input) {
  const auto header = ReadOrRefuse([&] { return ReadImageHeader(input); });
  const auto grey = ReadOrRefuse([&] { return DecodeGrey(input, kSmallImages); });
  if (!header) {
    Require(!grey, "what has no header isn't decoded");
    return false;
  }
  Require(header->width > 0 && header->height > 0 && header->scans > 0, "a header has a size");
  const bool within = ReadOrRefuse([&] {
                        CheckLimits(*header, kSmallImages);
                        return true;
                      }).has_value();
  Require(within || !grey, "what is over the limits isn't decoded");
  if (!within) return false;
  const cv::Mat by_library = DecodeByLibrary(input);
  const cv::Size size(header->width, header->height);
  Require(by_library.empty() || by_library.size() == size,
          "header and decoder agree on the size of a " + header->format);
  if (!grey) return false;
  Require(grey->type() == CV_8UC1 && grey->size() == size, "a decoded image is as its header says");
  // Of these the library is given the picture alone, whatever is beside it.
  const bool picture_alone = header->format == "webp" || header->format == "heic";
  Require(picture_alone || !by_library.empty(), "what we decode the library decodes");
  return true;
}

}  // namespace waystone
