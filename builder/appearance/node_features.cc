// SPDX-License-Identifier: Apache-2.0
#include "builder/appearance/node_features.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <tuple>
#include <utility>

namespace waystone {
namespace {

int FindSector(const Eigen::Vector3d& ray, int sectors) {
  const double turns = std::atan2(ray.x(), ray.z()) / (2 * std::numbers::pi) + 0.5;
  const int around = std::clamp(static_cast<int>(turns * sectors), 0, sectors - 1);
  return ray.y() < 0 ? around : sectors + around;
}

// Rows by usefulness: those found again most often first, then the strongest of each camera.
std::vector<int> Ranked(const BearingFeatures& features, const std::vector<int>& found) {
  std::map<int, int> seen;  // features of each camera so far; they come strongest first
  std::vector<std::tuple<int, int, int>> order;
  for (int i = 0; i < features.size(); ++i) {
    order.emplace_back(-found[i], seen[features.camera[i]]++, i);
  }
  std::ranges::sort(order);
  std::vector<int> rows;
  for (const auto& [worth, rank, row] : order) rows.push_back(row);
  return rows;
}

// The best rows, with no sector exceeding its share before the others have theirs; ascending.
std::vector<int> Spread(const BearingFeatures& features, const std::vector<int>& ranked,
                        const NodeFeatureOptions& options) {
  const int share =
      static_cast<int>(std::ceil(options.max_crowd * options.max_kept / (2 * options.sectors)));
  std::vector<int> filled(2 * options.sectors, 0);
  std::vector<int> kept;
  std::vector<int> rest;
  for (const int row : ranked) {
    (filled[FindSector(features.rays[row], options.sectors)]++ < share ? kept : rest)
        .push_back(row);
  }
  kept.insert(kept.end(), rest.begin(), rest.end());
  kept.resize(std::min(kept.size(), static_cast<size_t>(options.max_kept)));
  std::ranges::sort(kept);
  return kept;
}

}  // namespace

void NodeFeatureOptions::Check() const {
  CheckFields("features", *this);
  extract.Check();
}

NodeFeatures NodeFeatureChooser::Next(BearingFeatures features) {
  std::vector<int> found(features.size(), 0);
  if (features.size() > 0 && features_.size() > 0) {
    for (const Match& match : MatchBearings(features_, features, options_.match).matches) {
      ++found_[match.a];
      ++found[match.b];
    }
  }
  NodeFeatures chosen = Chosen();
  features_ = std::move(features);
  found_ = std::move(found);
  return chosen;
}

NodeFeatures NodeFeatureChooser::Last() {
  NodeFeatures chosen = Chosen();
  features_ = {};
  found_.clear();
  return chosen;
}

NodeFeatures NodeFeatureChooser::Chosen() const {
  if (features_.size() == 0) return {};
  BearingFeatures kept;
  kept.type = features_.type;
  kept.descriptors = Descriptors(features_.descriptors.bytes());
  for (const int row : Spread(features_, Ranked(features_, found_), options_)) {
    kept.rays.push_back(features_.rays[row]);
    kept.descriptors.Append(features_.descriptors.row(row));
  }
  return ToNodeFeatures(kept);
}

}  // namespace waystone
