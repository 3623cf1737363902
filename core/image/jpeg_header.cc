// SPDX-License-Identifier: Apache-2.0
#include "core/base/error.h"
#include "core/image/formats.h"

namespace waystone {
namespace {

enum Marker : int {
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

// Baseline, extended and progressive, with Huffman or arithmetic coding: what libjpeg decodes.
bool IsDecodable(int frame) { return frame <= 0xC2 || frame == 0xC9 || frame == 0xCA; }

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
      } else if (!IsOtherSegment(marker)) {
        // libjpeg gives up on these too, or steps over them without their length: a place to hide.
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
      RefuseImage("the JPEG is lossless or hierarchical (SOF" +
                  std::to_string(marker - kFirstFrame) +
                  "), which is not supported; save it as a baseline JPEG or PNG");
    }
    if (segment.size() < 6) RefuseImage("the frame header of the JPEG is too short; it is damaged");
    has_frame_ = true;
    header_.height = segment[1] * 256 + segment[2];
    header_.width = segment[3] * 256 + segment[4];
  }

  ImageHeader Finish() {
    if (!has_frame_ || header_.scans == 0) {
      RefuseImage("the JPEG has no image data; it is damaged");
    }
    return header_;
  }

  Bytes bytes_;
  size_t position_ = 2;  // behind the start marker
  bool has_frame_ = false;
  ImageHeader header_{.format = "jpeg", .width = 0, .height = 0, .scans = 0};
};

}  // namespace

ImageHeader ReadJpegHeader(Bytes bytes) { return JpegWalk(bytes).Read(); }

}  // namespace waystone
