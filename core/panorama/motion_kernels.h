// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

// The inner loops of RefineSmallMotion, with the processor's best instructions. All kernels are
// thread-safe.
namespace waystone {

// How many columns are processed together. Arrays of pixels come in blocks of this many columns,
// row after row in each.
inline constexpr int kMotionLanes = 8;

// What a column's pixels add to the normal equations: products of a pixel's slopes along azimuth
// and elevation (u, v), v times the row's lift (lv), its grey value in a, and its residual r.
enum Moment { kUU, kUV, kVV, kULv, kVLv, kLvLv, kUA, kVA, kLvA, kAA, kRU, kRV, kRLv, kRA, kRR };
inline constexpr int kMoments = kRR + 1;

// Columns of b between which those of a block lie.
struct TurnedBlock {
  int rows = 0;
  int columns = 0;
  const float* b = nullptr;   // row after row
  const int* left = nullptr;  // of each column
  const int* right = nullptr;
  const float* part = nullptr;  // of the way from left to right
  float columns_per_rad = 1;
};

// A block of a and the columns of b that the motion brings there, which it moves up by lift * lifts
// + tilts rows.
struct MotionBlock {
  int rows = 0;
  const float* lift = nullptr;    // of each row
  const float* a = nullptr;       // pixels: grey values
  const float* b = nullptr;       // pixels: grey values
  const float* slope = nullptr;   // pixels: of b along the azimuth
  const float* lifts = nullptr;   // of each column
  const float* tilts = nullptr;   // of each column
  const float* inside = nullptr;  // of each column: 1, or 0 for one that pads the last block
  float gain = 1;                 // b over a
  float rows_per_rad = 1;
};

// The result, pixels: `weight` is 1, or 0 where b doesn't show the point.
struct MotionPixels {
  float* residual = nullptr;
  float* u = nullptr;
  float* v = nullptr;
  float* weight = nullptr;
};

// For a block's columns at azimuth t, where landmarks have this nearness: what their derivatives by
// the parameters are composed of.
struct MotionColumns {
  const float* cosine = nullptr;  // of t
  const float* sine = nullptr;
  const float* cosine2 = nullptr;  // of 2t
  const float* sine2 = nullptr;
  const float* nearness = nullptr;
  const float* aside = nullptr;  // m sin t - n cos t of a motion (m, n)
  const float* along = nullptr;  // m cos t + n sin t
};

// Entries of the normal equations: the lower triangle of the information matrix, row after row,
// then the gradient. The parameters are those of RefineSmallMotion: turn, motion (2), tilt (2),
// gain, waves of the nearness (4).
inline constexpr int kMotionParameters = 10;
inline constexpr int kMotionTriangle = kMotionParameters * (kMotionParameters + 1) / 2;
inline constexpr int kMotionEntries = kMotionTriangle + kMotionParameters;

// The results are the same with any instruction set: nothing is summed across columns.
struct MotionKernels {
  // Grey values and their slopes along the azimuth, pixels.
  void (*turn)(const TurnedBlock&, float* grey, float* slope);
  void (*sample)(const MotionBlock&, const MotionPixels&);
  // The moments of each column, kMoments x kMotionLanes, with Cauchy's weights
  // 1 / (1 + (residual * per_sigma)^2).
  void (*sum)(const MotionBlock&, const MotionPixels&, float per_sigma, float* moments);
  // Adds what each column's moments say of each entry, kMotionEntries x kMotionLanes.
  void (*add)(const MotionColumns&, const float* moments, float* entries);
};

MotionKernels FastestMotionKernels();

// All kernels that this processor can run, the portable ones first: for tests.
std::vector<MotionKernels> RunnableMotionKernels();

}  // namespace waystone
