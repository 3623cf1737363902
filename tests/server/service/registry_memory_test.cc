// SPDX-License-Identifier: Apache-2.0
// How maps of a registry share a bound of memory.
#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "tests/server/service/registry_maps_fixture.h"

namespace waystone {
namespace {

TEST_F(RegistryMapsTest, TheLeastRecentlyUsedMapsMakeRoom) {
  std::vector<MapVersion> versions;
  for (int i = 0; i < 5; ++i) versions.push_back(Publish("map" + std::to_string(i), 3 + i));
  // Three open ones of twice their size, while one is opened with its file beside.
  const int64_t largest = versions.back().bytes;
  options_.memory_bytes = 7 * largest;
  Start();
  for (int round = 0; round < 3; ++round) {
    for (size_t i = 0; i < versions.size(); ++i) {
      EXPECT_EQ(Planes("map" + std::to_string(i)), 3 + i);
      EXPECT_LE(Held().memory_bytes, options_.memory_bytes);
      EXPECT_LE(maps_->holdings().open, 3U);
    }
  }
  EXPECT_GE(Held().closed, 10);
  EXPECT_EQ(Held().fetched_files, 5) << "the cache kept the files";
  try {
    maps_->ScopeOf({});
    ADD_FAILURE() << "more than the memory holds";
  } catch (const MapError& error) {
    EXPECT_EQ(error.code(), ErrorCode::kNotAvailable);
    EXPECT_NE(std::string(error.what()).find("name the map"), std::string::npos);
  }
}

// What requests in progress hold counts, too.
TEST_F(RegistryMapsTest, MapsInUseKeepTheirMemory) {
  const MapVersion lab = Publish("lab", 3);
  Publish("hall", 3);
  options_.memory_bytes = 3 * lab.bytes;
  Start();
  MapSource::MapPtr used = maps_->Find("lab", std::nullopt);
  const auto soon = Clock::now() + std::chrono::milliseconds(300);
  EXPECT_THROW(maps_->Find("hall", soon), MapError);
  EXPECT_EQ(Held().memory_bytes, 2 * lab.bytes);
  used = nullptr;
  EXPECT_EQ(Planes("hall"), 3U);
}

// Room is made by maps that no request uses: closing another gives nothing back yet.
TEST_F(RegistryMapsTest, MapsThatNobodyUsesMakeRoom) {
  const MapVersion lab = Publish("lab", 3);
  for (const std::string name : {"hall", "roof", "yard"}) Publish(name, 3);
  options_.memory_bytes = 7 * lab.bytes;  // two open, and one that is being opened
  Start();
  const MapSource::MapPtr used = maps_->Find("lab", std::nullopt);
  const std::shared_ptr<const MapIndex> used_too =
      maps_->Find("hall", std::nullopt)->shared_index();
  for (const std::string name : {"roof", "yard", "roof"}) {
    const auto soon = Clock::now() + std::chrono::seconds(kPatienceS / 2);
    EXPECT_TRUE(maps_->Find(name, soon)) << name;
  }
}

// What waits for memory may wait for that of a request, which then doesn't wait in turn.
TEST_F(RegistryMapsTest, ALotEndsWhereItsOwnMapsTakeTheRoom) {
  const MapVersion lab = Publish("lab", 3);
  for (const std::string name : {"hall", "roof", "yard"}) Publish(name, 3);
  options_.memory_bytes = 7 * lab.bytes;
  Start();
  std::vector<MapSource::MapPtr> used{maps_->Find("lab", std::nullopt),
                                      maps_->Find("hall", std::nullopt)};
  const std::vector<std::string> names{"roof", "yard"};
  const Clock::time_point start = Clock::now();
  std::vector<FoundMap> lot = maps_->FindLot(names, std::nullopt);
  EXPECT_LT(SecondsSince(start), kPatienceS / 2);
  ASSERT_EQ(lot.size(), 1U);
  EXPECT_TRUE(lot[0].map);
  lot.clear();
  EXPECT_TRUE(maps_->Find("yard", Clock::now() + std::chrono::seconds(kPatienceS / 2)));
}

TEST_F(RegistryMapsTest, AMapLargerThanTheMemoryIsSaidAndOthersAreServed) {
  const MapVersion small = Publish("small", 1);
  const MapVersion large = Publish("large", 100);
  options_.memory_bytes = 3 * small.bytes;
  ASSERT_GT(large.bytes, small.bytes);
  Start();
  const std::string error = Failure("large", ErrorCode::kNoRoom);
  EXPECT_NE(error.find("map 'large': takes"), std::string::npos) << error;
  EXPECT_NE(error.find("(--memory)"), std::string::npos) << error;
  EXPECT_EQ(Planes("small"), 1U);
}

}  // namespace
}  // namespace waystone
