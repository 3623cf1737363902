// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>
#include <opencv2/features2d.hpp>
#include <opencv2/imgproc.hpp>

#include "core/base/error.h"
#include "core/base/memory_reservation.h"
#include "core/features/features.h"

namespace waystone {
namespace {

constexpr float kSiftScale = 256.0f;  // length of a RootSIFT descriptor in bytes' units
constexpr int kSiftMax = 127;
constexpr float kOrbScale = 1.2F;  // from one level of the pyramid to the next
// An image smaller than this on one side has no room for a descriptor's neighbourhood.
constexpr int kMinSide_px = 16;

// Contrast thresholds are meant for images whose grey values span this share of the range.
constexpr double kFullSpan = 0.6;
constexpr double kLeastContrast = 0.1;  // below it there is mostly noise
constexpr double kTail = 0.01;          // of the pixels, at either end

// The span of an image's grey values as a share of kFullSpan, in [kLeastContrast, 1]. Little light,
// haze and glare shrink differences of grey values, but the structure stays visible.
double ContrastOf(const cv::Mat& grey) {
  cv::Mat histogram;
  cv::calcHist(std::vector<cv::Mat>{grey}, {0}, cv::noArray(), histogram, {256}, {0, 256});
  const auto count = [&](int value) { return double{histogram.at<float>(value)}; };
  const double tail = kTail * static_cast<double>(grey.total());
  int low = 0;
  for (double below = count(0); below <= tail; below += count(++low)) {
  }
  int high = 255;
  for (double above = count(255); above <= tail; above += count(--high)) {
  }
  return std::clamp((high - low) / (255 * kFullSpan), kLeastContrast, 1.0);
}

// The detectors' thresholds apply to differences of grey values (SIFT, ORB) or to their squares
// (AKAZE).
cv::Ptr<cv::Feature2D> MakeDetector(const FeatureOptions& options, double contrast) {
  switch (options.type) {
    case FeatureType::kSift:
      return cv::SIFT::create(options.max_features, 3, contrast * options.contrast_threshold);
    case FeatureType::kOrb: {
      const cv::Ptr<cv::ORB> orb = cv::ORB::create(options.max_features, kOrbScale);
      orb->setFastThreshold(std::max(1, cvRound(contrast * orb->getFastThreshold())));
      return orb;
    }
    case FeatureType::kAkaze: {
      const cv::Ptr<cv::AKAZE> akaze = cv::AKAZE::create();
      akaze->setThreshold(contrast * contrast * akaze->getThreshold());
      return akaze;
    }
  }
  WS_CHECK(false, "unknown feature type");
}

// OpenCV's own order depends on its internals; ours is by strength, then by position.
bool StrongerThan(const cv::KeyPoint& a, const cv::KeyPoint& b) {
  if (a.response != b.response) return a.response > b.response;
  if (a.pt.y != b.pt.y) return a.pt.y < b.pt.y;
  if (a.pt.x != b.pt.x) return a.pt.x < b.pt.x;
  if (a.size != b.size) return a.size < b.size;
  return a.angle < b.angle;
}

// Indices of the strongest keypoints.
std::vector<int> StrongestFirst(const std::vector<cv::KeyPoint>& keypoints, int at_most) {
  std::vector<int> order(keypoints.size());
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(),
            [&](int a, int b) { return StrongerThan(keypoints[a], keypoints[b]); });
  if (std::ssize(order) > at_most) order.resize(at_most);
  return order;
}

struct Detected {
  std::vector<cv::KeyPoint> keypoints;
  cv::Mat descriptors;  // row i belongs to keypoints[i]
};

// OpenCV's detectors end the program where memory runs out inside them. SIFT takes the most: six
// blurred images and five differences of them in float, of twice the width and height, and a third
// more for the octaves above; and glibc's heaps grow by 64 MB.
int64_t DetectionBytes(const cv::Mat& grey) {
  constexpr int64_t kBytesPerPixel = 300;
  constexpr int64_t kHeap = int64_t{64} << 20;
  return kBytesPerPixel * static_cast<int64_t>(grey.total()) + kHeap;
}

// SIFT in one go: its scale space is built once rather than for keypoints and descriptors each, and
// its own limit keeps as many keypoints as ours, except for ties. For the others, only kept
// keypoints are described.
Detected Detect(const cv::Mat& grey, const FeatureOptions& options) {
  const MemoryReservation room(DetectionBytes(grey));
  const cv::Ptr<cv::Feature2D> detector = MakeDetector(options, ContrastOf(grey));
  Detected found;
  if (options.type == FeatureType::kSift) {
    detector->detectAndCompute(grey, cv::noArray(), found.keypoints, found.descriptors);
    return found;
  }
  std::vector<cv::KeyPoint> all;
  detector->detect(grey, all);
  for (int i : StrongestFirst(all, options.max_features)) found.keypoints.push_back(all[i]);
  detector->compute(grey, found.keypoints, found.descriptors);  // may drop some near the border
  return found;
}

// RootSIFT (Arandjelovic and Zisserman, CVPR 2012): Euclidean distances of these are Hellinger
// distances of the histograms.
void AppendRootSift(const float* sift, Descriptors& out) {
  constexpr int kBytes = 128;
  const float sum = std::max(std::accumulate(sift, sift + kBytes, 0.0f), 1e-6f);
  std::array<uint8_t, kBytes> bytes;
  for (int i = 0; i < kBytes; ++i) {
    const float root = std::sqrt(std::max(sift[i], 0.0f) / sum);
    bytes[i] = static_cast<uint8_t>(std::min<int>(std::lround(kSiftScale * root), kSiftMax));
  }
  out.Append(bytes.data());
}

// cv::resize takes the same factor for both directions, not the ratios of the rounded sizes.
cv::Mat Reduced(const cv::Mat& grey, const cv::Size& size) {
  if (size == grey.size()) return grey;
  const double scale = size.width / static_cast<double>(grey.cols);
  cv::Mat reduced;
  cv::resize(grey, reduced, {}, scale, scale, cv::INTER_AREA);
  return reduced;
}

// Cells most of whose pixels are at an end of the range, up to noise and JPEG artefacts.
std::vector<bool> FindClipped(const cv::Mat& grey) {
  constexpr int kWithin = 4;  // grey levels
  const cv::Mat at_an_end = (grey <= kWithin) | (grey >= 255 - kWithin);
  cv::Mat share;
  cv::resize(at_an_end, share, {kClippedCells, kClippedCells}, 0, 0, cv::INTER_AREA);
  const auto is_clipped = [](uint8_t of_255) { return of_255 > 127; };
  if (std::none_of(share.begin<uint8_t>(), share.end<uint8_t>(), is_clipped)) return {};
  std::vector<bool> clipped(share.total());
  std::transform(share.begin<uint8_t>(), share.end<uint8_t>(), clipped.begin(), is_clipped);
  return clipped;
}

// OpenCV multiplies positions in a resized image by a factor, as if pixels' corners were at
// integers: SIFT's in the image of twice the size, ORB's in those of its pyramid. The shift is of
// both x and y, px.
float ShiftOf(const cv::KeyPoint& k, FeatureType type) {
  if (type == FeatureType::kSift) return -0.25F;
  if (type == FeatureType::kOrb) return (std::pow(kOrbScale, static_cast<float>(k.octave)) - 1) / 2;
  return 0;
}

Keypoint ToKeypoint(const cv::KeyPoint& k, FeatureType type) {
  const float shift = ShiftOf(k, type);
  const float angle = k.angle < 0 ? 0.0f : k.angle * std::numbers::pi_v<float> / 180.0f;
  return {k.pt.x + shift, k.pt.y + shift, k.size, angle};
}

}  // namespace

