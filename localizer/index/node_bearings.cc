// SPDX-License-Identifier: Apache-2.0
#include "localizer/index/node_bearings.h"

#include <algorithm>
#include <cmath>

#include "core/features/descriptor_codes.h"

namespace waystone {
namespace {

int16_t UnitsOf(double angle_rad) {
  // Pi and minus pi are one azimuth: 32768 doesn't fit.
  return static_cast<int16_t>(
      std::clamp(std::lround(angle_rad / kBearingUnit_rad), -32768L, 32767L));
}

Bearing BearingOf(const Eigen::Vector3d& ray) {
  return {UnitsOf(std::atan2(ray.x(), ray.z())), UnitsOf(std::asin(-ray.normalized().y()))};
}

Eigen::Vector3d RayOf(const Bearing& bearing) {
  const double azimuth = bearing.azimuth * kBearingUnit_rad;
  const double elevation = bearing.elevation * kBearingUnit_rad;
  const double level = std::cos(elevation);
  return {level * std::sin(azimuth), -std::sin(elevation), level * std::cos(azimuth)};
}

}  // namespace

NodeFeatures ToNodeFeatures(const BearingFeatures& features) {
  NodeFeatures kept;
  for (const Eigen::Vector3d& ray : features.rays) kept.bearings.push_back(BearingOf(ray));
  kept.codes = EncodeDescriptors(features.descriptors, features.type);
  return kept;
}

BearingFeatures ToBearingFeatures(const NodeFeatures& features, FeatureType type) {
  BearingFeatures rays;
  rays.type = type;
  for (const Bearing& bearing : features.bearings) rays.rays.push_back(RayOf(bearing));
  rays.descriptors = DecodeDescriptors(features.codes, type);
  return rays;
}

}  // namespace waystone
