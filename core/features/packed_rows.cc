// SPDX-License-Identifier: Apache-2.0
#include "core/features/packed_rows.h"

#include <algorithm>
#include <bit>
#include <cstring>

#if defined(__x86_64__)
// GCC 12 warns of undefined start values inside its own AVX-512 intrinsics.
#pragma GCC diagnostic ignored "-Wuninitialized"
#if !defined(__clang__)
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized"
#endif
#include <immintrin.h>
#endif

#include "core/base/check.h"

namespace waystone {
namespace {

constexpr int kWordBytes = 4;
constexpr int kBlockWordBytes = kWordBytes * kPackRows;
constexpr uint8_t kSiftByteMax = 127;
// A sum of products of bytes in an unsigned lane of 16 bits.
constexpr int32_t kMaxNarrow = 0xffff;

// A register of 64 bytes holds two words of each row of a block, one in either half.
constexpr int kWordsTogether = 2;

int WordsOf(FeatureType type) {
  constexpr int kBytesTogether = kWordsTogether * kWordBytes;
  return (DescriptorBytes(type) + kBytesTogether - 1) / kBytesTogether * kWordsTogether;
}

// Squared lengths of what the lower and the upper lane of 16 bits sum up.
struct Squares {
  int32_t low = 0;
  int32_t high = 0;

