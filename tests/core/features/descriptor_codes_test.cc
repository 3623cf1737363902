// SPDX-License-Identifier: Apache-2.0
#include "core/features/descriptor_codes.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/core/features/made_descriptors.h"

namespace waystone {
namespace {

// Like RootSIFT: few large entries, length 256.
Descriptors MadeRootSift(int rows, Random& random) {
  Descriptors descriptors(128);
  for (int row = 0; row < rows; ++row) {
    std::vector<double> entries(128);
    double square = 0;
    for (double& entry : entries) {
      entry = std::abs(random.Normal());
      square += entry * entry;
    }
    std::vector<uint8_t> bytes;
    for (const double entry : entries) {
      bytes.push_back(static_cast<uint8_t>(std::min(127.0, 256 * entry / std::sqrt(square))));
    }
    descriptors.Append(bytes.data());
  }
  return descriptors;
}

double Length(const uint8_t* row) {
  double square = 0;
  for (int i = 0; i < 128; ++i) square += row[i] * row[i];
  return std::sqrt(square);
}

TEST(DescriptorCodes, AreAQuarterOfSiftAndNearIt) {
  Random random(1);
  const Descriptors all = MadeRootSift(50, random);
  const Descriptors codes = EncodeDescriptors(all, FeatureType::kSift);
  EXPECT_EQ(codes.bytes(), 32);
  const Descriptors back = DecodeDescriptors(codes, FeatureType::kSift);
  ASSERT_EQ(back.rows(), 50);
  for (int i = 0; i < 50; ++i) {
    EXPECT_NEAR(Length(back.row(i)), 256, 8);
    const int own = NaiveDistance(FeatureType::kSift, all.row(i), back.row(i));
    for (int other = 0; other < 50; ++other) {
      if (other == i) continue;
      // Other descriptors are far off beside what rounding does.
      EXPECT_LT(2 * own, NaiveDistance(FeatureType::kSift, all.row(other), back.row(i)));
    }
  }
}

TEST(DescriptorCodes, LowestBitsAreTheFirstEntry) {
  std::vector<uint8_t> entries(128, 0);
  entries[0] = 127;  // code 3
  entries[1] = 14;   // code 1
  entries[3] = 27;   // code 2
  const Descriptors codes = EncodeDescriptors(Descriptors(128, entries), FeatureType::kSift);
  EXPECT_EQ(codes.row(0)[0], 3 + (1 << 2) + (2 << 6));
  EXPECT_EQ(codes.row(0)[1], 0);
}

TEST(DescriptorCodes, BitsStayAsTheyAre) {
  Random random(2);
  for (const FeatureType type : {FeatureType::kOrb, FeatureType::kAkaze}) {
    const Descriptors all = MadeDescriptors(type, 5, random);
    EXPECT_EQ(CodeBytes(type), DescriptorBytes(type));
    EXPECT_EQ(DecodeDescriptors(EncodeDescriptors(all, type), type), all);
  }
}

}  // namespace
}  // namespace waystone
