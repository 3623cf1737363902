// SPDX-License-Identifier: Apache-2.0
#include "core/panorama/motion_kernels.h"

#include <cstdint>
#include <cstring>

namespace waystone {
namespace {

// Written once and inlined into a function per instruction set: the compiler maps the lanes to the
// available registers.
#define WS_INLINE inline __attribute__((always_inline))

using Lanes = float __attribute__((vector_size(4 * kMotionLanes)));
using MotionInts = int32_t __attribute__((vector_size(4 * kMotionLanes)));

WS_INLINE void Load(const float* from, Lanes& to) { std::memcpy(&to, from, sizeof(Lanes)); }
WS_INLINE void Store(const Lanes& from, float* to) { std::memcpy(to, &from, sizeof(Lanes)); }

WS_INLINE void TurnBlock(const TurnedBlock& block, float* grey, float* slope) {
  int left[kMotionLanes];
  int right[kMotionLanes];
  std::memcpy(left, block.left, sizeof(left));
  std::memcpy(right, block.right, sizeof(right));
  Lanes part;
  Load(block.part, part);
  const float* b = block.b;
  for (int row = 0; row < block.rows; ++row, b += block.columns) {
    Lanes from;
    Lanes to;
    for (int k = 0; k < kMotionLanes; ++k) {
      from[k] = b[left[k]];
      to[k] = b[right[k]];
    }
    Store(from + part * (to - from), grey + row * kMotionLanes);
    Store((to - from) * block.columns_per_rad, slope + row * kMotionLanes);
  }
}

WS_INLINE void SampleBlock(const MotionBlock& block, const MotionPixels& pixels) {
  Lanes lifts;
  Lanes tilts;
  Lanes inside;
  Load(block.lifts, lifts);
  Load(block.tilts, tilts);
  Load(block.inside, inside);
  const auto last = static_cast<float>(block.rows - 1);
  for (int row = 0; row < block.rows; ++row) {
    const int at = row * kMotionLanes;
    const Lanes y = static_cast<float>(row) - block.lift[row] * lifts - tilts;
    const MotionInts shows = (y >= 0) & (y < last);  // -1 where it does
    const Lanes shown = -__builtin_convertvector(shows, Lanes);
    const Lanes from = shown * y;
    const MotionInts upper = __builtin_convertvector(from, MotionInts);
    const Lanes part = from - __builtin_convertvector(upper, Lanes);
    Lanes above;
    Lanes below;
    Lanes slope_above;
    Lanes slope_below;
    for (int k = 0; k < kMotionLanes; ++k) {
      const int pixel = upper[k] * kMotionLanes + k;
      above[k] = block.b[pixel];
      below[k] = block.b[pixel + kMotionLanes];
      slope_above[k] = block.slope[pixel];
      slope_below[k] = block.slope[pixel + kMotionLanes];
    }
    Lanes a;
    Load(block.a + at, a);
    Store(above + part * (below - above) - block.gain * a, pixels.residual + at);
    Store(slope_above + part * (slope_below - slope_above), pixels.u + at);
    Store((above - below) * block.rows_per_rad, pixels.v + at);
    Store(shown * inside, pixels.weight + at);
  }
}

WS_INLINE void SumBlock(const MotionBlock& block, const MotionPixels& pixels, float per_sigma,
                        float* moments) {
  Lanes sums[kMoments] = {};
  for (int row = 0; row < block.rows; ++row) {
    const int at = row * kMotionLanes;
    Lanes r;
    Lanes u;
    Lanes v;
    Lanes a;
    Lanes weight;
    Load(pixels.residual + at, r);
    Load(pixels.u + at, u);
    Load(pixels.v + at, v);
    Load(block.a + at, a);
    Load(pixels.weight + at, weight);
    const Lanes share = r * per_sigma;
    weight = weight / (1 + share * share);
    const Lanes lv = block.lift[row] * v;
    const Lanes wu = weight * u;
    const Lanes wv = weight * v;
    const Lanes wlv = weight * lv;
    const Lanes wa = weight * a;
    const Lanes wr = weight * r;
    sums[kUU] += wu * u;
    sums[kUV] += wu * v;
    sums[kVV] += wv * v;
    sums[kULv] += wu * lv;
    sums[kVLv] += wv * lv;
    sums[kLvLv] += wlv * lv;
    sums[kUA] += wu * a;
    sums[kVA] += wv * a;
    sums[kLvA] += wlv * a;
    sums[kAA] += wa * a;
    sums[kRU] += wr * u;
    sums[kRV] += wr * v;
    sums[kRLv] += wr * lv;
    sums[kRA] += wr * a;
    sums[kRR] += wr * r;
  }
  for (int m = 0; m < kMoments; ++m) Store(sums[m], moments + m * kMotionLanes);
}

// Adds to the current entry, and advances to the next.
WS_INLINE void AddTo(const Lanes& value, float*& entry) {
  Lanes sum;
  Load(entry, sum);
  Store(sum + value, entry);
  entry += kMotionLanes;
}

// A slope x u + y lv of a pixel.
struct Slope {
  Lanes x;
  Lanes y;
};

WS_INLINE void AddBlock(const MotionColumns& columns, const float* moments, float* entries) {
  Lanes m[kMoments];
  for (int k = 0; k < kMoments; ++k) Load(moments + k * kMotionLanes, m[k]);
  Lanes c;
  Lanes s;
  Lanes near;
  Lanes aside;
  Lanes along;
  Lanes waves[4];
  Load(columns.cosine, c);
  Load(columns.sine, s);
  Load(columns.nearness, near);
  Load(columns.aside, aside);
  Load(columns.along, along);
  waves[0] = c;
  waves[1] = s;
  Load(columns.cosine2, waves[2]);
  Load(columns.sine2, waves[3]);
  // The motion's two slopes, and what the waves' have in common; the others are u, c v, s v and -a.
  const Slope slopes[3] = {{near * s, near * c}, {-near * c, near * s}, {aside, along}};
  Lanes of_u[3];  // products with u, v, a, r
  Lanes of_v[3];
  Lanes of_a[3];
  Lanes of_r[3];
  for (int k = 0; k < 3; ++k) {
    of_u[k] = slopes[k].x * m[kUU] + slopes[k].y * m[kULv];
    of_v[k] = slopes[k].x * m[kUV] + slopes[k].y * m[kVLv];
    of_a[k] = slopes[k].x * m[kUA] + slopes[k].y * m[kLvA];
    of_r[k] = slopes[k].x * m[kRU] + slopes[k].y * m[kRLv];
  }
  Lanes of_each[3][3];
  for (int k = 0; k < 3; ++k) {
    const Lanes of_lv = slopes[k].x * m[kULv] + slopes[k].y * m[kLvLv];
    for (int l = 0; l <= k; ++l) of_each[k][l] = slopes[l].x * of_u[k] + slopes[l].y * of_lv;
  }
  constexpr int kFirst = 21;  // entries without waves
  const Lanes first[kFirst] = {
      m[kUU],                                                                    // turn
      of_u[0],    of_each[0][0],                                                 // to the front
      of_u[1],    of_each[1][0], of_each[1][1],                                  // to the right
      c * m[kUV], c * of_v[0],   c * of_v[1],   c * c * m[kVV],                  // tilt
      s * m[kUV], s * of_v[0],   s * of_v[1],   s * c * m[kVV], s * s * m[kVV],  //
      -m[kUA],    -of_a[0],      -of_a[1],      -c * m[kVA],    -s * m[kVA],    m[kAA]};  // gain
  const Lanes with_wave[6] = {of_u[2],     of_each[2][0], of_each[2][1],
                              c * of_v[2], s * of_v[2],   -of_a[2]};
  for (const Lanes& value : first) AddTo(value, entries);
  for (int wave = 0; wave < 4; ++wave) {
    for (const Lanes& other : with_wave) AddTo(waves[wave] * other, entries);
    for (int l = 0; l <= wave; ++l) AddTo(waves[wave] * waves[l] * of_each[2][2], entries);
  }
  const Lanes gradient[6] = {m[kRU], of_r[0], of_r[1], c * m[kRV], s * m[kRV], -m[kRA]};
  for (const Lanes& value : gradient) AddTo(value, entries);
  for (const Lanes& wave : waves) AddTo(wave * of_r[2], entries);
}

void TurnPortable(const TurnedBlock& block, float* grey, float* slope) {
  TurnBlock(block, grey, slope);
}
void SamplePortable(const MotionBlock& block, const MotionPixels& pixels) {
  SampleBlock(block, pixels);
}
void SumPortable(const MotionBlock& block, const MotionPixels& pixels, float per_sigma,
                 float* moments) {
  SumBlock(block, pixels, per_sigma, moments);
}

void AddPortable(const MotionColumns& columns, const float* moments, float* entries) {
  AddBlock(columns, moments, entries);
}

#if defined(__x86_64__)
__attribute__((target("avx2"))) void TurnAvx2(const TurnedBlock& block, float* grey, float* slope) {
  TurnBlock(block, grey, slope);
}
__attribute__((target("avx2"))) void AddAvx2(const MotionColumns& columns, const float* moments,
                                             float* entries) {
  AddBlock(columns, moments, entries);
}
__attribute__((target("avx2"))) void SampleAvx2(const MotionBlock& block,
                                                const MotionPixels& pixels) {
  SampleBlock(block, pixels);
}
__attribute__((target("avx2"))) void SumAvx2(const MotionBlock& block, const MotionPixels& pixels,
                                             float per_sigma, float* moments) {
  SumBlock(block, pixels, per_sigma, moments);
}
#endif

#undef WS_INLINE

}  // namespace

std::vector<MotionKernels> RunnableMotionKernels() {
  std::vector<MotionKernels> kernels = {{TurnPortable, SamplePortable, SumPortable, AddPortable}};
#if defined(__x86_64__)
  __builtin_cpu_init();
  if (__builtin_cpu_supports("avx2")) kernels.push_back({TurnAvx2, SampleAvx2, SumAvx2, AddAvx2});
#endif
  return kernels;
}

MotionKernels FastestMotionKernels() {
  static const MotionKernels kFastest = RunnableMotionKernels().back();
  return kFastest;
}

}  // namespace waystone
