// SPDX-License-Identifier: Apache-2.0
#include "core/homography/binary_energy.h"

#include <algorithm>
#include <opencv2/core.hpp>
#include <opencv2/imgproc/detail/gcgraph.hpp>

namespace waystone {

void BinaryEnergy::Add(int i, int j, double v00, double v01, double v10, double v11) {
  cost_[i] += v10 - v00;
  cost_[j] += v11 - v10;
  const double both = v01 + v10 - v00 - v11;
  if (both > 0) pairs_.push_back({i, j, both});
}

std::vector<bool> BinaryEnergy::Minimise() const {
  std::vector<Value> values = DecideClear();
  Cut(values);
  std::vector<bool> x;
  for (const Value value : values) x.push_back(value == Value::kOne);
  return x;
}

// A variable is 0 where all of its pairs together can't make 1 cheaper, and 1 where they can't make
// it dearer. Each decided variable leaves the other variable of each of its pairs one pair fewer.
std::vector<BinaryEnergy::Value> BinaryEnergy::DecideClear() const {
  std::vector<double> least = cost_;  // of 1 over 0, whatever the others are
  std::vector<double> most = cost_;
  std::vector<int> first(cost_.size() + 1, 0);  // in `pairs`, of each variable's
  for (const Pair& pair : pairs_) {
    least[pair.i] -= pair.cost;
    most[pair.j] += pair.cost;
    ++first[pair.i];
    ++first[pair.j];
  }
  for (size_t i = 1; i < first.size(); ++i) first[i] += first[i - 1];
  std::vector<const Pair*> pairs(2 * pairs_.size());
  for (const Pair& pair : pairs_) {
    pairs[--first[pair.i]] = &pair;
    pairs[--first[pair.j]] = &pair;
  }
  std::vector<Value> values(cost_.size(), Value::kOpen);
  std::vector<int> decided;
  const auto decide = [&](int i) {
    if (values[i] != Value::kOpen || (least[i] < 0 && most[i] >= 0)) return;
    values[i] = least[i] < 0 ? Value::kOne : Value::kZero;
    decided.push_back(i);
  };
  for (int i = 0; i < std::ssize(cost_); ++i) decide(i);
  while (!decided.empty()) {
    const int i = decided.back();
    decided.pop_back();
    for (int p = first[i]; p < first[i + 1]; ++p) {
      const int other = pairs[p]->i == i ? pairs[p]->j : pairs[p]->i;
      if (values[i] == Value::kZero) {
        least[other] += pairs[p]->cost;
      } else {
        most[other] -= pairs[p]->cost;
      }
      decide(other);
    }
  }
  return values;
}

// Decides the open variables: x = 1 on the source's side.
void BinaryEnergy::Cut(std::vector<Value>& values) const {
  std::vector<int> open;
  std::vector<int> vertex_of(values.size(), -1);
  std::vector<double> cost = cost_;
  for (int i = 0; i < std::ssize(values); ++i) {
    if (values[i] != Value::kOpen) continue;
    vertex_of[i] = static_cast<int>(open.size());
    open.push_back(i);
  }
  if (open.empty()) return;
  std::vector<Pair> between;
  for (const Pair& pair : pairs_) {
    const int i = vertex_of[pair.i];
    const int j = vertex_of[pair.j];
    if (i >= 0 && j >= 0) between.push_back({i, j, pair.cost});
    if (values[pair.i] == Value::kZero) cost[pair.j] += pair.cost;
    if (values[pair.j] == Value::kOne) cost[pair.i] -= pair.cost;
  }
  // Pairs cost nothing where all are 0, so nothing changes unless some variable gains by itself.
  if (std::ranges::none_of(open, [&](int i) { return cost[i] < 0; })) {
    for (const int i : open) values[i] = Value::kZero;
    return;
  }
  if (between.empty()) {  // no graph to cut: each by itself
    for (const int i : open) values[i] = cost[i] < 0 ? Value::kOne : Value::kZero;
    return;
  }
  cv::detail::GCGraph<double> graph;
  graph.create(static_cast<int>(open.size()), static_cast<int>(between.size()));
  for (const int i : open) {
    graph.addTermWeights(graph.addVtx(), std::max(0.0, -cost[i]), std::max(0.0, cost[i]));
  }
  for (const Pair& pair : between) graph.addEdges(pair.j, pair.i, pair.cost, 0);
  graph.maxFlow();
  for (const int i : open) {
    values[i] = graph.inSourceSegment(vertex_of[i]) ? Value::kOne : Value::kZero;
  }
}

}  // namespace waystone
