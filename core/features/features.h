// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <opencv2/core.hpp>
#include <string_view>
#include <vector>

#include "core/base/check.h"
#include "core/base/options.h"

namespace waystone {

// Kinds of features. The values are written into map files: never change them.
enum class FeatureType { kSift = 0, kOrb = 1, kAkaze = 2 };

// "sift", "orb", "akaze".
std::string_view NameOf(FeatureType type);
// Throws MapError(kBadOptions) for another name.
FeatureType FeatureTypeByName(std::string_view name);
// The same for an option; `path` is its name.
void ParseOptionValue(const std::string& path, const std::string& text, FeatureType* value);
// Bytes of one descriptor: 128 for SIFT, 32 for ORB, 61 for AKAZE.
int DescriptorBytes(FeatureType type);

// One keypoint. Frame: pixels, x right, y down, (0, 0) the centre of the top left pixel.
struct Keypoint {
  float x_px = 0;
  float y_px = 0;
  float scale_px = 0;   // size as OpenCV's detector has it; SIFT: 2 sigma
  float angle_rad = 0;  // orientation, in [0, 2 pi), clockwise as seen (x to y)

  bool operator==(const Keypoint&) const = default;
};

inline Eigen::Vector2d PositionOf(const Keypoint& keypoint) {
  return {keypoint.x_px, keypoint.y_px};
}

// N descriptors of `bytes` bytes each, in one contiguous row-major block.
// SIFT: RootSIFT (the L1-normalised descriptor's square root, after Arandjelovic and Zisserman
// 2012) times 256, rounded, at most 127: unit length becomes 256 and a product of two bytes stays
// below 2^14, which is what packed_rows.h relies on. ORB and AKAZE: bits.
class Descriptors {
 public:
  Descriptors() = default;
  explicit Descriptors(int bytes) : bytes_(bytes) {}
  Descriptors(int bytes, std::vector<uint8_t> data) : bytes_(bytes), data_(std::move(data)) {
    WS_CHECK(bytes > 0 && data_.size() % bytes == 0, "descriptor block of a broken size");
  }

  int rows() const { return bytes_ == 0 ? 0 : static_cast<int>(data_.size() / bytes_); }
  int bytes() const { return bytes_; }
  const uint8_t* row(int i) const { return data_.data() + static_cast<size_t>(i) * bytes_; }
  const std::vector<uint8_t>& data() const { return data_; }
  void Append(const uint8_t* row) { data_.insert(data_.end(), row, row + bytes_); }
  void Reserve(int rows) { data_.reserve(static_cast<size_t>(rows) * bytes_); }

  bool operator==(const Descriptors&) const = default;

 private:
  int bytes_ = 0;
  std::vector<uint8_t> data_;
};

// A non-owning view of consecutive descriptors.
struct DescriptorsView {
  const uint8_t* data = nullptr;
  int count = 0;
  int bytes = 0;

  DescriptorsView() = default;
  DescriptorsView(const uint8_t* first, int rows, int row_bytes)
      : data(first), count(rows), bytes(row_bytes) {}
  DescriptorsView(const Descriptors& all)  // NOLINT: meant to convert
      : data(all.data().data()), count(all.rows()), bytes(all.bytes()) {}

  int rows() const { return count; }
  const uint8_t* row(int i) const { return data + static_cast<size_t>(i) * bytes; }
};

constexpr int kClippedCells = 32;  // per side of an image

// What one image gave: keypoints[i] has descriptors.row(i). Strongest first, ties by position, so
// that the same image gives the same features on any thread.
// Keypoints, and everything computed from them, are in pixels of the working image: the given one,
// or a smaller copy of it. Features are as precise as these pixels, to which every tolerance in px
// refers.
struct Features {
  FeatureType type = FeatureType::kSift;
  int width = 0;         // px, of the working image
  int height = 0;        // px
  int image_width = 0;   // px, of the given image; 0 where it is the working image
  int image_height = 0;  // px
  std::vector<Keypoint> keypoints;
  Descriptors descriptors;
  // Whether the image is clipped to black or white there, so that it can't show a feature:
  // kClippedCells rows of as many cells, row by row. Empty where no cell is clipped.
  std::vector<bool> clipped;

  int size() const { return static_cast<int>(keypoints.size()); }
};

struct FeatureOptions {
  FeatureType type = FeatureType::kSift;
  int max_features = 1000;
  double contrast_threshold = 0.005;
  int working_pixels = 1'000'000;

  static constexpr auto Fields(const auto& use) {
    return use(
        OptionField{"type", &FeatureOptions::type, AnyValue(), "",
                    "Detector and descriptor: sift, orb or akaze."},
        OptionField{"max_features", &FeatureOptions::max_features, Closed(50, 20'000), "",
                    "Maximum number of features per image, strongest first. More features improve "
                    "recognition, at the cost of time and map size."},
        OptionField{"contrast_threshold", &FeatureOptions::contrast_threshold, Open(0, 1), "",
                    "SIFT: minimum contrast of a keypoint, on OpenCV's scale; lowered "
                    "proportionally in images with little contrast. Lower values find more "
                    "features on plain walls, but take longer."},
        OptionField{"working_pixels", &FeatureOptions::working_pixels, Closed(10'000, 50'000'000),
                    "",
                    "Larger images are downscaled to this many pixels before detection, which "
                    "bounds time and memory: SIFT takes about 240 bytes per pixel. Coordinates in "
                    "the map are pixels of the downscaled images."});
  }
  void Check() const;  // throws MapError(kBadOptions)
};

// The size of the copy of an image in which its features are found.
cv::Size WorkingSize(const cv::Size& image, int working_pixels);

// Whether a position in the working image, px, is in a clipped cell.
bool IsClipped(const Features& features, const Eigen::Vector2d& x);

// The size of the given image, px.
cv::Size ImageSize(const Features& features);

// Homogeneous pixels of the given image from those of the working image. The centre of the top left
// pixel is (0, 0) in both.
Eigen::Matrix3d ImageFromWorking(const Features& features);

// Features of an 8-bit grey image, found in a copy of at most working_pixels. For images whose grey
// values span little of the range, such as dark ones, the detectors' thresholds are lowered in
// proportion. Deterministic; thread-safe. An image too small or too plain for features gives none,
// not an error.
Features ExtractFeatures(const cv::Mat& grey, const FeatureOptions& options);

}  // namespace waystone
