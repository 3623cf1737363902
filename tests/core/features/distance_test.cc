// SPDX-License-Identifier: Apache-2.0
#include "core/features/distance.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <string>
#include <vector>

#include "tests/core/features/made_descriptors.h"

namespace waystone {
namespace {

class DistanceKernels : public testing::TestWithParam<FeatureType> {};

TEST_P(DistanceKernels, ThePortableKernelComesFirstAndTheFastestIsOneOfThem) {
  const std::vector<NamedKernel> kernels = RunnableKernels(GetParam());
  ASSERT_FALSE(kernels.empty());
  EXPECT_STREQ(kernels.front().name, "portable");
  std::set<std::string> names;
  bool fastest_is_listed = false;
  for (const NamedKernel& kernel : kernels) {
    EXPECT_TRUE(names.insert(kernel.name).second) << kernel.name;
    fastest_is_listed = fastest_is_listed || kernel.kernel == FastestKernel(GetParam());
  }
  EXPECT_TRUE(fastest_is_listed);
}

TEST_P(DistanceKernels, EveryKernelGivesTheDefinedDistances) {
  const FeatureType type = GetParam();
  Random random(1);
  for (int rows : {0, 1, 2, 3, 7, 8, 9, 63, 64, 65, 255, 256, 257}) {
    const Descriptors query = MadeDescriptors(type, 1, random);
    const Descriptors block = MadeDescriptors(type, rows, random);
    for (const NamedKernel& named : RunnableKernels(type)) {
      std::vector<int32_t> out(rows + 1, -7);
      named.kernel(query.row(0), block.data().data(), rows, query.bytes(), out.data());
      for (int r = 0; r < rows; ++r) {
        ASSERT_EQ(out[r], NaiveDistance(type, query.row(0), block.row(r)))
            << named.name << ", row " << r << " of " << rows;
      }
      EXPECT_EQ(out[rows], -7) << named.name << " wrote behind " << rows << " rows";
    }
  }
}

// The sums of 16 bits inside the fast kernels must not saturate.
TEST_P(DistanceKernels, EveryKernelTakesTheLargestAndTheSmallestDistances) {
  const FeatureType type = GetParam();
  const int bytes = DescriptorBytes(type);
  const uint8_t largest = type == FeatureType::kSift ? 127 : 255;
  const std::vector<uint8_t> zeros(bytes, 0);
  const std::vector<uint8_t> full(bytes, largest);
  const int expected = type == FeatureType::kSift ? 128 * 127 * 127 : 8 * bytes;
  for (const NamedKernel& named : RunnableKernels(type)) {
    int32_t out = -1;
    named.kernel(zeros.data(), full.data(), 1, bytes, &out);
    EXPECT_EQ(out, expected) << named.name;
    named.kernel(full.data(), zeros.data(), 1, bytes, &out);
    EXPECT_EQ(out, expected) << named.name;
    named.kernel(full.data(), full.data(), 1, bytes, &out);
    EXPECT_EQ(out, 0) << named.name;
  }
}

TEST_P(DistanceKernels, EveryKernelSeesEveryByte) {
  const FeatureType type = GetParam();
  const int bytes = DescriptorBytes(type);
  const std::vector<uint8_t> zeros(bytes, 0);
  for (const NamedKernel& named : RunnableKernels(type)) {
    for (int i = 0; i < bytes; ++i) {
      std::vector<uint8_t> one(bytes, 0);
      one[i] = 1;
      int32_t out = -1;
      named.kernel(zeros.data(), one.data(), 1, bytes, &out);
      ASSERT_EQ(out, 1) << named.name << ", byte " << i;
    }
  }
}

// Blocks of a map begin at any address.
TEST_P(DistanceKernels, EveryKernelTakesUnalignedData) {
  const FeatureType type = GetParam();
  const int bytes = DescriptorBytes(type);
  Random random(2);
  const Descriptors source = MadeDescriptors(type, 6, random);
  for (int shift : {1, 2, 3, 5, 31}) {
    std::vector<uint8_t> moved(shift, 0);
    moved.insert(moved.end(), source.data().begin(), source.data().end());
    for (const NamedKernel& named : RunnableKernels(type)) {
      int32_t out[5] = {};
      named.kernel(moved.data() + shift, moved.data() + shift + bytes, 5, bytes, out);
      for (int r = 0; r < 5; ++r) {
        EXPECT_EQ(out[r], NaiveDistance(type, source.row(0), source.row(r + 1))) << named.name;
      }
    }
  }
}

// Lengths that no descriptor has today: a kernel either computes them too or hands them on.
TEST_P(DistanceKernels, EveryKernelTakesOtherLengths) {
  Random random(3);
  for (int bytes : {1, 7, 8, 31, 33, 64, 127, 129, 256}) {
    std::vector<uint8_t> data(4 * static_cast<size_t>(bytes));
    for (uint8_t& byte : data) byte = random.Below(128);
    int32_t portable[3] = {};
    const std::vector<NamedKernel> kernels = RunnableKernels(GetParam());
    kernels.front().kernel(data.data(), data.data() + bytes, 3, bytes, portable);
    for (const NamedKernel& named : kernels) {
      int32_t out[3] = {};
      named.kernel(data.data(), data.data() + bytes, 3, bytes, out);
      EXPECT_TRUE(std::equal(out, out + 3, portable)) << named.name << ", " << bytes << " bytes";
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Types, DistanceKernels, testing::ValuesIn(kAllTypes),
                         [](const auto& type) { return std::string(NameOf(type.param)); });

}  // namespace
}  // namespace waystone
