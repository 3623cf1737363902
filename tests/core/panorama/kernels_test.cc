// SPDX-License-Identifier: Apache-2.0
// The compass's inner loops: against plain sums, and the same by all instructions.
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "core/base/random.h"
#include "core/panorama/motion_kernels.h"
#include "core/panorama/warping_kernels.h"

namespace waystone {
namespace {

constexpr int kRows = 12;
constexpr int kPixels = kRows * kMotionLanes;
constexpr float kPerSigma = 0.7F;

std::vector<float> Noise(int count, double scale, uint64_t seed) {
  Random random(seed);
  std::vector<float> values(count);
  for (float& value : values) value = static_cast<float>(scale * random.Normal());
  return values;
}

// A block with its inputs and all that the kernels make of it.
struct Worked {
  std::vector<float> lift = Noise(kRows, 0.3, 1);
  std::vector<float> a = Noise(kPixels, 1, 2);
  std::vector<float> lifts = Noise(kMotionLanes, 2, 4);
  std::vector<float> tilts = Noise(kMotionLanes, 1, 5);
  std::vector<float> inside = std::vector<float>(kMotionLanes, 1);
  std::vector<float> columns = Noise(20 * kRows, 1, 6);  // of b
  std::vector<int> left = {3, 4, 5, 6, 8, 9, 19, 0};
  std::vector<int> right = {4, 5, 6, 7, 9, 10, 0, 1};
  std::vector<float> part = {0, 0.2F, 0.5F, 0.9F, 0.1F, 0.3F, 0.7F, 0.4F};
  std::vector<float> b = std::vector<float>(kPixels);
  std::vector<float> slope = std::vector<float>(kPixels);
  std::vector<float> residual = std::vector<float>(kPixels);
  std::vector<float> u = std::vector<float>(kPixels);
  std::vector<float> v = std::vector<float>(kPixels);
  std::vector<float> weight = std::vector<float>(kPixels);
  std::vector<float> moments = std::vector<float>(kMoments * kMotionLanes);
  std::vector<float> entries = std::vector<float>(kMotionEntries * kMotionLanes, 0);
  // Of the columns' slopes, one after the other as MotionColumns has them.
  std::vector<float> of_columns = Noise(7 * kMotionLanes, 1, 7);