std::string_view NameOf(FeatureType type) {
  switch (type) {
    case FeatureType::kSift:
      return "sift";
    case FeatureType::kOrb:
      return "orb";
    case FeatureType::kAkaze:
      return "akaze";
  }
  WS_CHECK(false, "unknown feature type");
}

void ParseOptionValue(const std::string& path, const std::string& text, FeatureType* value) {
  for (FeatureType type : {FeatureType::kSift, FeatureType::kOrb, FeatureType::kAkaze}) {
    if (NameOf(type) != text) continue;
    *value = type;
    return;
  }
  throw MapError(ErrorCode::kBadOptions,
                 path + " is '" + text + "'; it must be sift, orb or akaze");
}

FeatureType FeatureTypeByName(std::string_view name) {
  FeatureType type{};
  ParseOptionValue("the feature type", std::string(name), &type);
  return type;
}

int DescriptorBytes(FeatureType type) {
  switch (type) {
    case FeatureType::kSift:
      return 128;
    case FeatureType::kOrb:
      return 32;
    case FeatureType::kAkaze:
      return 61;
  }
  WS_CHECK(false, "unknown feature type");
}

// By one factor in both directions, which a camera's calibration can follow (ScaledCamera).
cv::Size WorkingSize(const cv::Size& image, int working_pixels) {
  const double share = std::sqrt(working_pixels / std::max(1.0, image.area() * 1.0));
  if (share >= 1) return image;
  const int width = std::max(1, cvRound(share * image.width));
  const double scale = width / static_cast<double>(image.width);
  return {width, std::max(1, cvRound(scale * image.height))};
}

