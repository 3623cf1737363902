// SPDX-License-Identifier: Apache-2.0
// The words of the coarse index.
#include "core/search/words.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <string>
#include <vector>

#include "tests/core/features/made_descriptors.h"

namespace waystone {
namespace {

// Rows near prototypes, as descriptors of images are.
Descriptors NearPrototypes(FeatureType type, int rows, Random& random) {
  const Descriptors prototypes = WordPrototypes(type);
  Descriptors made(prototypes.bytes());
  for (int i = 0; i < rows; ++i) {
    std::vector<uint8_t> row(prototypes.bytes());
    const int cut = Vocabulary::FirstHalf(type);
    const uint8_t* first = prototypes.row(random.Below(Vocabulary::kPrototypes));
    const uint8_t* second = prototypes.row(random.Below(Vocabulary::kPrototypes));
    for (int b = 0; b < prototypes.bytes(); ++b) row[b] = (b < cut ? first : second)[b];
    made.Append(row.data());
  }
  return made;
}

// The same feature in another picture.
std::vector<uint8_t> Disturbed(FeatureType type, const uint8_t* row, Random& random) {
  std::vector<uint8_t> copy(row, row + DescriptorBytes(type));
  for (uint8_t& byte : copy) {
    if (type == FeatureType::kSift) {
      byte = static_cast<uint8_t>(std::clamp(byte + random.Below(5) - 2, 0, 127));
    } else if (random.Below(8) == 0) {
      byte ^= static_cast<uint8_t>(1 << random.Below(8));
    }
  }
  return copy;
}

class WordsTest : public testing::TestWithParam<FeatureType> {};

INSTANTIATE_TEST_SUITE_P(Types, WordsTest, testing::ValuesIn(kAllTypes),
                         [](const auto& type) { return std::string(NameOf(type.param)); });

TEST_P(WordsTest, TheNearestWordsComeFirst) {
  const FeatureType type = GetParam();
  const Descriptors prototypes = WordPrototypes(type);
  Random random(3);
  const Descriptors rows = MadeDescriptors(type, 20, random);
  for (int i = 0; i < rows.rows(); ++i) {
    // All pairs of prototypes, the slow way.
    std::vector<std::pair<int, int>> all;
    for (int word = 0; word < Vocabulary::kCount; ++word) {
      std::vector<uint8_t> joined(prototypes.bytes());
      const int cut = Vocabulary::FirstHalf(type);
      const uint8_t* first = prototypes.row(word / Vocabulary::kPrototypes);
      const uint8_t* second = prototypes.row(word % Vocabulary::kPrototypes);
      if (i > 0 && word % 97 != 0) continue;  // all of them once
      for (int b = 0; b < prototypes.bytes(); ++b) joined[b] = (b < cut ? first : second)[b];
      all.emplace_back(NaiveDistance(type, rows.row(i), joined.data()), word);
    }
    std::ranges::sort(all);
    const std::vector<WordCode> probes =
        Vocabulary::Of(type).Probe(rows.row(i), Vocabulary::kMaxProbes);
    ASSERT_EQ(probes.size(), Vocabulary::kMaxProbes);
    EXPECT_EQ(probes.front(), Vocabulary::Of(type).Encode(rows.row(i)));
    for (size_t p = 0; i == 0 && p < probes.size(); ++p) EXPECT_EQ(probes[p].word, all[p].second);
  }
}

TEST_P(WordsTest, TheSameFeatureIsFoundAgain) {
  const FeatureType type = GetParam();
  const Vocabulary& words = Vocabulary::Of(type);
  Random random(5);
  const Descriptors rows = NearPrototypes(type, 300, random);
  int found = 0;
  int confused = 0;
  for (int i = 0; i < rows.rows(); ++i) {
    const WordCode code = words.Encode(Disturbed(type, rows.row(i), random).data());
    for (const WordCode& probe : words.Probe(Disturbed(type, rows.row(i), random).data(), 8)) {
      found += probe.word == code.word;
    }
    const WordCode other = words.Encode(rows.row((i + 1) % rows.rows()));
    confused += other.word == code.word;
  }
  EXPECT_GE(found, 285);
  EXPECT_LE(confused, 15);
}

TEST_P(WordsTest, PrototypesDiffer) {
  const Descriptors prototypes = WordPrototypes(GetParam());
  const int cut = Vocabulary::FirstHalf(GetParam());
  std::set<std::vector<uint8_t>> first;
  std::set<std::vector<uint8_t>> second;
  for (int i = 0; i < prototypes.rows(); ++i) {
    const uint8_t* row = prototypes.row(i);
    first.emplace(row, row + cut);
    second.emplace(row + cut, row + prototypes.bytes());
  }
  EXPECT_GE(first.size(), 250U);
  EXPECT_GE(second.size(), 250U);
}

TEST(WordCodes, DifferInBits) {
  EXPECT_EQ(SignatureDistance(0, 0), 0);
  EXPECT_EQ(SignatureDistance(~uint64_t{0}, 0), 64);
  EXPECT_EQ(SignatureDistance(0b1011, 0b1110), 2);
}

}  // namespace
}  // namespace waystone
