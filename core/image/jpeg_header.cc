// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <vector>

#include "core/base/error.h"
#include "core/image/formats.h"

namespace waystone {
namespace {

enum Marker : int {
  kProgressive = 0xC2,
  kFirstFrame = 0xC0,  // SOF0 to SOF15, except the three below
  kHuffmanTables = 0xC4,
  kReservedFrame = 0xC8,
  kArithmeticTables = 0xCC,
  kLastFrame = 0xCF,
  kFirstRestart = 0xD0,
  kLastRestart = 0xD7,
  kStart = 0xD8,
  kEnd = 0xD9,
  kScan = 0xDA,
  kQuantisation = 0xDB,
  kLineCount = 0xDC,
  kRestartInterval = 0xDD,
  kFirstApplication = 0xE0,
  kLastApplication = 0xEF,
  kComment = 0xFE,
};

bool IsFrame(int marker) {
  return marker >= kFirstFrame && marker <= kLastFrame && marker != kHuffmanTables &&
         marker != kReservedFrame && marker != kArithmeticTables;
}

// Baseline, extended and progressive with Huffman coding: what cameras and browsers write. libjpeg
// decodes arithmetic coding (0xC9, 0xCA) as well, ten times as slowly.
bool IsDecodable(int frame) { return frame <= kProgressive; }

bool IsOtherSegment(int marker) {
  return marker == kHuffmanTables || marker == kArithmeticTables || marker == kQuantisation ||
         marker == kLineCount || marker == kRestartInterval || marker == kComment ||
         (marker >= kFirstApplication && marker <= kLastApplication);
}

// Walks the segments as libjpeg does, so that what is counted here is what is decoded there.
// Thumbnails are images of their own, but inside a segment, so they are stepped over with it.
class JpegWalk {
 public:
  explicit JpegWalk(Bytes bytes) : bytes_(bytes) {}

  ImageHeader Read() {
    for (;;) {
      const int marker = NextMarker();
      if (marker == kEnd) return Finish();
      if (marker == kStart) RefuseImage("the JPEG has a second start marker; it is damaged");
      const Bytes segment = TakeSegment();
      if (IsFrame(marker)) {
        ReadFrame(marker, segment);
      } else if (marker == kScan) {
        ++header_.scans;
        scan_components_ = segment.empty() ? 0 : segment[0];
      } else if (!IsOtherSegment(marker)) {
        // libjpeg gives up on these too, or skips them without their length, which could hide data.
        RefuseImage("the JPEG has an unknown segment " + std::to_string(marker) +
                    "; it is damaged");
      }
    }
  }

 private:
  // Coded data, stuffed zeros, restart markers and fill bytes all lie between markers.
  int NextMarker() {
    for (;;) {
      while (position_ < bytes_.size() && bytes_[position_] != 0xFF) ++position_;
      while (position_ < bytes_.size() && bytes_[position_] == 0xFF) ++position_;
      if (position_ >= bytes_.size()) RefuseCutOff("JPEG", bytes_, "its end marker");
      const int marker = bytes_[position_++];
      const bool restart = marker >= kFirstRestart && marker <= kLastRestart;
      const bool temporary = marker == 0x01;
      if (marker != 0 && !restart && !temporary) return marker;
    }
  }

  Bytes TakeSegment() {
    if (bytes_.size() - position_ < 2) RefuseCutOff("JPEG", bytes_, "its end marker");
    const size_t length = bytes_[position_] * 256 + bytes_[position_ + 1];
    if (length < 2) {
      RefuseImage("the JPEG has a segment of length " + std::to_string(length) + "; it is damaged");
    }
    if (bytes_.size() - position_ < length) RefuseCutOff("JPEG", bytes_, "its end marker");
    const Bytes segment = bytes_.subspan(position_ + 2, length - 2);
    position_ += length;
    return segment;
  }

  void ReadFrame(int marker, Bytes segment) {
    if (has_frame_) RefuseImage("the JPEG has two frame headers; it is damaged");
    if (!IsDecodable(marker)) {
      RefuseImage("the JPEG is lossless, hierarchical or arithmetic-coded (SOF" +
                  std::to_string(marker - kFirstFrame) +
                  "), which is not supported; save it as a baseline JPEG or PNG");
    }
    if (segment.size() < 6) RefuseImage("the frame header of the JPEG is too short; it is damaged");
    has_frame_ = true;
    header_.height = segment[1] * 256 + segment[2];
    header_.width = segment[3] * 256 + segment[4];
    progressive_ = marker == kProgressive;
    for (size_t at = 7; at < segment.size(); at += 3) {
      components_.push_back({segment[at] >> 4, segment[at] & 15});
    }
  }

  // Coefficients of all components, two bytes each, and the image; nearly as libjpeg pads them.
  int64_t BufferedBytes() const {
    int most_h = 1;
    int most_v = 1;
    for (const Sampling& each : components_) {
      most_h = std::max(most_h, each.h);
      most_v = std::max(most_v, each.v);
    }
    const auto padded = [](int64_t size, int share, int most) {
      constexpr int64_t kBlock = 8;
      return ((size * share + most - 1) / most + kBlock - 1) / kBlock * kBlock;
    };
    int64_t coefficients = 0;
    for (const Sampling& each : components_) {
      coefficients +=
          padded(header_.width, each.h, most_h) * padded(header_.height, each.v, most_v);
    }
    return 2 * coefficients + static_cast<int64_t>(header_.width) * header_.height;
  }

  ImageHeader Finish() {
    if (!has_frame_ || header_.scans == 0) {
      RefuseImage("the JPEG has no image data; it is damaged");
    }
    const bool in_parts = header_.scans > 1 || scan_components_ < std::ssize(components_);
    if (progressive_ || in_parts) header_.decode_bytes = BufferedBytes();
    return header_;
  }

  struct Sampling {
    int h;
    int v;
  };

  Bytes bytes_;
  size_t position_ = 2;  // after the start marker
  bool has_frame_ = false;
  bool progressive_ = false;
  std::vector<Sampling> components_;
  int scan_components_ = 0;  // of the last scan
  ImageHeader header_{.format = "jpeg", .width = 0, .height = 0, .scans = 0};
};

}  // namespace

ImageHeader ReadJpegHeader(Bytes bytes) { return JpegWalk(bytes).Read(); }

}  // namespace waystone