  bool AreNarrow() const { return low <= kMaxNarrow && high <= kMaxNarrow; }
};

Squares SumSquares(const uint8_t* row, int bytes) {
  Squares squares;
  for (int i = 0; i < bytes; ++i) {
    const int32_t square = int32_t{row[i]} * row[i];
    (i % kWordBytes < 2 ? squares.low : squares.high) += square;
  }
  return squares;
}

using RowBytes = std::array<uint8_t, sizeof(PackedQuery::words)>;

// A row clamped to the values that ExtractFeatures gives. A map of another program may have larger
// ones, for which the sums of pairs below would overflow, and distances would depend on the
// processor.
RowBytes BoundedRow(FeatureType type, const uint8_t* row) {
  RowBytes bounded{};
  std::memcpy(bounded.data(), row, DescriptorBytes(type));
  if (type == FeatureType::kSift) {
    for (uint8_t& byte : bounded) byte = std::min(byte, kSiftByteMax);
  }
  return bounded;
}

uint32_t WordAt(const uint8_t* bytes) {
  uint32_t word;
  std::memcpy(&word, bytes, kWordBytes);
  return word;
}

int32_t DotOf(uint32_t a, uint32_t b) {
  int32_t sum = 0;
  for (int shift = 0; shift < 32; shift += 8) {
    sum += static_cast<int32_t>((a >> shift) & 255) * static_cast<int32_t>((b >> shift) & 255);
  }
  return sum;
}

void Portable(const PackedQuery& query, const PackedRows& rows, int first, int count, int32_t limit,
              int32_t* out, uint8_t* near) {
  const bool sift = rows.type() == FeatureType::kSift;
  for (int b = 0; b < count; ++b, out += kPackRows) {
    const uint8_t* block = rows.block(first + b);
    const int32_t* bias = rows.bias(first + b);
    near[b] = 0;
    for (int i = 0; i < kPackRows; ++i) {
      int32_t sum = 0;
      for (int w = 0; w < rows.words(); ++w) {
        const uint32_t word = WordAt(block + w * kBlockWordBytes + i * kWordBytes);
        sum += sift ? -2 * DotOf(query.words[w], word) : std::popcount(query.words[w] ^ word);
      }
      out[i] = bias[i] + query.square + sum;
      if (out[i] <= limit) near[b] |= static_cast<uint8_t>(1 << i);
    }
  }
}

#if defined(__x86_64__)

#define WAYSTONE_AVX2 __attribute__((target("avx2"), always_inline)) inline

WAYSTONE_AVX2 __m256i Load(const void* from) {
  return _mm256_loadu_si256(static_cast<const __m256i*>(from));
}

WAYSTONE_AVX2 void Store(__m256i distances, int32_t limit, int32_t* out, uint8_t* near) {
  _mm256_storeu_si256(reinterpret_cast<__m256i*>(out), distances);
  const __m256i beyond = _mm256_cmpgt_epi32(distances, _mm256_set1_epi32(limit));
  *near = static_cast<uint8_t>(~_mm256_movemask_ps(_mm256_castsi256_ps(beyond)));
}

// Sums of pairs of products stay below 2^15 because bytes are at most 127. Where the lengths allow
// it, they are added up in lanes of 16 bits, which saves half of the instructions.
template <bool kNarrow>
WAYSTONE_AVX2 __m256i AddProducts(__m256i sum, __m256i a, __m256i b) {
  const __m256i pairs = _mm256_maddubs_epi16(a, b);
  if (kNarrow) return _mm256_add_epi16(sum, pairs);
  return _mm256_add_epi32(sum, _mm256_madd_epi16(pairs, _mm256_set1_epi16(1)));
}

template <bool kNarrow>
WAYSTONE_AVX2 __m256i DotsOf(__m256i sum) {
  if (!kNarrow) return sum;
  const __m256i low = _mm256_and_si256(sum, _mm256_set1_epi32(kMaxNarrow));
  return _mm256_add_epi32(low, _mm256_srli_epi32(sum, 16));
}

// kBlocks at a time: each word of the query is broadcast once for all of them, and their sums don't
// wait for each other.
template <bool kNarrow, int kBlocks>
WAYSTONE_AVX2 void EuclideanBlocks(const PackedQuery& query, const PackedRows& rows, int first,
                                   int32_t limit, int32_t* out, uint8_t* near) {
  const int words = rows.words();
  const int block_bytes = words * kBlockWordBytes;
  const uint8_t* data = rows.block(first);
  __m256i sums[kBlocks];
  for (int b = 0; b < kBlocks; ++b) sums[b] = _mm256_setzero_si256();
  for (int w = 0; w < words; ++w, data += kBlockWordBytes) {
    const __m256i q = _mm256_set1_epi32(static_cast<int32_t>(query.words[w]));
    for (int b = 0; b < kBlocks; ++b) {
      sums[b] = AddProducts<kNarrow>(sums[b], q, Load(data + b * block_bytes));
    }
  }
  const __m256i square = _mm256_set1_epi32(query.square);
  for (int b = 0; b < kBlocks; ++b) {
    const __m256i dots = DotsOf<kNarrow>(sums[b]);
    const __m256i squares = _mm256_add_epi32(square, Load(rows.bias(first + b)));
    Store(_mm256_sub_epi32(squares, _mm256_add_epi32(dots, dots)), limit, out + b * kPackRows,
          near + b);
  }
}

template <bool kNarrow>
__attribute__((target("avx2"))) void Euclidean(const PackedQuery& query, const PackedRows& rows,
                                               int first, int count, int32_t limit, int32_t* out,
                                               uint8_t* near) {
  constexpr int kTogether = 4;
  int b = 0;
  for (; b + kTogether <= count; b += kTogether) {
    EuclideanBlocks<kNarrow, kTogether>(query, rows, first + b, limit, out + b * kPackRows,
                                        near + b);
  }
  for (; b + 2 <= count; b += 2) {
    EuclideanBlocks<kNarrow, 2>(query, rows, first + b, limit, out + b * kPackRows, near + b);
  }
  for (; b < count; ++b) {
    EuclideanBlocks<kNarrow, 1>(query, rows, first + b, limit, out + b * kPackRows, near + b);
  }
}

// Bits of the bytes by a table of nibbles; at most 16 words of 8 bits a byte fit one.
__attribute__((target("avx2"))) void Hamming(const PackedQuery& query, const PackedRows& rows,
                                             int first, int count, int32_t limit, int32_t* out,
                                             uint8_t* near) {
  const __m256i table = _mm256_setr_epi8(0, 1, 1, 2, 1, 2, 2, 3, 1, 2, 2, 3, 2, 3, 3, 4, 0, 1, 1, 2,
                                         1, 2, 2, 3, 1, 2, 2, 3, 2, 3, 3, 4);
  const __m256i nibble = _mm256_set1_epi8(15);
  for (int b = 0; b < count; ++b, out += kPackRows) {
    const uint8_t* block = rows.block(first + b);
    __m256i sum = _mm256_setzero_si256();
    for (int w = 0; w < rows.words(); ++w, block += kBlockWordBytes) {
      const __m256i q = _mm256_set1_epi32(static_cast<int32_t>(query.words[w]));
      const __m256i bits = _mm256_xor_si256(q, Load(block));
      const __m256i high = _mm256_and_si256(_mm256_srli_epi16(bits, 4), nibble);
      sum = _mm256_add_epi8(sum, _mm256_shuffle_epi8(table, _mm256_and_si256(bits, nibble)));
      sum = _mm256_add_epi8(sum, _mm256_shuffle_epi8(table, high));
    }
    const __m256i pairs = _mm256_maddubs_epi16(sum, _mm256_set1_epi8(1));
    const __m256i bits = _mm256_madd_epi16(pairs, _mm256_set1_epi16(1));
    Store(_mm256_add_epi32(bits, Load(rows.bias(first + b))), limit, out, near + b);
  }
}

void Avx2(const PackedQuery& query, const PackedRows& rows, int first, int count, int32_t limit,
          int32_t* out, uint8_t* near) {
  if (rows.type() != FeatureType::kSift) {
    Hamming(query, rows, first, count, limit, out, near);
  } else if (query.narrow && rows.narrow()) {
    Euclidean<true>(query, rows, first, count, limit, out, near);
  } else {
    Euclidean<false>(query, rows, first, count, limit, out, near);
  }
}

#define WAYSTONE_AVX512_TARGET "avx512f,avx512bw,avx512vl,avx512vnni,avx512vpopcntdq"
#define WAYSTONE_AVX512 __attribute__((target(WAYSTONE_AVX512_TARGET), always_inline)) inline

// VNNI sums products of four bytes, VPOPCNTDQ bits of four bytes, both in lanes of 32 bits.
template <bool kSift, int kPairs, int kBlocks>
WAYSTONE_AVX512 void Avx512Blocks(const __m512i* query, int32_t query_square,
                                  const PackedRows& rows, int first, int32_t limit, int32_t* out,
                                  uint8_t* near) {
  constexpr int kPairBytes = kWordsTogether * kBlockWordBytes;
  const uint8_t* data = rows.block(first);
  __m512i sums[kBlocks];
  for (int b = 0; b < kBlocks; ++b) sums[b] = _mm512_setzero_si512();
  for (int p = 0; p < kPairs; ++p) {
    for (int b = 0; b < kBlocks; ++b) {
      const __m512i words = _mm512_loadu_si512(data + (b * kPairs + p) * kPairBytes);
      sums[b] =
          kSift ? _mm512_dpbusd_epi32(sums[b], query[p], words)
                : _mm512_add_epi32(sums[b], _mm512_popcnt_epi32(_mm512_xor_si512(query[p], words)));
    }
  }
  for (int b = 0; b < kBlocks; ++b) {
    const __m256i sum =
        _mm256_add_epi32(_mm512_castsi512_si256(sums[b]), _mm512_extracti64x4_epi64(sums[b], 1));
    const __m256i squares =
        _mm256_add_epi32(_mm256_set1_epi32(query_square), Load(rows.bias(first + b)));
    const __m256i distances = kSift ? _mm256_sub_epi32(squares, _mm256_add_epi32(sum, sum))
                                    : _mm256_add_epi32(squares, sum);
    _mm256_storeu_si256(reinterpret_cast<__m256i*>(out + b * kPackRows), distances);
    near[b] = _mm256_cmple_epi32_mask(distances, _mm256_set1_epi32(limit));
  }
}

// All words of the query stay in registers, kPairs of them.
template <bool kSift, int kPairs>
__attribute__((target(WAYSTONE_AVX512_TARGET))) void Avx512Rows(const PackedQuery& query,
                                                                const PackedRows& rows, int first,
                                                                int count, int32_t limit,
                                                                int32_t* out, uint8_t* near) {
  constexpr int kTogether = 4;
  __m512i pairs[kPairs];
  for (int p = 0; p < kPairs; ++p) {
    const auto* words = reinterpret_cast<const int32_t*>(query.words.data()) + p * kWordsTogether;
    pairs[p] = _mm512_inserti64x4(_mm512_set1_epi32(words[0]), _mm256_set1_epi32(words[1]), 1);
  }
  int b = 0;
  for (; b + kTogether <= count; b += kTogether) {
    Avx512Blocks<kSift, kPairs, kTogether>(pairs, query.square, rows, first + b, limit,
                                           out + b * kPackRows, near + b);
  }
  for (; b < count; ++b) {
    Avx512Blocks<kSift, kPairs, 1>(pairs, query.square, rows, first + b, limit, out + b * kPackRows,
                                   near + b);
  }
}

void Avx512(const PackedQuery& query, const PackedRows& rows, int first, int count, int32_t limit,
            int32_t* out, uint8_t* near) {
  switch (rows.type()) {
    case FeatureType::kSift:
      return Avx512Rows<true, 16>(query, rows, first, count, limit, out, near);
    case FeatureType::kOrb:
      return Avx512Rows<false, 4>(query, rows, first, count, limit, out, near);
    case FeatureType::kAkaze:
      return Avx512Rows<false, 8>(query, rows, first, count, limit, out, near);
  }
}

bool HasAvx512() {
  return __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512vl") &&
         __builtin_cpu_supports("avx512vnni") && __builtin_cpu_supports("avx512vpopcntdq");
}

#endif

}  // namespace

PackedQuery::PackedQuery(FeatureType type, const uint8_t* row) {
  const auto bounded = BoundedRow(type, row);
  std::memcpy(words.data(), bounded.data(), DescriptorBytes(type));
  if (type != FeatureType::kSift) return;
  const Squares squares = SumSquares(bounded.data(), DescriptorBytes(type));
  square = squares.low + squares.high;
  narrow = squares.AreNarrow();
}

PackedRows::PackedRows(FeatureType type, int blocks)
    : type_(type),
      words_(WordsOf(type)),
      blocks_(blocks),
      data_(static_cast<size_t>(blocks) * words_ * kBlockWordBytes / sizeof(Line)),
      bias_(static_cast<size_t>(blocks) * kPackRows, kEmptySlotDistance) {}

PackedRows::PackedRows(FeatureType type, DescriptorsView rows)
    : PackedRows(type, (rows.rows() + kPackRows - 1) / kPackRows) {
  for (int i = 0; i < rows.rows(); ++i) Set(i, rows.row(i));
}

void PackedRows::Set(int slot, const uint8_t* row) {
  WS_CHECK(slot >= 0 && slot < slots(), "a slot that isn't there");
  const int bytes = DescriptorBytes(type_);
  uint8_t* word = Data() + static_cast<size_t>(slot / kPackRows) * words_ * kBlockWordBytes +
                  (slot % kPackRows) * kWordBytes;
  const auto bounded = BoundedRow(type_, row);
  for (int i = 0; i < bytes; i += kWordBytes, word += kBlockWordBytes) {
    std::memcpy(word, bounded.data() + i, std::min(kWordBytes, bytes - i));
  }
  bias_[slot] = 0;
  if (type_ != FeatureType::kSift) return;
  const Squares squares = SumSquares(bounded.data(), bytes);
  bias_[slot] = squares.low + squares.high;
  narrow_ = narrow_ && squares.AreNarrow();
}

void PackedRows::CopyRow(int slot, uint8_t* out) const {
  const int bytes = DescriptorBytes(type_);
  const uint8_t* word = block(slot / kPackRows) + (slot % kPackRows) * kWordBytes;
  for (int i = 0; i < bytes; i += kWordBytes, word += kBlockWordBytes) {
    std::memcpy(out + i, word, std::min(kWordBytes, bytes - i));
  }
}

std::vector<NamedPackedDistances> RunnablePackedDistances() {
  std::vector<NamedPackedDistances> functions = {{"portable", Portable}};
#if defined(__x86_64__)
  __builtin_cpu_init();
  if (__builtin_cpu_supports("avx2")) functions.push_back({"avx2", Avx2});
  if (HasAvx512()) functions.push_back({"avx512", Avx512});
#endif
  return functions;
}

void PackedDistances(const PackedQuery& query, const PackedRows& rows, int first, int count,
                     int32_t limit, int32_t* out, uint8_t* near) {
  static const PackedDistancesFunction fastest = RunnablePackedDistances().back().function;
  fastest(query, rows, first, count, limit, out, near);
}

}  // namespace waystone
