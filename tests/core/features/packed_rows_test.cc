// SPDX-License-Identifier: Apache-2.0
#include "core/features/packed_rows.h"

#include <gtest/gtest.h>

#include "tests/core/features/made_descriptors.h"

namespace waystone {
namespace {

class Packed : public testing::TestWithParam<FeatureType> {
 protected:
  // Every implementation, over all numbers of blocks up to a few.
  void ExpectExact(const Descriptors& rows, const Descriptors& queries) {
    const PackedRows packed(GetParam(), rows);
    std::vector<int32_t> out(packed.slots());
    std::vector<uint8_t> near(packed.blocks());
    for (const auto& [name, function] : RunnablePackedDistances()) {
      for (int q = 0; q < queries.rows(); ++q) {
        const int limit = NaiveDistance(GetParam(), queries.row(q), rows.row(0));
        for (int first = 0; first < packed.blocks(); ++first) {
          const int count = packed.blocks() - first;
          function(PackedQuery(GetParam(), queries.row(q)), packed, first, count, limit, out.data(),
                   near.data());
          for (int i = 0; i < count * kPackRows; ++i) {
            const int row = first * kPackRows + i;
            if (row < rows.rows()) {
              ASSERT_EQ(out[i], NaiveDistance(GetParam(), queries.row(q), rows.row(row))) << name;
            } else {
              ASSERT_GE(out[i], kEmptySlotDistance) << name;
            }
            ASSERT_EQ((near[i / kPackRows] >> (i % kPackRows)) & 1, out[i] <= limit) << name;
          }
        }
      }
    }
  }
};

TEST_P(Packed, DistancesAreExact) {
  Random random(1);
  for (const int rows : {1, 7, 8, 9, 40, 75}) {
    ExpectExact(MadeDescriptors(GetParam(), rows, random), MadeDescriptors(GetParam(), 3, random));
    // Short ones, whose products are summed in 16 bits.
    ExpectExact(MadeDescriptors(GetParam(), rows, random, 25),
                MadeDescriptors(GetParam(), 3, random, 25));
  }
}

TEST_P(Packed, DistancesOfTheLargestBytes) {
  const int bytes = DescriptorBytes(GetParam());
  const uint8_t most = GetParam() == FeatureType::kSift ? 127 : 255;
  const Descriptors full(bytes, std::vector<uint8_t>(static_cast<size_t>(bytes) * 9, most));
  const Descriptors empty(bytes, std::vector<uint8_t>(bytes, 0));
  ExpectExact(full, full);
  ExpectExact(full, empty);
}

// What a map of another program may have: the same distances by every implementation.
TEST(PackedRows, LargerBytesOfSiftCountAsTheLargest) {
  Random random(3);
  const auto any_bytes = [&](int rows) {  // those of ORB: four of its descriptors are one of SIFT
    return Descriptors(128, MadeDescriptors(FeatureType::kOrb, 4 * rows, random).data());
  };
  const Descriptors rows = any_bytes(9), queries = any_bytes(3);
  const auto bounded = [](const Descriptors& larger) {
    std::vector<uint8_t> bytes = larger.data();
    for (uint8_t& byte : bytes) byte = std::min<uint8_t>(byte, 127);
    return Descriptors(128, bytes);
  };
  const Descriptors bounded_rows = bounded(rows), bounded_queries = bounded(queries);
  const PackedRows packed(FeatureType::kSift, rows);
  std::vector<int32_t> out(packed.slots());
  std::vector<uint8_t> near(packed.blocks());
  for (const auto& [name, function] : RunnablePackedDistances()) {
    for (int q = 0; q < queries.rows(); ++q) {
      function(PackedQuery(FeatureType::kSift, queries.row(q)), packed, 0, packed.blocks(), 0,
               out.data(), near.data());
      for (int i = 0; i < rows.rows(); ++i) {
        EXPECT_EQ(out[i],
                  NaiveDistance(FeatureType::kSift, bounded_queries.row(q), bounded_rows.row(i)))
            << name;
      }
    }
  }
}

TEST(PackedQuery, OnlyShortDescriptorsOfSiftAreNarrow) {
  // The halves that the two lanes sum: bytes 0 and 1 of each word, and bytes 2 and 3.
  std::vector<uint8_t> row(128, 0);
  for (int i = 0; i < 128; i += 4) row[i] = 45;
  EXPECT_TRUE(PackedQuery(FeatureType::kSift, row.data()).narrow);
  for (int i = 0; i < 128; i += 4) row[i] = 46;
  EXPECT_FALSE(PackedQuery(FeatureType::kSift, row.data()).narrow);
}

TEST_P(Packed, RowsComeBack) {
  Random random(2);
  const Descriptors rows = MadeDescriptors(GetParam(), 21, random);
  const PackedRows packed(GetParam(), rows);
  std::vector<uint8_t> copy(rows.bytes());
  for (int i = 0; i < rows.rows(); ++i) {
    packed.CopyRow(i, copy.data());
    EXPECT_TRUE(std::equal(copy.begin(), copy.end(), rows.row(i)));
  }
}

INSTANTIATE_TEST_SUITE_P(Types, Packed, testing::ValuesIn(kAllTypes));

}  // namespace
}  // namespace waystone
