// SPDX-License-Identifier: Apache-2.0
// Entries of the coarse index: what a map gives, and as files.
#include "localizer/coarse/coarse_entry.h"

#include <gtest/gtest.h>

#include "core/base/error.h"
#include "core/features/descriptor_codes.h"
#include "tests/localizer/coarse/made_entry.h"

namespace waystone {
namespace {

const std::string kVersion = "sha256:" + std::string(64, 'b');

// A map of two keyframes that see one plane, the second with landmarks.
MapData MapOfTwoKeyframes(FeatureType type) {
  Random random(1);
  MapData map;
  map.info.version = kVersion;
  map.info.feature_type = type;
  map.sequences.push_back({SequenceId{1}, "walk", "folder", 2, 0, {}});
  for (int id = 1; id <= 2; ++id) {
    Keyframe keyframe;
    keyframe.id = {id};
    keyframe.sequence = {1};
    keyframe.frame = id;
    keyframe.source = std::to_string(id) + ".jpg";
    keyframe.width = 640;
    keyframe.height = 480;
    map.keyframes.push_back(keyframe);
  }
  Landmarks& landmarks = map.keyframes[1].landmarks;
  landmarks.positions.resize(60);
  landmarks.codes = EncodeDescriptors(MadeDescriptors(type, 60, random), type);
  Plane& plane = map.planes.emplace_back();
  plane.id = {1};
  plane.reference = {1};
  plane.features.resize(100);
  for (int i = 0; i < 100; ++i) plane.features[i].votes = 2 + i % 3;
  plane.descriptors = MadeDescriptors(type, 100, random);
  plane.views = {{{1}, Eigen::Matrix3d::Identity(), 50}, {{2}, Eigen::Matrix3d::Identity(), 50}};
  return map;
}

class CoarseEntryTest : public testing::TestWithParam<FeatureType> {};

INSTANTIATE_TEST_SUITE_P(Types, CoarseEntryTest, testing::ValuesIn(kAllTypes),
                         [](const auto& type) { return std::string(NameOf(type.param)); });

TEST_P(CoarseEntryTest, EachKeyframeGetsFeaturesOfPlanesAndLandmarks) {
  const auto index = MapIndex::Build(MapOfTwoKeyframes(GetParam()));
  const CoarseEntry entry = MakeCoarseEntry(*index);
  EXPECT_EQ(entry.map_version, kVersion);
  EXPECT_EQ(entry.feature_type, GetParam());
  EXPECT_EQ(entry.working_pixels, 640 * 480);
  ASSERT_EQ(entry.places(), 2);
  EXPECT_EQ(entry.keyframes, 2);
  for (const uint8_t count : entry.codes_of) {
    EXPECT_GT(count, 0);
    EXPECT_LE(count, kMaxPlaceCodes);
  }
  EXPECT_EQ(entry.codes(), entry.codes_of[0] + entry.codes_of[1]);
  EXPECT_EQ(entry.signatures.size(), entry.words.size());
  EXPECT_EQ(MakeCoarseEntry(*index), entry);
}

TEST_P(CoarseEntryTest, IsWrittenAndRead) {
  const CoarseEntry entry = MakeCoarseEntry(*MapIndex::Build(MapOfTwoKeyframes(GetParam())));
  const std::string bytes = EncodeCoarseEntry(entry);
  EXPECT_EQ(DecodeCoarseEntry(bytes, "it"), entry);
  EXPECT_EQ(EncodeCoarseEntry(DecodeCoarseEntry(bytes, "it")), bytes);
  EXPECT_LE(bytes.size(), 100 + 2 * (1 + 10U * kMaxPlaceCodes));
}

TEST(CoarseEntry, OfAMapWithoutFeaturesHasNoCodes) {
  MapData map;
  map.info.version = kVersion;
  const CoarseEntry entry = MakeCoarseEntry(*MapIndex::Build(std::move(map)));
  EXPECT_EQ(entry.codes(), 0);
  EXPECT_EQ(entry.places(), 0);
}

std::string WhyRefused(const std::string& bytes) {
  try {
    DecodeCoarseEntry(bytes, "it");
  } catch (const MapError& error) {
    EXPECT_EQ(error.code(), ErrorCode::kFileUnreadable);
    EXPECT_TRUE(std::string(error.what()).starts_with("it is not an entry")) << error.what();
    return error.what();
  }
  return "";
}

TEST(CoarseEntry, WhatLiesIsRefused) {
  const std::string good =
      EncodeCoarseEntry(EntryOf(FeatureType::kSift, MadePlaces(FeatureType::kSift, 3, 1)));
  EXPECT_EQ(WhyRefused(good), "");
  for (size_t size = 0; size < good.size(); size += 7) {
    EXPECT_NE(WhyRefused(good.substr(0, size)), "") << size;
  }
  EXPECT_NE(WhyRefused(good + "x").find("don't fill its"), std::string::npos);
  const size_t numbers = std::string("waystone coarse\n").size() + 64;
  const auto with = [&](size_t number, uint32_t value) {
    std::string bytes = good;
    for (int i = 0; i < 4; ++i) bytes[numbers + 4 * number + i] = static_cast<char>(value >> 8 * i);
    return WhyRefused(bytes);
  };
  EXPECT_NE(with(0, 2).find("its format is 2"), std::string::npos);
  EXPECT_NE(with(1, 3).find("no known type"), std::string::npos);
  EXPECT_NE(with(2, 0xFFFFFFFF).find("pixels"), std::string::npos);
  EXPECT_NE(with(3, 4).find("4 keyframes"), std::string::npos);
  EXPECT_NE(with(4, 0xFFFFFFFF).find("4294967295 places"), std::string::npos);
  EXPECT_NE(with(4, 2), "");
  std::string crowded = good;
  crowded[numbers + 20] = static_cast<char>(kMaxPlaceCodes + 1);
  EXPECT_NE(WhyRefused(crowded).find("place 0 has 81 codes"), std::string::npos);
  std::string nameless = good;
  nameless[20] = 'x';
  EXPECT_NE(WhyRefused(nameless).find("names no map file"), std::string::npos);
  EXPECT_NE(WhyRefused("W" + good.substr(1)).find("doesn't begin"), std::string::npos);
}

}  // namespace
}  // namespace waystone
