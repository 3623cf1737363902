// SPDX-License-Identifier: Apache-2.0
#include "core/features/distance.h"

#include <bit>
#include <cstring>

#if defined(__x86_64__)
// GCC 12 takes the undefined start values inside its own AVX-512 intrinsics for our mistake.
#pragma GCC diagnostic ignored "-Wuninitialized"
#if !defined(__clang__)
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized"
#endif
#include <immintrin.h>
#endif

namespace waystone {
namespace {

constexpr int kSiftBytes = 128;

void SquaredEuclidean(const uint8_t* query, const uint8_t* block, int rows, int bytes,
                      int32_t* out) {
  for (int r = 0; r < rows; ++r, block += bytes) {
    int32_t sum = 0;
    for (int i = 0; i < bytes; ++i) {
      const int difference = int{query[i]} - int{block[i]};
      sum += difference * difference;
    }
    out[r] = sum;
  }
}

// Inlined into a function per instruction set, so that popcount becomes one instruction there.
inline __attribute__((always_inline)) void HammingRows(const uint8_t* query, const uint8_t* block,
                                                       int rows, int bytes, int32_t* out) {
  for (int r = 0; r < rows; ++r, block += bytes) {
    int32_t sum = 0;
    int i = 0;
    for (; i + 8 <= bytes; i += 8) {
      uint64_t a;
      uint64_t b;
      std::memcpy(&a, query + i, 8);
      std::memcpy(&b, block + i, 8);
      sum += std::popcount(a ^ b);
    }
    for (; i < bytes; ++i) sum += std::popcount(static_cast<uint8_t>(query[i] ^ block[i]));
    out[r] = sum;
  }
}

void Hamming(const uint8_t* query, const uint8_t* block, int rows, int bytes, int32_t* out) {
  HammingRows(query, block, rows, bytes, out);
}

#if defined(__x86_64__)

__attribute__((target("popcnt"))) void HammingPopcnt(const uint8_t* query, const uint8_t* block,
                                                     int rows, int bytes, int32_t* out) {
  HammingRows(query, block, rows, bytes, out);
}

// Bytes are at most 127, so differences fit a signed byte and the sum of two squares fits 16 bits:
// one vpmaddubsw squares and adds pairs without saturating. The sum over `row` is that of the
// lanes.
__attribute__((target("avx2"))) inline __m256i LaneSums(const __m256i* q, const uint8_t* row) {
  const __m256i ones = _mm256_set1_epi16(1);
  __m256i sum = _mm256_setzero_si256();
  for (int k = 0; k < 4; ++k) {
    const __m256i bytes = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(row + 32 * k));
    const __m256i difference = _mm256_abs_epi8(_mm256_sub_epi8(q[k], bytes));
    const __m256i squares = _mm256_maddubs_epi16(difference, difference);
    sum = _mm256_add_epi32(sum, _mm256_madd_epi16(squares, ones));
  }
  return sum;
}

__attribute__((target("avx2"))) void SquaredEuclideanAvx2(const uint8_t* query,
                                                          const uint8_t* block, int rows, int bytes,
                                                          int32_t* out) {
  if (bytes != kSiftBytes) return SquaredEuclidean(query, block, rows, bytes, out);
  __m256i q[4];
  for (int k = 0; k < 4; ++k) {
    q[k] = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(query + 32 * k));
  }
  // Four rows at a time: their sums over lanes are taken together.
  int r = 0;
  for (; r + 4 <= rows; r += 4, block += 4 * kSiftBytes) {
    const __m256i s01 = _mm256_hadd_epi32(LaneSums(q, block), LaneSums(q, block + kSiftBytes));
    const __m256i s23 =
        _mm256_hadd_epi32(LaneSums(q, block + 2 * kSiftBytes), LaneSums(q, block + 3 * kSiftBytes));
    const __m256i all = _mm256_hadd_epi32(s01, s23);
    _mm_storeu_si128(reinterpret_cast<__m128i*>(out + r),
                     _mm_add_epi32(_mm256_castsi256_si128(all), _mm256_extracti128_si256(all, 1)));
  }
  for (; r < rows; ++r, block += kSiftBytes) {
    const __m256i sum = LaneSums(q, block);
    __m128i half = _mm_add_epi32(_mm256_castsi256_si128(sum), _mm256_extracti128_si256(sum, 1));
    half = _mm_add_epi32(half, _mm_shuffle_epi32(half, 0x4e));
    half = _mm_add_epi32(half, _mm_shuffle_epi32(half, 0xb1));
    out[r] = _mm_cvtsi128_si32(half);
  }
}

__attribute__((target("avx512f,avx512bw"))) void SquaredEuclideanAvx512(const uint8_t* query,
                                                                        const uint8_t* block,
                                                                        int rows, int bytes,
                                                                        int32_t* out) {
  if (bytes != kSiftBytes) return SquaredEuclidean(query, block, rows, bytes, out);
  const __m512i ones = _mm512_set1_epi16(1);
  const __m512i q0 = _mm512_loadu_si512(query);
  const __m512i q1 = _mm512_loadu_si512(query + 64);
  for (int r = 0; r < rows; ++r, block += kSiftBytes) {
    const __m512i d0 = _mm512_abs_epi8(_mm512_sub_epi8(q0, _mm512_loadu_si512(block)));
    const __m512i d1 = _mm512_abs_epi8(_mm512_sub_epi8(q1, _mm512_loadu_si512(block + 64)));
    const __m512i s0 = _mm512_madd_epi16(_mm512_maddubs_epi16(d0, d0), ones);
    const __m512i s1 = _mm512_madd_epi16(_mm512_maddubs_epi16(d1, d1), ones);
    out[r] = _mm512_reduce_add_epi32(_mm512_add_epi32(s0, s1));
  }
}

#endif

}  // namespace

std::vector<NamedKernel> RunnableKernels(FeatureType type) {
  std::vector<NamedKernel> kernels;
  const bool sift = type == FeatureType::kSift;
  kernels.push_back({"portable", sift ? SquaredEuclidean : Hamming});
#if defined(__x86_64__)
  __builtin_cpu_init();
  if (!sift && __builtin_cpu_supports("popcnt")) kernels.push_back({"popcnt", HammingPopcnt});
  if (sift && __builtin_cpu_supports("avx2")) kernels.push_back({"avx2", SquaredEuclideanAvx2});
  if (sift && __builtin_cpu_supports("avx512bw")) {
    kernels.push_back({"avx512bw", SquaredEuclideanAvx512});
  }
#endif
  return kernels;
}

DistanceKernel FastestKernel(FeatureType type) {
  static const DistanceKernel sift = RunnableKernels(FeatureType::kSift).back().kernel;
  static const DistanceKernel binary = RunnableKernels(FeatureType::kOrb).back().kernel;
  return type == FeatureType::kSift ? sift : binary;
}

}  // namespace waystone
