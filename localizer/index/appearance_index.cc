// SPDX-License-Identifier: Apache-2.0
#include "localizer/index/appearance_index.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>

#include "core/base/check.h"
#include "core/robust/median.h"

namespace waystone {
namespace {

constexpr float kMaxByte = 255;

// Largest square root of a magnitude among the nodes: what the bytes span.
float LargestRoot(const AppearanceLayer& layer, int columns) {
  float largest = 0;
  for (const AppearanceNode& node : layer.nodes) {
    const auto magnitudes = node.signature.magnitudes.leftCols(columns).cast<float>();
    largest = std::max(largest, magnitudes.maxCoeff());
  }
  return std::sqrt(largest);
}

// Compiles to the processor's sum of absolute differences.
uint32_t SumOfDifferences(const uint8_t* a, const uint8_t* b, int count) {
  uint32_t sum = 0;
  for (int i = 0; i < count; ++i) sum += static_cast<uint32_t>(std::abs(a[i] - b[i]));
  return sum;
}

struct Found {
  uint32_t distance = 0;
  int node = 0;

  auto operator<=>(const Found&) const = default;
};

}  // namespace

void AppearanceIndexOptions::Check() const { CheckFields("appearance_index", *this); }

AppearanceIndex::AppearanceIndex(const AppearanceLayer& layer,
                                 const AppearanceIndexOptions& options, const PoseLayer* poses)
    : nodes_(static_cast<int>(layer.nodes.size())),
      rows_(layer.described.rows),
      distances_(layer, poses) {
  options.Check();
  columns_ = std::min(options.frequencies, layer.described.k1);
  stride_ = std::min(options.stride, columns_);
  if (layer.nodes.empty()) return;
  for (const AppearanceNode& node : layer.nodes) {
    WS_CHECK(node.signature.magnitudes.rows() == rows_ &&
                 node.signature.magnitudes.cols() == layer.described.k1,
             "a node was described otherwise than its layer");
  }
  levels_per_unit_ = kMaxByte / std::max(LargestRoot(layer, columns_), 1e-6F);
  for (const AppearanceNode& node : layer.nodes) {
    const std::vector<uint8_t> bytes = BytesOf(node.signature);
    bytes_.insert(bytes_.end(), bytes.begin(), bytes.end());
  }
  typical_ = TypicalDistance(options.typical_pairs);
  spacing_ = std::max(MedianSpacing(), ComputeReach(options));
}

// Over nodes spread over the layer.
double AppearanceIndex::MedianSpacing() const {
  constexpr int kMostNodes = 1000;
  const int samples = std::min(nodes_, kMostNodes);
  std::vector<double> nearest;
  for (int i = 0; i < samples; ++i) {
    const auto a = static_cast<int>(static_cast<int64_t>(i) * nodes_ / samples);
    double best = std::numeric_limits<double>::infinity();
    for (int b = 0; b < nodes_; ++b) {
      if (a != b) best = std::min(best, distances_.Squared(a, b));  // squares: the pairs are many
    }
    nearest.push_back(std::sqrt(best));
  }
  return nearest.size() < 2 ? 0 : Median(std::move(nearest));
}

// The median, over nodes spread over the layer, of the distance to which all nodes look alike;
// similar places far away don't count.
double AppearanceIndex::ComputeReach(const AppearanceIndexOptions& options) const {
  const auto limit = static_cast<uint32_t>(options.alike * typical_);
  const int samples = std::min(nodes_, options.reach_nodes);
  std::vector<double> reaches;
  for (int i = 0; i < samples; ++i) {
    const auto a = static_cast<int>(static_cast<int64_t>(i) * nodes_ / samples);
    const uint8_t* bytes = bytes_.data() + static_cast<size_t>(a) * rows_ * columns_;
    double nearest_other = std::numeric_limits<double>::infinity();
    std::vector<double> like;  // distances to those that look alike
    for (int b = 0; b < nodes_; ++b) {
      if (b == a) continue;
      const double apart = distances_.Between(a, b);
      if (DistanceBelow(bytes, b, limit) < limit) {
        like.push_back(apart);
      } else {
        nearest_other = std::min(nearest_other, apart);
      }
    }
    double reach = 0;
    for (const double apart : like) {
      if (apart < nearest_other) reach = std::max(reach, apart);
    }
    // Where all look alike, places can't be distinguished.
    reaches.push_back(std::isfinite(nearest_other) ? reach : 0);
  }
  return Median(std::move(reaches));
}

// The mean over pairs that lie a third to two thirds of the layer apart in its order.
double AppearanceIndex::TypicalDistance(int pairs) const {
  if (nodes_ < 2) return 1;
  const int size = rows_ * columns_;
  double sum = 0;
  for (int pair = 0; pair < pairs; ++pair) {
    const int a = static_cast<int>(static_cast<int64_t>(pair) * nodes_ / pairs);
    const int apart = 1 + (nodes_ - 1) / 3 + pair % std::max(1, (nodes_ - 1) / 3);
    const int b = (a + std::min(apart, nodes_ - 1)) % nodes_;
    sum += SumOfDifferences(bytes_.data() + static_cast<size_t>(a) * size,
                            bytes_.data() + static_cast<size_t>(b) * size, size);
  }
  return std::max(sum / pairs, 1.0);
}

std::vector<uint8_t> AppearanceIndex::BytesOf(const FourierSignature& signature) const {
  WS_CHECK(signature.magnitudes.rows() == rows_ && signature.magnitudes.cols() >= columns_,
           "a query was described otherwise than the layer");
  std::vector<uint8_t> bytes;
  bytes.reserve(static_cast<size_t>(rows_) * columns_);
  for (int column = 0; column < columns_; ++column) {
    for (int row = 0; row < rows_; ++row) {
      const auto magnitude = static_cast<float>(signature.magnitudes(row, column));
      const float level = levels_per_unit_ * std::sqrt(std::max(magnitude, 0.0F));
      bytes.push_back(static_cast<uint8_t>(std::lround(std::min(level, kMaxByte))));
    }
  }
  return bytes;
}

// The distance where it is below the limit, else any number that isn't.
uint32_t AppearanceIndex::DistanceBelow(const uint8_t* query, int node, uint32_t limit) const {
  const int size = rows_ * columns_;
  const uint8_t* bytes = bytes_.data() + static_cast<size_t>(node) * size;
  uint32_t sum = 0;
  for (int first = 0; first < size && sum < limit; first += rows_ * stride_) {
    const int count = std::min(rows_ * stride_, size - first);
    sum += SumOfDifferences(query + first, bytes + first, count);
  }
  return sum;
}

double AppearanceIndex::Distance(const FourierSignature& a, const FourierSignature& b) const {
  return SumOfDifferences(BytesOf(a).data(), BytesOf(b).data(), rows_ * columns_) / typical_;
}

std::vector<NearNode> AppearanceIndex::Nearest(const FourierSignature& query, int count,
                                               const std::vector<bool>& left_out) const {
  WS_CHECK(count > 0, "at least one node must be asked for");
  WS_CHECK(left_out.empty() || left_out.size() == static_cast<size_t>(nodes_), "one flag a node");
  if (nodes_ == 0) return {};
  const std::vector<uint8_t> bytes = BytesOf(query);
  std::vector<Found> best;  // ascending
  uint32_t limit = std::numeric_limits<uint32_t>::max();
  for (int node = 0; node < nodes_; ++node) {
    if (!left_out.empty() && left_out[node]) continue;
    const Found found{DistanceBelow(bytes.data(), node, limit), node};
    if (found.distance >= limit) continue;
    best.insert(std::upper_bound(best.begin(), best.end(), found), found);
    if (static_cast<int>(best.size()) > count) best.pop_back();
    if (static_cast<int>(best.size()) == count) limit = best.back().distance;
  }
  std::vector<NearNode> nearest;
  for (const Found& found : best) nearest.push_back({found.node, found.distance / typical_});
  return nearest;
}

}  // namespace waystone
