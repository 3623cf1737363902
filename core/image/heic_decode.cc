// SPDX-License-Identifier: Apache-2.0
#include <libde265/de265.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <new>
#include <opencv2/imgproc.hpp>
#include <string>

#include "core/image/heic.h"

namespace waystone {
namespace {

void CheckDecoder(de265_error error) {
  if (error == DE265_OK) return;
  if (error == DE265_ERROR_OUT_OF_MEMORY) throw std::bad_alloc();
  RefuseImage(std::string("the HEIC is damaged: ") + de265_get_error_text(error) +
              "; copy or send the file again");
}

// The decoder library for one picture, in this thread.
class HevcDecoder {
 public:
  HevcDecoder() : context_(de265_new_decoder(), &de265_free_decoder) {
    if (!context_) throw std::bad_alloc();
    // As with JPEG, damage is reported, not concealed.
    de265_set_parameter_bool(context_.get(), DE265_DECODER_PARAM_SUPPRESS_FAULTY_PICTURES, 1);
  }

  // Valid as long as the decoder is.
  const de265_image* Decode(const HevcPicture& picture) {
    for (const Bytes unit : picture.units) {
      CheckDecoder(
          de265_push_NAL(context_.get(), unit.data(), static_cast<int>(unit.size()), 0, nullptr));
    }
    CheckDecoder(de265_flush_data(context_.get()));
    // There is more to do as long as a picture waits to be taken.
    const de265_image* image = nullptr;
    for (int more = 1; more != 0 && image == nullptr;) {
      more = 0;
      CheckDecoder(de265_decode(context_.get(), &more));
      image = de265_get_next_picture(context_.get());
    }
    const de265_error warning = de265_get_warning(context_.get());
    if (image == nullptr || warning != DE265_OK) {
      RefuseImage(
          std::string("the HEIC is damaged: ") +
          (warning == DE265_OK ? "its pixels can't be decoded" : de265_get_error_text(warning)) +
          "; copy or send the file again");
    }
    return image;
  }

 private:
  std::unique_ptr<de265_decoder_context, decltype(&de265_free_decoder)> context_;
};

// Table from samples to bytes: without the full range, luma runs from 16 to 235 and chroma to 240,
// of 255.
std::vector<uint8_t> ByteOfSample(int bits, bool full_range, bool chroma) {
  const double unit = std::ldexp(1.0, bits - 8);
  std::vector<uint8_t> bytes(size_t{1} << bits);
  for (size_t i = 0; i < bytes.size(); ++i) {
    const double value = static_cast<double>(i) / unit;
    const double zero = chroma ? 128 : 0;
    const double expanded = chroma ? (value - 128) * 255 / 224 + zero : (value - 16) * 255 / 219;
    const double byte = full_range ? std::floor(value) : std::round(expanded);
    bytes[i] = static_cast<uint8_t>(std::clamp(byte, 0.0, 255.0));
  }
  return bytes;
}

// Copies a plane of a tile to where it belongs, as far as it lies in the image.
void CopyPlane(const de265_image* from, int channel, bool full_range, cv::Point at, cv::Mat& to) {
  int stride = 0;
  const uint8_t* plane = de265_get_image_plane(from, channel, &stride);
  const int bits = de265_get_bits_per_pixel(from, channel);
  const cv::Rect all(0, 0, to.cols, to.rows);
  const cv::Rect place = all & cv::Rect(at.x, at.y, de265_get_image_width(from, channel),
                                        de265_get_image_height(from, channel));
  const std::vector<uint8_t> bytes = ByteOfSample(bits, full_range, channel > 0);
  const size_t most = bytes.size() - 1;
  for (int y = 0; y < place.height; ++y) {
    const uint8_t* row = plane + static_cast<ptrdiff_t>(stride) * y;
    uint8_t* target = to.ptr<uint8_t>(place.y + y) + place.x;
    if (bits > 8) {
      const auto* wide = reinterpret_cast<const uint16_t*>(row);
      for (int x = 0; x < place.width; ++x) target[x] = bytes[std::min<size_t>(wide[x], most)];
    } else {
      for (int x = 0; x < place.width; ++x) target[x] = bytes[row[x]];
    }
  }
}

// The image's planes, 8 bits each: luma, and chroma where it is wanted and present.
class HeicPlanes {
 public:
  HeicPlanes(const HeicImage& image, bool colour) : image_(image) {
    share_x_ = image.chroma == 1 || image.chroma == 2 ? 2 : 1;
    share_y_ = image.chroma == 1 ? 2 : 1;
    planes_[0] = cv::Mat(image.height, image.width, CV_8UC1);
    if (!colour || image.chroma == 0) return;
    const cv::Size size((image.width + share_x_ - 1) / share_x_,
                        (image.height + share_y_ - 1) / share_y_);
    planes_[1] = cv::Mat(size, CV_8UC1);
    planes_[2] = cv::Mat(size, CV_8UC1);
  }

