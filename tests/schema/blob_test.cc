// SPDX-License-Identifier: Apache-2.0
#include "schema/tables/blob.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>

#include "core/base/check.h"
#include "schema/file/sha256.h"
#include "schema/layers/layer_blobs.h"
#include "tests/schema/made_map.h"

namespace waystone {
namespace {

BytesView ViewOf(const std::string& text) {
  return {reinterpret_cast<const uint8_t*>(text.data()), text.size()};
}

// The check value that catalogues of CRCs list for CRC-32C.
TEST(Blob, Crc32cOfTheCheckString) {
  EXPECT_EQ(Crc32c(ViewOf("123456789")), 0xE3069283u);
  EXPECT_EQ(Crc32c({}), 0u);
  EXPECT_EQ(HexOf(0xe306928), "0e306928");
}

TEST(Blob, Crc32cSeesEveryBitOfALongBlob) {
  Bytes bytes(1000, 7);
  const uint32_t whole = Crc32c(bytes);
  for (size_t bit = 0; bit < bytes.size() * 8; ++bit) {
    bytes[bit / 8] ^= 1 << (bit % 8);
    EXPECT_NE(Crc32c(bytes), whole) << bit;
    bytes[bit / 8] ^= 1 << (bit % 8);
  }
}

TEST(Blob, KeypointsByteByByte) {
  const std::vector<PlaneFeature> features = {{{1.0F, -2.0F, 0.5F, 0.0F}, 3, 0x0102}};
  EXPECT_EQ(EncodeKeypoints(features), (Bytes{0, 0, 0x80, 0x3f, 0, 0, 0, 0xc0,  //
                                              0, 0, 0, 0x3f, 0, 0, 0, 0}));
  EXPECT_EQ(EncodeVotes(features), (Bytes{3, 0, 2, 1}));
}

TEST(Blob, HomographyByteByByte) {
  Eigen::Matrix3d h;
  h << 1, 2, -3, 0, 0.5, 0, 0, 0, 1;
  Bytes expected(72, 0);
  expected[6] = 0xf0, expected[7] = 0x3f;    // h11 = 1
  expected[15] = 0x40;                       // h12 = 2: row after row
  expected[22] = 0x08, expected[23] = 0xc0;  // h13 = -3
  expected[38] = 0xe0, expected[39] = 0x3f;  // h22 = 0.5
  expected[70] = 0xf0, expected[71] = 0x3f;  // h33 = 1
  EXPECT_EQ(EncodeMatrix(h), expected);
  EXPECT_EQ(DecodeMatrix(expected), h);
}

TEST(Blob, OutlineAndParametersByteByByte) {
  EXPECT_EQ(EncodeOutline({{1, -2}}),
            (Bytes{0, 0, 0, 0, 0, 0, 0xf0, 0x3f, 0, 0, 0, 0, 0, 0, 0, 0xc0}));
  EXPECT_EQ(EncodeParameters({1}), (Bytes{0, 0, 0, 0, 0, 0, 0xf0, 0x3f}));
  EXPECT_TRUE(EncodeOutline({}).empty());
}

TEST(Blob, WhatIsEncodedDecodesToTheSame) {
  const MapData map = MadeMap(1);
  for (const Plane& plane : map.planes) {
    EXPECT_EQ(DecodeFeatures(EncodeKeypoints(plane.features), EncodeVotes(plane.features)),
              plane.features);
    EXPECT_EQ(DecodeOutline(EncodeOutline(plane.outline)), plane.outline);
  }
  const std::vector<double> extremes = {std::numeric_limits<double>::denorm_min(), -0.0, 1e308};
  EXPECT_EQ(DecodeParameters(EncodeParameters(extremes)), extremes);
}

TEST(Blob, HalvesAndBearingsByteByByte) {
  HalfMatrix matrix(2, 2);
  matrix << Eigen::half(1), Eigen::half(-2), Eigen::half(0), Eigen::half(65504);
  const Bytes expected{0, 0x3c, 0, 0xc0, 0, 0, 0xff, 0x7b};  // row after row
  EXPECT_EQ(EncodeHalves(matrix), expected);
  EXPECT_EQ(DecodeHalves(expected, 2, 2), matrix);
  const std::vector<Bearing> bearings = {{0x1234, -2}};
  EXPECT_EQ(EncodeBearings(bearings), (Bytes{0x34, 0x12, 0xfe, 0xff}));
  EXPECT_EQ(DecodeBearings(EncodeBearings(bearings)), bearings);
  EXPECT_THROW(DecodeHalves(Bytes(7), 2, 2), CheckFailure);
}

TEST(Blob, LengthsAndVotesThatCantBeAreProgrammersErrors) {
  EXPECT_THROW(DecodeMatrix(Bytes(71)), CheckFailure);
  EXPECT_THROW(DecodeFeatures(Bytes(16), Bytes(3)), CheckFailure);
  EXPECT_THROW(DecodeOutline(Bytes(15)), CheckFailure);
  EXPECT_THROW(EncodeVotes({{{}, 70000, 1}}), CheckFailure);
}

TEST(Blob, ValueChecksumTellsKindsAndBoundariesApart) {
  const auto of = [](const auto& add) {
    ValueChecksum checksum;
    add(checksum);
    return checksum.Value();
  };
  const uint32_t null = of([](auto& c) { c.AddNull(); });
  const uint32_t zero = of([](auto& c) { c.AddInteger(0); });
  const uint32_t real = of([](auto& c) { c.AddReal(0); });
  const uint32_t text = of([](auto& c) { c.AddText(""); });
  EXPECT_NE(null, zero);
  EXPECT_NE(zero, real);
  EXPECT_NE(text, of([](auto& c) { c.AddBlob(""); }));
  EXPECT_EQ(real, of([](auto& c) { c.AddReal(-0.0); }));
  EXPECT_NE(of([](auto& c) { c.AddText("ab"), c.AddText("c"); }),
            of([](auto& c) { c.AddText("a"), c.AddText("bc"); }));
}

TEST(Sha256, OfTheExampleInFips180) {
  const unsigned char abc[] = {'a', 'b', 'c'};
  EXPECT_EQ(Sha256(abc), "sha256:ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
}

}  // namespace
}  // namespace waystone
