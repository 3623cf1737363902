// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

// The inner loops of SearchWarping, with the processor's best instructions. All kernels are
// thread-safe.
namespace waystone {

// How many floats and bytes are processed together: rows of arrays are padded to multiples of
// these.
inline constexpr int kWarpingFloats = 8;
inline constexpr int kWarpingBytes = 32;

// The smallest multiple of `lanes` that is at least `count`.
constexpr int FilledUp(int count, int lanes) { return (count + lanes - 1) / lanes * lanes; }

// Products of the columns of two images, each of length 1.
struct ColumnProducts {
  int rows = 0;
  int columns = 0;           // of a; of b as many, filled up to kWarpingFloats
  const float* a = nullptr;  // row after row, `columns` each
  const float* b = nullptr;  // row after row, filled up
  float levels = 1;          // of the bytes, a unit
  uint8_t* costs = nullptr;  // of a's columns (rows) and b's: (1 - product) * levels, rounded
  int64_t row_bytes = 0;     // from one row of costs to the next
};

// A way to match the columns of a, at a cost of its own.
struct ColumnStep {
  // Of column 0 and the column of b that it goes to under turn 0; those of the turns follow.
  const uint8_t* costs = nullptr;
  uint8_t penalty = 0;
};

// Landmarks at one angle from the direction of motion, under all directions and turns.
struct ColumnMatches {
  const ColumnStep* steps = nullptr;
  int count = 0;
  int columns = 0;
  int64_t next_column = 0;  // bytes from a column's costs to the next one's
  int angle = 0;            // column c is seen at it when the motion goes to column c - angle
  int turns = 0;            // a multiple of kWarpingBytes
};

// The results are the same with any instruction set.
struct WarpingKernels {
  void (*multiply)(const ColumnProducts&);
  // Adds the least of the steps of each column to the sums, columns (motions) x turns.
  void (*add_least)(const ColumnMatches&, uint16_t* sums);
};

WarpingKernels FastestWarpingKernels();

// All kernels that this processor can run, the portable ones first: for tests.
std::vector<WarpingKernels> RunnableWarpingKernels();

}  // namespace waystone
