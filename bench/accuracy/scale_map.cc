// SPDX-License-Identifier: Apache-2.0
#include "bench/accuracy/scale_map.h"

#include <algorithm>
#include <array>

#include "core/base/random.h"
#include "schema/layers/planes/index_features.h"

namespace waystone::bench {
namespace {

// A SIFT descriptor: 4 x 4 cells of 8 directions.
constexpr int kSide = 4;
constexpr int kDirections = 8;
constexpr int kBytes = kSide * kSide * kDirections;
constexpr double kNoise = 4.0;  // standard deviation of a byte
constexpr int kMaxByte = 127;

using Descriptor = std::array<uint8_t, kBytes>;

int At(int row, int column, int direction) {
  return (row * kSide + column) * kDirections + direction;
}

// The descriptor of the mirror image: across the main direction, which stays where it is.
Descriptor Mirrored(const Descriptor& from) {
  Descriptor to;
  for (int row = 0; row < kSide; ++row) {
    for (int column = 0; column < kSide; ++column) {
      for (int d = 0; d < kDirections; ++d) {
        to[At(row, column, d)] = from[At(kSide - 1 - row, column, (kDirections - d) % kDirections)];
      }
    }
  }
  return to;
}

class Mixer {
 public:
  Mixer(const MapData& map, uint64_t seed) : random_(seed) {
    for (const Plane& plane : map.planes) {
      for (int i = 0; i < plane.descriptors.rows(); ++i) {
        Descriptor& copy = all_.emplace_back();
        std::copy_n(plane.descriptors.row(i), kBytes, copy.begin());
      }
    }
  }

  Descriptor Make() {
    const Descriptor& a = Pick();
    const Descriptor& b = Pick();
    const int cut = random_.Below(4);  // which half is of b: upper, lower, left, right
    Descriptor made;
    for (int row = 0; row < kSide; ++row) {
      for (int column = 0; column < kSide; ++column) {
        const int place = cut < 2 ? row : column;
        const Descriptor& from = (place < kSide / 2) == (cut % 2 == 0) ? a : b;
        const int cell = At(row, column, 0);
        std::copy_n(from.begin() + cell, kDirections, made.begin() + cell);
      }
    }
    for (uint8_t& byte : made) {
      const double noisy = byte + kNoise * random_.Normal();
      byte = static_cast<uint8_t>(std::clamp<long>(std::lround(noisy), 0, kMaxByte));
    }
    return random_.Below(2) == 0 ? made : Mirrored(made);
  }

 private:
  const Descriptor& Pick() { return all_[random_.Below(static_cast<int>(all_.size()))]; }

  std::vector<Descriptor> all_;
  Random random_;
};

Plane MakePlane(const Plane& like, PlaneId id, Mixer& mixer) {
  Plane plane;
  plane.id = id;
  plane.reference = like.reference;
  plane.features = like.features;
  for (PlaneFeature& feature : plane.features) feature.votes = feature.visible = 1;
  plane.descriptors = Descriptors(kBytes);
  for (size_t i = 0; i < plane.features.size(); ++i) plane.descriptors.Append(mixer.Make().data());
  plane.outline = like.outline;
  plane.views = {{like.reference, Eigen::Matrix3d::Identity(), 1}};
  return plane;
}

}  // namespace

MapData Enlarged(const MapData& map, int64_t features, uint64_t seed) {
  MapData large = map;
  Mixer mixer(map, seed);
  int64_t count = CountFeatures(map);
  for (size_t i = 0; count < features && count > 0; ++i) {
    const Plane& like = map.planes[i % map.planes.size()];
    large.planes.push_back(MakePlane(like, {large.planes.back().id.value + 1}, mixer));
    count += std::ssize(like.features);
  }
  large.index = IndexFeatures(large);
  return large;
}

}  // namespace waystone::bench
