// SPDX-License-Identifier: Apache-2.0
// Files that were cut, or whose bits or pages changed: whatever differs from what was written is
// found, by reading or by the check; nothing crashes.
#include <gtest/gtest.h>

#include <optional>

#include "core/base/random.h"
#include "schema/file/map_store.h"
#include "tests/schema/made_map.h"

namespace waystone {
namespace {

namespace fs = std::filesystem;

class DamageTest : public testing::Test {
 protected:
  DamageTest() {
    MapShape shape;
    shape.max_features = 40;
    shape.jpeg_bytes = 3000;
    map_ = MadeMap(21, shape);
    WriteMap(map_, folder_ / "m.db", {});
    bytes_ = ReadFile(folder_ / "m.db");
  }

  // What is read, or nothing when the file is refused. Any other exception fails the test.
  std::optional<MapData> TryRead() {
    try {
      return WithoutVersion(ReadMap(folder_ / "m.db"));
    } catch (const MapError& error) {
      EXPECT_NE(error.code(), ErrorCode::kInternal);
      return {};
    }
  }

  bool CheckFindsSomething() {
    try {
      return !CheckMap(folder_ / "m.db").empty();
    } catch (const MapError&) {
      return true;
    }
  }

  // Counts what became of a file with these bytes.
  void Try(const std::string& bytes, const std::string& name) {
    WriteFile(folder_ / "m.db", bytes);
    const std::optional<MapData> read = TryRead();
    const bool found = CheckFindsSomething();
    refused_ += !read;
    harmless_ += read && !found;
    EXPECT_TRUE(!read || *read == map_) << name << " gives another map";
    EXPECT_TRUE(read || found) << name << " is refused, but the check finds nothing";
  }

  TemporaryFolder folder_;
  MapData map_;
  std::string bytes_;
  int refused_ = 0;
  int harmless_ = 0;
};

TEST_F(DamageTest, FlippedBits) {
  constexpr int kFlips = 400;
  Random random(1);
  for (int i = 0; i < kFlips; ++i) {
    std::string bytes = bytes_;
    const int position = random.Below(static_cast<int>(bytes.size()));
    const int bit = random.Below(8);
    bytes[position] = static_cast<char>(bytes[position] ^ (1 << bit));
    Try(bytes, "bit " + std::to_string(bit) + " of byte " + std::to_string(position));
  }
  // Nearly all bytes carry something; what is left is free space in pages and counters.
  EXPECT_GT(refused_, kFlips / 2);
  EXPECT_GT(harmless_, 0);
  RecordProperty("refused", refused_);
  RecordProperty("harmless", harmless_);
}

// The header and the schema, where a single bit can change the meaning of all that follows.
TEST_F(DamageTest, TwoBitsOfEveryByteOfTheHeader) {
  for (int position = 0; position < 108; ++position) {
    for (const int bit : {position % 8, 7 - position % 3}) {
      std::string bytes = bytes_;
      bytes[position] = static_cast<char>(bytes[position] ^ (1 << bit));
      Try(bytes, "bit " + std::to_string(bit) + " of byte " + std::to_string(position));
    }
  }
  EXPECT_GT(refused_, 60);
}

TEST_F(DamageTest, FlippedBitsInABlob) {
  const std::string jpeg(map_.keyframes[0].picture.begin(), map_.keyframes[0].picture.end());
  const std::vector<uint8_t>& descriptors = map_.planes[0].descriptors.data();
  for (const std::string& blob : {jpeg, std::string(descriptors.begin(), descriptors.end())}) {
    if (blob.size() < 16) continue;
    const size_t position = bytes_.find(blob.substr(blob.size() - 16));
    ASSERT_NE(position, std::string::npos);
    std::string bytes = bytes_;
    bytes[position] = static_cast<char>(bytes[position] ^ 1);
    const int before = refused_;
    Try(bytes, "a bit of a blob");
    EXPECT_EQ(refused_, before + 1);
  }
}

TEST_F(DamageTest, CutFiles) {
  Random random(2);
  for (int i = 0; i < 80; ++i) {
    const int length = i < 20 ? i * 8 : random.Below(static_cast<int>(bytes_.size()));
    Try(bytes_.substr(0, length), "cut to " + std::to_string(length));
  }
  EXPECT_EQ(refused_, 80);
  WriteFile(folder_ / "m.db", bytes_.substr(0, bytes_.size() / 2));
  const MapError error = ErrorOf([&] { ReadMap(folder_ / "m.db"); });
  EXPECT_EQ(error.code(), ErrorCode::kMapDamaged);
  EXPECT_NE(std::string(error.what()).find(std::to_string(bytes_.size())), std::string::npos)
      << error.what();
  EXPECT_FALSE(CheckMap(folder_ / "m.db").empty());
}

TEST_F(DamageTest, PagesOfZerosOrNoiseOrElsewhere) {
  constexpr size_t kPage = 1024;
  Random random(3);
  for (size_t start = 0; start + kPage <= bytes_.size(); start += kPage) {
    std::string zeros = bytes_;
    zeros.replace(start, kPage, kPage, '\0');
    Try(zeros, "zeros at " + std::to_string(start));
    std::string noise = bytes_;
    for (size_t i = 0; i < kPage; ++i) noise[start + i] = static_cast<char>(random.Below(256));
    Try(noise, "noise at " + std::to_string(start));
    std::string swapped = bytes_;
    const size_t other = random.Below(static_cast<int>(bytes_.size() / kPage)) * kPage;
    swapped.replace(start, kPage, bytes_.substr(other, kPage));
    Try(swapped, "a page of elsewhere at " + std::to_string(start));
  }
  EXPECT_GT(refused_, static_cast<int>(bytes_.size() / kPage));
}

TEST_F(DamageTest, BytesBehindTheEnd) {
  Try(bytes_ + std::string(5000, 'x'), "bytes behind the end");
  EXPECT_EQ(refused_, 1);
}

}  // namespace
}  // namespace waystone
