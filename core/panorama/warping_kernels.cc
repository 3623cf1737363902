// SPDX-License-Identifier: Apache-2.0
#include "core/panorama/warping_kernels.h"

#include <cstddef>
#include <cstring>

namespace waystone {
namespace {

// Written once and inlined into a function per instruction set: the compiler maps the lanes to the
// available registers.
#define WS_INLINE inline __attribute__((always_inline))

using Floats = float __attribute__((vector_size(4 * kWarpingFloats)));
using Ints = int32_t __attribute__((vector_size(4 * kWarpingFloats)));
using Bytes = uint8_t __attribute__((vector_size(kWarpingBytes)));

template <class Lanes, class Value>
WS_INLINE void Load(const Value* from, Lanes& to) {
  std::memcpy(&to, from, sizeof(Lanes));
}

constexpr int kTile = 5;  // registers of b's columns at a time

// Of `lanes` registers of b's columns from `first` on, for one column of a.
template <int kCount>
WS_INLINE void MultiplyTile(const ColumnProducts& products, int column, int first) {
  const int stride = FilledUp(products.columns, kWarpingFloats);
  Floats sums[kCount] = {};
  for (int row = 0; row < products.rows; ++row) {
    const float a = products.a[row * products.columns + column];
    const float* b = products.b + row * stride + first;
    for (int k = 0; k < kCount; ++k) {
      Floats lanes;
      Load(b + k * kWarpingFloats, lanes);
      sums[k] += a * lanes;
    }
  }
  uint8_t* costs = products.costs + column * products.row_bytes + first;
  for (int k = 0; k < kCount; ++k) {
    const Floats scaled = (1 - sums[k]) * products.levels + 0.5F;
    const Ints rounded = __builtin_convertvector(scaled, Ints);
    for (int lane = 0; lane < kWarpingFloats; ++lane) {
      costs[k * kWarpingFloats + lane] = static_cast<uint8_t>(rounded[lane]);
    }
  }
}

WS_INLINE void Multiply(const ColumnProducts& products) {
  const int stride = FilledUp(products.columns, kWarpingFloats);
  for (int column = 0; column < products.columns; ++column) {
    int first = 0;
    for (; first + kTile * kWarpingFloats <= stride; first += kTile * kWarpingFloats) {
      MultiplyTile<kTile>(products, column, first);
    }
    for (; first < stride; first += kWarpingFloats) MultiplyTile<1>(products, column, first);
  }
}

WS_INLINE void AddLeast(const ColumnMatches& matches, uint16_t* sums) {
  for (int column = 0; column < matches.columns; ++column) {
    const int motion = column - matches.angle + (column < matches.angle ? matches.columns : 0);
    uint16_t* of_motion = sums + static_cast<ptrdiff_t>(motion) * matches.turns;
    const int64_t at = column * matches.next_column;
    for (int first = 0; first < matches.turns; first += kWarpingBytes) {
      Bytes least;
      std::memset(&least, 0xff, sizeof(least));
      for (int s = 0; s < matches.count; ++s) {
        Bytes costs;
        Load(matches.steps[s].costs + at + first, costs);
        costs += matches.steps[s].penalty;
        least = costs < least ? costs : least;
      }
      for (int lane = 0; lane < kWarpingBytes; ++lane) of_motion[first + lane] += least[lane];
    }
  }
}

void MultiplyPortable(const ColumnProducts& products) { Multiply(products); }
void AddLeastPortable(const ColumnMatches& matches, uint16_t* sums) { AddLeast(matches, sums); }

#if defined(__x86_64__)
__attribute__((target("avx2"))) void MultiplyAvx2(const ColumnProducts& products) {
  Multiply(products);
}
__attribute__((target("avx2"))) void AddLeastAvx2(const ColumnMatches& matches, uint16_t* sums) {
  AddLeast(matches, sums);
}
#endif

#undef WS_INLINE

}  // namespace

std::vector<WarpingKernels> RunnableWarpingKernels() {
  std::vector<WarpingKernels> kernels = {{MultiplyPortable, AddLeastPortable}};
#if defined(__x86_64__)
  __builtin_cpu_init();
  if (__builtin_cpu_supports("avx2")) kernels.push_back({MultiplyAvx2, AddLeastAvx2});
#endif
  return kernels;
}

WarpingKernels FastestWarpingKernels() {
  static const WarpingKernels kFastest = RunnableWarpingKernels().back();
  return kFastest;
}

}  // namespace waystone
