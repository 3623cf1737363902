// SPDX-License-Identifier: Apache-2.0
#include "core/features/distance.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "tests/core/features/made_descriptors.h"

namespace waystone {
namespace {

class Distance : public testing::TestWithParam<FeatureType> {};

TEST_P(Distance, IsTheDefinedOne) {
  Random random(1);
  const Descriptors some = MadeDescriptors(GetParam(), 30, random);
  for (int a = 0; a < some.rows(); ++a) {
    for (int b = 0; b < some.rows(); ++b) {
      EXPECT_EQ(DescriptorDistance(GetParam(), some.row(a), some.row(b)),
                NaiveDistance(GetParam(), some.row(a), some.row(b)));
    }
  }
}

TEST_P(Distance, OfTheLargestBytesAndOfEachByte) {
  const int bytes = DescriptorBytes(GetParam());
  const bool sift = GetParam() == FeatureType::kSift;
  const std::vector<uint8_t> zeros(bytes, 0);
  const std::vector<uint8_t> full(bytes, sift ? 127 : 255);
  const int largest = sift ? 128 * 127 * 127 : 8 * bytes;
  EXPECT_EQ(DescriptorDistance(GetParam(), zeros.data(), full.data()), largest);
  EXPECT_EQ(DescriptorDistance(GetParam(), full.data(), zeros.data()), largest);
  EXPECT_EQ(DescriptorDistance(GetParam(), full.data(), full.data()), 0);
  for (int i = 0; i < bytes; ++i) {
    std::vector<uint8_t> one(bytes, 0);
    one[i] = 1;
    EXPECT_EQ(DescriptorDistance(GetParam(), zeros.data(), one.data()), 1) << "byte " << i;
  }
}

INSTANTIATE_TEST_SUITE_P(Types, Distance, testing::ValuesIn(kAllTypes),
                         [](const auto& type) { return std::string(NameOf(type.param)); });

}  // namespace
}  // namespace waystone
