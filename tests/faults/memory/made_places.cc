// SPDX-License-Identifier: Apache-2.0
#include "tests/faults/memory/made_places.h"

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "core/features/features.h"
#include "core/image/decode.h"
#include "core/panorama/fourier_signature.h"
#include "tests/server/service/made_map.h"

namespace waystone {
namespace {

// Blots of many sizes, which have features.
cv::Mat MakeTexture(int width, int height, uint64_t seed) {
  cv::RNG random(seed);
  cv::Mat image(height, width, CV_8UC1, cv::Scalar(128));
  for (int i = 0; i < 400; ++i) {
    cv::circle(image, {random.uniform(0, width), random.uniform(0, height)}, random.uniform(2, 12),
               cv::Scalar(random.uniform(0, 255)), cv::FILLED, cv::LINE_AA);
  }
  return image;
}

std::string Jpeg(const cv::Mat& image) {
  std::vector<uint8_t> bytes;
  cv::imencode(".jpg", image, bytes);
  return {bytes.begin(), bytes.end()};
}

cv::Mat Decoded(const std::string& jpeg) {
  return DecodeGrey({reinterpret_cast<const uint8_t*>(jpeg.data()), jpeg.size()}, {});
}

MapData MakePhotoMap() {
  MapData map = MadeMap(1);
  const Features features = ExtractFeatures(Decoded(PhotoJpeg()), {.max_features = 300});
  map.keyframes[0].width = features.width;
  map.keyframes[0].height = features.height;
  Plane& plane = map.planes[0];
  plane.features.clear();
  for (const Keypoint& keypoint : features.keypoints) plane.features.push_back({keypoint, 1, 1});
  plane.descriptors = features.descriptors;
  plane.outline = {{0, 0}, {319, 0}, {319, 239}, {0, 239}};
  plane.views = {{KeyframeId{1}, Eigen::Matrix3d::Identity(), features.size()}};
  return map;
}

MapData MakePanoramaMap() {
  MapData map = MadeLayeredMap(0);
  map.appearance->described = {};
  for (uint64_t i = 0; i < 3; ++i) {
    const cv::Mat panorama = i == 0 ? Decoded(PanoramaJpeg()) : MakeTexture(256, 128, 20 + i);
    map.appearance->nodes[i].signature = Signature(panorama);
  }
  return map;
}

}  // namespace

const MapData& PhotoMap() {
  static const MapData map = MakePhotoMap();
  return map;
}

const MapData& PanoramaMap() {
  static const MapData map = MakePanoramaMap();
  return map;
}

const std::string& PhotoJpeg() {
  static const std::string jpeg = Jpeg(MakeTexture(320, 240, 1));
  return jpeg;
}

std::vector<std::string> PhotoWalk() {
  const cv::Mat wall = MakeTexture(600, 240, 3);
  std::vector<std::string> walk;
  for (int i = 0; i < 6; ++i) walk.push_back(Jpeg(wall(cv::Rect(50 * i, 0, 320, 240))));
  return walk;
}

std::vector<std::string> PanoramaWalk() {
  const cv::Mat panorama = MakeTexture(256, 128, 4);
  std::vector<std::string> walk;
  for (const int column : {64, 128, 192}) {
    cv::Mat turned;
    cv::hconcat(panorama.colRange(column, 256), panorama.colRange(0, column), turned);
    walk.push_back(Jpeg(turned));
  }
  return walk;
}

const std::string& PanoramaJpeg() {
  static const std::string jpeg = Jpeg(MakeTexture(256, 128, 2));
  return jpeg;
}

}  // namespace waystone
