// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
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
// An image smaller than this on one side has no room for a descriptor's neighbourhood.
constexpr int kMinSide_px = 16;

cv::Ptr<cv::Feature2D> MakeDetector(const FeatureOptions& options) {
  switch (options.type) {
    case FeatureType::kSift:
      return cv::SIFT::create(options.max_features, 3, options.contrast_threshold);
    case FeatureType::kOrb:
      return cv::ORB::create(options.max_features);
    case FeatureType::kAkaze:
      return cv::AKAZE::create();
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
// its own limit keeps as many keypoints as ours but for ties. The others describe only what is
// kept.
Detected Detect(const cv::Mat& grey, const FeatureOptions& options) {
  const MemoryReservation room(DetectionBytes(grey));
  const cv::Ptr<cv::Feature2D> detector = MakeDetector(options);
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

// The image at the size at which features are detected.
cv::Mat Reduced(const cv::Mat& grey, int working_pixels) {
  const double scale = std::sqrt(working_pixels / static_cast<double>(grey.total()));
  if (scale >= 1) return grey;
  const cv::Size size(std::max(1, cvRound(scale * grey.cols)),
                      std::max(1, cvRound(scale * grey.rows)));
  cv::Mat reduced;
  cv::resize(grey, reduced, size, 0, 0, cv::INTER_AREA);
  return reduced;
}

// `enlarge`: width and height of an image over those of the one that the keypoint was found in.
// The centre of the top left pixel is (0, 0) in both.
Keypoint ToKeypoint(const cv::KeyPoint& k, const cv::Size2f& enlarge) {
  const float angle = k.angle < 0 ? 0.0f : k.angle * std::numbers::pi_v<float> / 180.0f;
  return {k.pt.x * enlarge.width + 0.5f * (enlarge.width - 1),
          k.pt.y * enlarge.height + 0.5f * (enlarge.height - 1), k.size * std::sqrt(enlarge.area()),
          angle};
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

void FeatureOptions::Check() const { CheckFields("features", *this); }

Features ExtractFeatures(const cv::Mat& grey, const FeatureOptions& options) {
  options.Check();
  WS_CHECK(grey.empty() || grey.type() == CV_8UC1, "features want an 8-bit grey image");
  Features features;
  features.type = options.type;
  features.width = grey.cols;
  features.height = grey.rows;
  features.descriptors = Descriptors(DescriptorBytes(options.type));
  if (std::min(grey.cols, grey.rows) < kMinSide_px) return features;

  const cv::Mat working = Reduced(grey, options.working_pixels);
  const cv::Size2f enlarge(static_cast<float>(grey.cols) / static_cast<float>(working.cols),
                           static_cast<float>(grey.rows) / static_cast<float>(working.rows));
  Detected found = Detect(working, options);
  const std::vector<int> order = StrongestFirst(found.keypoints, options.max_features);
  features.keypoints.reserve(order.size());
  features.descriptors.Reserve(static_cast<int>(order.size()));
  for (int i : order) {
    features.keypoints.push_back(ToKeypoint(found.keypoints[i], enlarge));
    if (options.type == FeatureType::kSift) {
      AppendRootSift(found.descriptors.ptr<float>(i), features.descriptors);
    } else {
      features.descriptors.Append(found.descriptors.ptr<uint8_t>(i));
    }
  }
  return features;
}

}  // namespace waystone