bool IsClipped(const Features& features, const Eigen::Vector2d& x) {
  if (features.clipped.empty()) return false;
  const auto cell = [](double position, int size) {
    return std::clamp(static_cast<int>(kClippedCells * (position + 0.5) / size), 0,
                      kClippedCells - 1);
  };
  const int row = cell(x.y(), features.height);
  return features.clipped[kClippedCells * row + cell(x.x(), features.width)];
}

cv::Size ImageSize(const Features& features) {
  if (features.image_width == 0) return {features.width, features.height};
  return {features.image_width, features.image_height};
}

Eigen::Matrix3d ImageFromWorking(const Features& features) {
  const int width = ImageSize(features).width;
  const double scale = width == features.width ? 1 : width / static_cast<double>(features.width);
  Eigen::Matrix3d image_from_working = Eigen::Matrix3d::Identity();
  image_from_working(0, 0) = image_from_working(1, 1) = scale;
  image_from_working(0, 2) = image_from_working(1, 2) = 0.5 * (scale - 1);
  return image_from_working;
}

void FeatureOptions::Check() const { CheckFields("features", *this); }

Features ExtractFeatures(const cv::Mat& grey, const FeatureOptions& options) {
  options.Check();
  WS_CHECK(grey.empty() || grey.type() == CV_8UC1, "features want an 8-bit grey image");
  Features features;
  features.type = options.type;
  features.width = features.image_width = grey.cols;
  features.height = features.image_height = grey.rows;
  features.descriptors = Descriptors(DescriptorBytes(options.type));
  if (std::min(grey.cols, grey.rows) < kMinSide_px) return features;

  const cv::Mat working = Reduced(grey, WorkingSize(grey.size(), options.working_pixels));
  features.width = working.cols;
  features.height = working.rows;
  if (std::min(working.cols, working.rows) < kMinSide_px) return features;
  features.clipped = FindClipped(working);
  Detected found = Detect(working, options);
  const std::vector<int> order = StrongestFirst(found.keypoints, options.max_features);
  features.keypoints.reserve(order.size());
  features.descriptors.Reserve(static_cast<int>(order.size()));
  for (int i : order) {
    features.keypoints.push_back(ToKeypoint(found.keypoints[i], options.type));
    if (options.type == FeatureType::kSift) {
      AppendRootSift(found.descriptors.ptr<float>(i), features.descriptors);
    } else {
      features.descriptors.Append(found.descriptors.ptr<uint8_t>(i));
    }
  }
  return features;
}

}  // namespace waystone