  void Add(const HevcPicture& picture, int column, int row) {
    HevcDecoder decoder;
    const de265_image* tile = decoder.Decode(picture);
    if (de265_get_image_width(tile, 0) != image_.tile_width ||
        de265_get_image_height(tile, 0) != image_.tile_height ||
        de265_get_chroma_format(tile) != image_.chroma) {
      RefuseImage("the HEIC's pictures are not of the size that their header says; it is damaged");
    }
    const bool full = image_.full_range.value_or(de265_get_image_full_range_flag(tile) != 0);
    const cv::Point at(column * image_.tile_width, row * image_.tile_height);
    CopyPlane(tile, 0, full, at, planes_[0]);
    if (planes_[1].empty()) return;
    const cv::Point chroma_at(at.x / share_x_, at.y / share_y_);
    for (const int channel : {1, 2}) CopyPlane(tile, channel, full, chroma_at, planes_[channel]);
  }

  const cv::Mat& Grey() const { return planes_[0]; }

  cv::Mat Colour() const {
    cv::Mat bgr;
    if (planes_[1].empty()) {
      cv::cvtColor(planes_[0], bgr, cv::COLOR_GRAY2BGR);
      return bgr;
    }
    // In strips: chroma of the whole size would take as much again as the image.
    constexpr int kStrip = 64;
    bgr.create(planes_[0].size(), CV_8UC3);
    for (int y = 0; y < bgr.rows; y += kStrip) {
      const cv::Range rows(y, std::min(y + kStrip, bgr.rows));
      const cv::Range shared(y / share_y_, (rows.end + share_y_ - 1) / share_y_);
      const std::array<cv::Mat, 3> parts{planes_[0].rowRange(rows),
                                         Widened(planes_[2].rowRange(shared), rows.size()),
                                         Widened(planes_[1].rowRange(shared), rows.size())};
      cv::Mat strip;
      cv::merge(parts.data(), parts.size(), strip);
      cv::Mat target = bgr.rowRange(rows);
      cv::cvtColor(strip, target, cv::COLOR_YCrCb2BGR);
    }
    return bgr;
  }

 private:
  cv::Mat Widened(const cv::Mat& chroma, int rows) const {
    if (share_x_ == 1) return chroma;
    cv::Mat wide;
    cv::resize(chroma, wide, {}, share_x_, share_y_, cv::INTER_NEAREST);
    return wide(cv::Rect(0, 0, image_.width, rows));
  }

  const HeicImage& image_;
  int share_x_ = 1;  // pixels that share a chroma sample
  int share_y_ = 1;
  std::array<cv::Mat, 3> planes_;  // luma, blue, red
};

}  // namespace

cv::Mat DecodeHeic(const HeicImage& image, bool colour) {
  HeicPlanes planes(image, colour);
  for (int i = 0; i < static_cast<int>(image.tiles.size()); ++i) {
    planes.Add(image.tiles[i], i % image.columns, i / image.columns);
  }
  return colour ? planes.Colour() : planes.Grey();
}

}  // namespace waystone
