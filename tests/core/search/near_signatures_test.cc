// SPDX-License-Identifier: Apache-2.0
#include "core/search/near_signatures.h"

#include <gtest/gtest.h>

#include "core/base/random.h"
#include "core/search/words.h"

namespace waystone {
namespace {

TEST(NearSignatures, AreThoseWithinTheDistanceInOrder) {
  Random random(5);
  std::vector<uint64_t> signatures;
  for (int i = 0; i < 500; ++i) signatures.push_back(random.Next());
  const uint64_t wanted = random.Next();
  signatures[77] = wanted;
  signatures[78] = ~wanted;
  for (const int max_distance : {0, 20, 30, 63, 64}) {
    std::vector<NearSignature> expected{{9, 9}};  // what was there stays
    for (uint32_t i = 0; i < signatures.size(); ++i) {
      const int distance = SignatureDistance(signatures[i], wanted);
      if (distance <= max_distance) expected.push_back({i, distance});
    }
    std::vector<NearSignature> near{{9, 9}};
    AppendNear(signatures, wanted, max_distance, near);
    EXPECT_EQ(near, expected) << max_distance;
  }
}

TEST(NearSignatures, OfAnEmptyListAreNone) {
  std::vector<NearSignature> near;
  AppendNear({}, 1, 64, near);
  EXPECT_TRUE(near.empty());
}

}  // namespace
}  // namespace waystone
