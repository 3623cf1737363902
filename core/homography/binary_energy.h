// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

namespace waystone {

// Minimises a sum of costs of binary variables and of pairs of them. Variables whose pairs can't
// change their value are decided first (first-order persistency: Boros and Hammer 2002), the others
// by a minimum cut (Kolmogorov and Zabih 2004). Deterministic. Not thread-safe.
class BinaryEnergy {
 public:
  explicit BinaryEnergy(int variables) : cost_(variables, 0.0) {}

  // Adds a cost of x_i being 1. It may be negative.
  void Add(int i, double cost) { cost_[i] += cost; }

  // Adds a cost for each value of (x_i, x_j). Needs v00 + v11 <= v01 + v10.
  void Add(int i, int j, double v00, double v01, double v10, double v11);

  // The values that minimise the sum.
  std::vector<bool> Minimise() const;

 private:
  struct Pair {
    int i;
    int j;
    double cost;  // where x_i is 0 and x_j is 1
  };
  enum class Value : char { kZero, kOne, kOpen };

  std::vector<Value> DecideClear() const;
  void Cut(std::vector<Value>& values) const;

  std::vector<double> cost_;  // of x = 1 over x = 0
  std::vector<Pair> pairs_;
};

}  // namespace waystone
