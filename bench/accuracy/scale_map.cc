// SPDX-License-Identifier: Apache-2.0
#include "bench/accuracy/scale_map.h"

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>

#include "core/base/random.h"
#include "core/features/descriptor_codes.h"
#include "schema/layers/planes/index_features.h"

namespace waystone::bench {
namespace {

// A SIFT descriptor: 4 x 4 cells of 8 directions.
constexpr int kSide = 4;
constexpr int kDirections = 8;
constexpr int kBytes = kSide * kSide * kDirections;
constexpr double kNoise = 4.0;  // standard deviation of a byte
constexpr int kMaxByte = 127;
constexpr double kLength = 256;  // of a descriptor of ExtractFeatures

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
    const int cut = random_.Below(4);  // which half is b's: upper, lower, left, right
    Descriptor made;
    for (int row = 0; row < kSide; ++row) {
      for (int column = 0; column < kSide; ++column) {
        const int place = cut < 2 ? row : column;
        const Descriptor& from = (place < kSide / 2) == (cut % 2 == 0) ? a : b;
        const int cell = At(row, column, 0);
        std::copy_n(from.begin() + cell, kDirections, made.begin() + cell);
      }
    }
    AddNoise(made);
    return random_.Below(2) == 0 ? made : Mirrored(made);
  }

 private:
  // Keeps the length that every descriptor has.
  void AddNoise(Descriptor& descriptor) {
    Eigen::Array<double, kBytes, 1> noisy;
    for (int i = 0; i < kBytes; ++i) {
      noisy[i] = std::max(0.0, descriptor[i] + kNoise * random_.Normal());
    }
    noisy *= kLength / noisy.matrix().norm();
    for (int i = 0; i < kBytes; ++i) {
      descriptor[i] = static_cast<uint8_t>(std::min<long>(std::lround(noisy[i]), kMaxByte));
    }
  }

  const Descriptor& Pick() { return all_[random_.Below(static_cast<int>(all_.size()))]; }

  std::vector<Descriptor> all_;
  Random random_;
};

// Copies of all keyframes, planes and edges of a map, in a stretch of their own.
class Copier {
 public:
  Copier(const MapData& map, uint64_t seed) : map_(map), mixer_(map, seed) {}

  // The n-th copy, from 1.
  void AddTo(MapData& large, int n) {
    for (const Keyframe& keyframe : map_.keyframes) {
      Keyframe copy = keyframe;
      copy.id = CopyOf(keyframe.id, n);
      copy.stretch = keyframe.stretch + n * (map_.keyframes.back().stretch + 1);
      copy.landmarks.codes =
          EncodeDescriptors(Mixed(keyframe.landmarks.size()), FeatureType::kSift);
      large.keyframes.push_back(std::move(copy));
    }
    for (const Plane& plane : map_.planes) {
      Plane copy = plane;
      copy.id = CopyOf(plane.id, n);
      copy.reference = CopyOf(plane.reference, n);
      for (PlaneView& view : copy.views) view.keyframe = CopyOf(view.keyframe, n);
      copy.descriptors = Mixed(static_cast<int>(plane.features.size()));
      large.planes.push_back(std::move(copy));
    }
    for (Edge edge : map_.edges) {
      edge.a = CopyOf(edge.a, n);
      edge.b = CopyOf(edge.b, n);
      edge.from = CopyOf(edge.from, n);
      edge.to = CopyOf(edge.to, n);
      large.edges.push_back(edge);
    }
  }

 private:
  KeyframeId CopyOf(KeyframeId id, int n) const {
    return {id.value + n * (map_.keyframes.back().id.value + 1)};
  }
  PlaneId CopyOf(PlaneId id, int n) const {
    return {id.value + n * (map_.planes.back().id.value + 1)};
  }

  Descriptors Mixed(int count) {
    Descriptors mixed(kBytes);
    for (int i = 0; i < count; ++i) mixed.Append(mixer_.Make().data());
    return mixed;
  }

  const MapData& map_;
  Mixer mixer_;
};

}  // namespace

MapData Enlarged(const MapData& map, int64_t features, uint64_t seed) {
  MapData large = map;
  Copier copier(map, seed);
  const int64_t each = CountFeatures(map);
  int64_t count = each;
  for (int n = 1; count < features && each > 0; ++n, count += each) copier.AddTo(large, n);
  large.index = IndexFeatures(large);
  return large;
}

}  // namespace waystone::bench