  explicit Worked(const MotionKernels& kernels) {
    inside.back() = 0;
    kernels.turn({kRows, 20, columns.data(), left.data(), right.data(), part.data(), 3}, b.data(),
                 slope.data());
    const MotionBlock block = {kRows,        lift.data(),  a.data(),      b.data(), slope.data(),
                               lifts.data(), tilts.data(), inside.data(), 1.1F,     20};
    const MotionPixels pixels = {residual.data(), u.data(), v.data(), weight.data()};
    kernels.sample(block, pixels);
    kernels.sum(block, pixels, kPerSigma, moments.data());
    const auto at = [&](int i) { return of_columns.data() + i * kMotionLanes; };
    kernels.add({at(0), at(1), at(2), at(3), at(4), at(5), at(6)}, moments.data(), entries.data());
  }
};

TEST(MotionKernels, AreTheSameByAllInstructions) {
  if (RunnableMotionKernels().size() < 2)
    GTEST_SKIP() << "this processor has the portable ones alone";
  const Worked portable(RunnableMotionKernels().front());
  for (const MotionKernels& kernels : RunnableMotionKernels()) {
    const Worked worked(kernels);
    EXPECT_EQ(worked.b, portable.b);
    EXPECT_EQ(worked.slope, portable.slope);
    EXPECT_EQ(worked.residual, portable.residual);
    EXPECT_EQ(worked.weight, portable.weight);
    EXPECT_EQ(worked.moments, portable.moments);
    EXPECT_EQ(worked.entries, portable.entries);
  }
}

TEST(MotionKernels, SampleBetweenTheRowsAndColumns) {
  const Worked worked(FastestMotionKernels());
  int shown = 0;
  for (int row = 0; row < kRows; ++row) {
    for (int k = 0; k < kMotionLanes; ++k) {
      const int at = row * kMotionLanes + k;
      const auto turned = [&](int of_row) {
        const float from = worked.columns[of_row * 20 + worked.left[k]];
        return from + worked.part[k] * (worked.columns[of_row * 20 + worked.right[k]] - from);
      };
      const double y = row - worked.lift[row] * worked.lifts[k] - worked.tilts[k];
      if (y < 0 || y >= kRows - 1) {
        EXPECT_EQ(worked.weight[at], 0);
        continue;
      }
      EXPECT_EQ(worked.weight[at], worked.inside[k]);
      const int upper = static_cast<int>(y);
      const double value =
          turned(upper) + (y - upper) * (turned(upper + 1) - turned(upper)) - 1.1 * worked.a[at];
      EXPECT_NEAR(worked.residual[at], value, 1e-4);
      EXPECT_NEAR(worked.v[at], 20 * (turned(upper) - turned(upper + 1)), 1e-3);
      ++shown;
    }
  }
  EXPECT_GT(shown, kPixels / 2);
}

// The slopes of RefineSmallMotion's header, pixel by pixel.
TEST(MotionKernels, AddTheNormalEquations) {
  const Worked worked(FastestMotionKernels());
  for (int k = 0; k < kMotionLanes; ++k) {
    const auto of = [&](int i) -> double { return worked.of_columns[i * kMotionLanes + k]; };
    const double c = of(0);
    const double s = of(1);
    const double near = of(4);
    Eigen::Matrix<double, kMotionParameters, kMotionParameters> information;
    Eigen::Matrix<double, kMotionParameters, 1> gradient;
    information.setZero();
    gradient.setZero();
    for (int row = 0; row < kRows; ++row) {
      const int at = row * kMotionLanes + k;
      const double u = worked.u[at];
      const double v = worked.v[at];
      const double lv = worked.lift[row] * v;
      const double common = of(5) * u + of(6) * lv;
      Eigen::Matrix<double, kMotionParameters, 1> slope;
      slope << u, near * (u * s + lv * c), near * (-u * c + lv * s), v * c, v * s, -worked.a[at],
          common * c, common * s, common * of(2), common * of(3);
      const double r = worked.residual[at];
      const double share = r * kPerSigma;
      const double weight = worked.weight[at] / (1 + share * share);
      information += weight * slope * slope.transpose();
      gradient += weight * r * slope;
    }
    const float* entry = worked.entries.data() + k;
    const double tolerance = 1e-5 * (1 + information.cwiseAbs().maxCoeff());
    for (int row = 0; row < kMotionParameters; ++row) {
      for (int column = 0; column <= row; ++column, entry += kMotionLanes) {
        EXPECT_NEAR(*entry, information(row, column), tolerance) << row << " " << column;
      }
    }
    for (int row = 0; row < kMotionParameters; ++row, entry += kMotionLanes) {
      EXPECT_NEAR(*entry, gradient[row], tolerance) << row;
    }
  }
}

TEST(WarpingKernels, MultiplyColumns) {
  for (const int columns : {24, 30, 72, 100}) {
    const int filled = FilledUp(columns, kWarpingFloats);
    const std::vector<float> a = Noise(kRows * columns, 0.2, 1);
    const std::vector<float> b = Noise(kRows * filled, 0.2, 2);
    const int64_t row_bytes = 2 * columns + kWarpingBytes;
    std::vector<std::vector<uint8_t>> all;
    for (const WarpingKernels& kernels : RunnableWarpingKernels()) {
      std::vector<uint8_t>& costs = all.emplace_back(columns * row_bytes);
      kernels.multiply({kRows, columns, a.data(), b.data(), 100, costs.data(), row_bytes});
      EXPECT_EQ(costs, all.front());
    }
    for (int i = 0; i < columns; i += 7) {
      for (int j = 0; j < columns; j += 5) {
        double product = 0;
        for (int row = 0; row < kRows; ++row) {
          product += double{a[row * columns + i]} * b[row * filled + j];
        }
        if (std::abs(product) > 1) continue;  // beyond what columns of length 1 have
        EXPECT_NEAR(all.front()[i * row_bytes + j], 100 * (1 - product), 0.51);
      }
    }
  }
}

TEST(WarpingKernels, AddTheLeastStep) {
  constexpr int kColumns = 5;
  constexpr int kTurns = 3 * kWarpingBytes;
  constexpr int kNext = 150;  // bytes to the next column
  constexpr int kAngle = 2;
  Random random(1);
  std::vector<uint8_t> costs(kColumns * kNext + kTurns);
  for (uint8_t& cost : costs) cost = static_cast<uint8_t>(random.Below(200));
  const std::vector<ColumnStep> steps = {
      {costs.data(), 40}, {costs.data() + 31, 0}, {costs.data() + 100, 7}};
  for (const WarpingKernels& kernels : RunnableWarpingKernels()) {
    std::vector<uint16_t> sums(kColumns * kTurns, 1000);
    kernels.add_least({steps.data(), 3, kColumns, kNext, kAngle, kTurns}, sums.data());
    for (int column = 0; column < kColumns; ++column) {
      const int motion = (column - kAngle + kColumns) % kColumns;
      for (int turn = 0; turn < kTurns; ++turn) {
        const uint8_t* at = costs.data() + column * kNext + turn;
        EXPECT_EQ(sums[motion * kTurns + turn],
                  1000 + std::min({at[0] + 40, int{at[31]}, at[100] + 7}));
      }
    }
  }
}

}  // namespace
}  // namespace waystone
