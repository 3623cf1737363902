// SPDX-License-Identifier: Apache-2.0
#include "schema/layers/planes/plane_layer.h"

#include <algorithm>
#include <cmath>

namespace waystone {
namespace {

constexpr double kPositionSteps = 65536;

uint16_t EncodeCoordinate(double at, int size) {
  return static_cast<uint16_t>(
      std::clamp(std::round(at / size * kPositionSteps), 0.0, kPositionSteps - 1));
}

}  // namespace

ImagePosition EncodePosition(const Eigen::Vector2d& x, int width, int height) {
  return {EncodeCoordinate(x.x(), width), EncodeCoordinate(x.y(), height)};
}

Eigen::Vector2d DecodePosition(const ImagePosition& position, int width, int height) {
  return {position.x * width / kPositionSteps, position.y * height / kPositionSteps};
}

}  // namespace waystone
