// SPDX-License-Identifier: Apache-2.0
#include "core/homography/binary_energy.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <vector>

#include "core/base/random.h"

namespace waystone {
namespace {

struct PairCosts {
  int i;
  int j;
  double v[4];  // of 00, 01, 10, 11
};

// Random costs, those of pairs submodular: the cut's condition.
struct MadeEnergy {
  std::vector<double> single;
  std::vector<PairCosts> pairs;

  MadeEnergy(int variables, int pair_count, double pair_scale, Random& random) {
    for (int i = 0; i < variables; ++i) single.push_back(random.Uniform(-1, 1));
    for (int p = 0; p < pair_count; ++p) {
      const int i = random.Below(variables);
      const int j = (i + 1 + random.Below(variables - 1)) % variables;
      PairCosts pair{i, j, {}};
      for (double& cost : pair.v) cost = random.Uniform(0, pair_scale);
      const double lacking = pair.v[0] + pair.v[3] - pair.v[1] - pair.v[2];
      pair.v[1] += std::max(0.0, lacking);
      pairs.push_back(pair);
    }
  }

  template <class Values>
  double Of(const Values& x) const {
    double cost = 0;
    for (size_t i = 0; i < single.size(); ++i) cost += x[i] ? single[i] : 0;
    for (const PairCosts& pair : pairs) cost += pair.v[2 * x[pair.i] + x[pair.j]];
    return cost;
  }

  std::vector<bool> Minimise() const {
    BinaryEnergy energy(static_cast<int>(single.size()));
    for (int i = 0; i < std::ssize(single); ++i) energy.Add(i, single[i]);
    for (const PairCosts& pair : pairs) {
      energy.Add(pair.i, pair.j, pair.v[0], pair.v[1], pair.v[2], pair.v[3]);
    }
    return energy.Minimise();
  }

  double LeastByTryingAll() const {
    double least = std::numeric_limits<double>::max();
    const auto variables = single.size();
    for (unsigned code = 0; code < 1U << variables; ++code) {
      std::vector<int> x;
      for (size_t i = 0; i < variables; ++i) x.push_back((code >> i) & 1);
      least = std::min(least, Of(x));
    }
    return least;
  }
};

TEST(BinaryEnergy, IsAsLowAsTryingAllFinds) {
  Random random(1);
  for (int trial = 0; trial < 300; ++trial) {
    const int variables = 2 + trial % 9;
    // From pairs that hardly matter to pairs that decide everything.
    const double pair_scale = 0.05 * (1 << trial % 7);
    const MadeEnergy made(variables, trial % 25, pair_scale, random);
    EXPECT_NEAR(made.Of(made.Minimise()), made.LeastByTryingAll(), 1e-9) << trial;
  }
}

TEST(BinaryEnergy, OfNothing) { EXPECT_TRUE(BinaryEnergy(0).Minimise().empty()); }

TEST(BinaryEnergy, GainsThatOnlyPairsHaveTogether) {
  // Neither gains alone, both do together.
  BinaryEnergy energy(2);
  energy.Add(0, 1.0);
  energy.Add(1, 1.0);
  energy.Add(0, 1, 3.0, 3.0, 3.0, 0.0);
  EXPECT_EQ(energy.Minimise(), (std::vector<bool>{true, true}));
}

// The other variable of its only pair is decided, and rounding leaves open what itself gains.
TEST(BinaryEnergy, AVariableThatRoundingLeavesOpenIsDecidedAlone) {
  BinaryEnergy energy(2);
  energy.Add(0, -5);
  energy.Add(1, -1e-17);
  energy.Add(0, 1, 0, 0.3, 0, 0);
  EXPECT_EQ(energy.Minimise(), (std::vector<bool>{true, true}));
}

}  // namespace
}  // namespace waystone
