// SPDX-License-Identifier: Apache-2.0
#include "registry/map_cache.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <functional>
#include <optional>
#include <thread>

#include "core/base/error.h"
#include "schema/file/sha256.h"
#include "tests/registry/file_size_limit.h"
#include "tests/registry/test_folder.h"
#include "tests/schema/mounted_folder.h"

namespace waystone {
namespace {

namespace fs = std::filesystem;

std::string HashOf(const std::string& bytes) {
  return Sha256({reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size()});
}

// A store of one test, which can lie, end early and be away.
class TestStore : public Store {
 public:
  std::string Add(const std::string& bytes) {
    std::string sha256 = HashOf(bytes);
    files[sha256] = bytes;
    return sha256;
  }
  void Put(const fs::path&, const std::string&, int64_t) const override {}
  void Fetch(const std::string& sha256, int64_t offset, int64_t bytes,
             FileSink& sink) const override {
    ++fetches;
    last_offset = offset;
    if (away) throw MapError(ErrorCode::kStoreUnavailable, "the store is away");
    const std::string& file = files.at(sha256);
    const int64_t start = whole_files_only ? 0 : offset;
    sink.Begin(start);
    int64_t end = std::min<int64_t>(bytes, std::ssize(file));
    if (ends_at) end = std::min(end, *ends_at);
    for (int64_t at = start; at < end; at += kBlock) {
      const int64_t count = std::min<int64_t>(kBlock, end - at);
      if (!sink.Take({file.data() + at, static_cast<size_t>(count)})) return;
      if (meanwhile) meanwhile();
    }
    if (ends_at) throw MapError(ErrorCode::kStoreUnavailable, "the store ended early");
  }

  static constexpr int64_t kBlock = 100;
  std::map<std::string, std::string> files;
  bool away = false;
  bool whole_files_only = false;
  std::optional<int64_t> ends_at;
  std::function<void()> meanwhile;  // behind each block
  mutable std::atomic<int> fetches = 0;
  mutable std::atomic<int64_t> last_offset = 0;
};

class MapCacheTest : public testing::Test {
 protected:
  MapCacheTest() { Restart(); }
  void Restart(int64_t max_bytes = 10'000) {
    cache_.reset();
    cache_.emplace(folder_.path(), max_bytes);
  }
  std::string Get(const std::string& sha256) {
    return ReadAll(cache_->Get(store_, sha256, std::ssize(store_.files.at(sha256)))->path());
  }
  std::string Failure(const std::string& sha256, int64_t bytes,
                      ErrorCode code = ErrorCode::kStoreUnavailable) {
    try {
      cache_->Get(store_, sha256, bytes);
    } catch (const MapError& error) {
      EXPECT_EQ(error.code(), code) << error.what();
      return error.what();
    }
    return "";
  }

  fs::path Cached(const std::string& sha256) const { return folder_ / (sha256.substr(7) + ".db"); }

  TestFolder folder_;
  TestStore store_;
  std::optional<MapCache> cache_;
};

TEST_F(MapCacheTest, AFileIsFetchedOnce) {
  const std::string sha256 = store_.Add(std::string(1234, 'x'));
  EXPECT_EQ(cache_->Find(sha256), nullptr);
  EXPECT_EQ(Get(sha256), std::string(1234, 'x'));
  EXPECT_EQ(Get(sha256), std::string(1234, 'x'));
  Restart();
  store_.away = true;
  EXPECT_EQ(Get(sha256), std::string(1234, 'x'));
  EXPECT_NE(cache_->Find(sha256), nullptr);
  EXPECT_EQ(store_.fetches, 1);
  EXPECT_EQ(cache_->usage().files, 1);
  EXPECT_EQ(cache_->usage().bytes, 1234);
}

TEST_F(MapCacheTest, AnInterruptedFetchGoesOnWhereItStopped) {
  const std::string sha256 = store_.Add(std::string(500, 'x') + std::string(500, 'y'));
  store_.ends_at = 600;
  EXPECT_EQ(Failure(sha256, 1000), "the store ended early");
  EXPECT_EQ(cache_->Find(sha256), nullptr) << "never served half";
  EXPECT_EQ(cache_->usage().bytes, 600);
  Restart();
  store_.ends_at.reset();
  EXPECT_EQ(Get(sha256), store_.files[sha256]);
  EXPECT_EQ(store_.last_offset, 600);
}

TEST_F(MapCacheTest, AStoreWithoutRangesSendsAllAgain) {
  const std::string sha256 = store_.Add(std::string(500, 'x') + std::string(500, 'y'));
  store_.ends_at = 600;
  Failure(sha256, 1000);
  store_.ends_at.reset();
  store_.whole_files_only = true;
  EXPECT_EQ(Get(sha256), store_.files[sha256]);
}

TEST_F(MapCacheTest, WrongBytesAreNeverKept) {
  const std::string sha256 = store_.Add(std::string(1000, 'x'));
  store_.files[sha256][700] = 'y';
  const std::string error = Failure(sha256, 1000, ErrorCode::kStoreDamaged);
  EXPECT_NE(error.find("has other bytes than those that were published"), std::string::npos);
  EXPECT_EQ(store_.fetches, 1);
  EXPECT_EQ(cache_->usage().bytes, 0);
  store_.files[sha256] = std::string(2000, 'x');  // longer
  EXPECT_EQ(ReadAll(cache_->Get(store_, sha256, 1000)->path()), std::string(1000, 'x'))
      << "what is more than the size is no part of it";
}

TEST_F(MapCacheTest, ADamagedPartIsFetchedAnew) {
  const std::string sha256 = store_.Add(std::string(1000, 'x'));
  store_.ends_at = 600;
  Failure(sha256, 1000);
  store_.ends_at.reset();
  const fs::path part = folder_ / (sha256.substr(7) + ".part");
  ASSERT_EQ(fs::file_size(part), 600U);
  WriteBytes(part, std::string(600, 'y'));
  EXPECT_EQ(Get(sha256), std::string(1000, 'x'));
  WriteBytes(part, std::string(3000, 'y'));  // beside the whole file: no longer needed
  Restart();
  EXPECT_EQ(Get(sha256), std::string(1000, 'x'));
  EXPECT_FALSE(fs::exists(part));
}

TEST_F(MapCacheTest, ADroppedFileIsFetchedAnew) {
  const std::string sha256 = store_.Add(std::string(1000, 'x'));
  Get(sha256);
  WriteBytes(folder_ / (sha256.substr(7) + ".db"), std::string(1000, 'y'));
  cache_->Drop(sha256);
  EXPECT_EQ(Get(sha256), std::string(1000, 'x'));
  WriteBytes(folder_ / (sha256.substr(7) + ".db"), "cut");
  Restart();
  EXPECT_EQ(Get(sha256), std::string(1000, 'x')) << "no file of that size";
}

TEST_F(MapCacheTest, AFileThatWasDeletedOrTruncatedIsFetchedAgain) {
  const std::string sha256 = store_.Add(std::string(1000, 'x'));
  Get(sha256);
  fs::remove(Cached(sha256));
  EXPECT_EQ(Get(sha256), std::string(1000, 'x'));
  WriteBytes(Cached(sha256), "cut");
  EXPECT_EQ(Get(sha256), std::string(1000, 'x'));
  EXPECT_EQ(store_.fetches, 3);
  EXPECT_EQ(cache_->usage().files, 1);
  EXPECT_EQ(cache_->usage().bytes, 1000);
  WriteBytes(Cached(sha256), "cut");
  EXPECT_EQ(cache_->Find(sha256), nullptr);
  EXPECT_EQ(cache_->usage().bytes, 0);
  // While somebody uses it.
  MapCache::FilePtr used = cache_->Get(store_, sha256, 1000);
  fs::remove(Cached(sha256));
  EXPECT_EQ(cache_->Find(sha256), nullptr);
  EXPECT_EQ(cache_->usage().bytes, 0);
  EXPECT_EQ(Get(sha256), std::string(1000, 'x'));
  EXPECT_EQ(cache_->usage().bytes, 1000);
  const std::string large = store_.Add(std::string(9500, 'y'));
  EXPECT_NE(Failure(large, 9500, ErrorCode::kNoRoom).find("in use"), std::string::npos);
  used.reset();
  EXPECT_EQ(Get(large), store_.files[large]) << "in its place";
}

TEST_F(MapCacheTest, AFolderThatWasRemovedIsMadeAgain) {
  const std::string first = store_.Add(std::string(4000, 'x'));
  const std::string second = store_.Add(std::string(4000, 'y'));
  const std::string third = store_.Add(std::string(4000, 'z'));
  MapCache::FilePtr used = cache_->Get(store_, first, 4000);
  Get(second);
  fs::remove_all(folder_.path());
  EXPECT_EQ(Get(third), std::string(4000, 'z'));
  EXPECT_EQ(cache_->usage().files, 1) << "what is gone takes no room";
  EXPECT_EQ(cache_->usage().bytes, 4000);
  EXPECT_EQ(cache_->Find(second), nullptr);
  EXPECT_THROW(MapCache(folder_.path(), 1000), MapError) << "it is locked";
  used.reset();
  fs::remove(folder_ / "lock");
  cache_->Restore();
  EXPECT_THROW(MapCache(folder_.path(), 1000), MapError);
  EXPECT_NE(cache_->Find(third), nullptr) << "what is left is kept";
  EXPECT_EQ(Get(first), std::string(4000, 'x'));
  EXPECT_EQ(cache_->usage().bytes, 8000);
}

TEST_F(MapCacheTest, AFolderThatCantBeMadeAgainIsSaidUntilItCan) {
  const std::string sha256 = store_.Add(std::string(1000, 'x'));
  Get(sha256);
  fs::remove_all(folder_.path());
  WriteBytes(folder_.path(), "in its place");
  for (int i = 0; i < 2; ++i) {
    const std::string error = Failure(sha256, 1000, ErrorCode::kNotReady);
    EXPECT_NE(error.find(folder_.path().string() + " can't be written"), std::string::npos)
        << error;
  }
  fs::remove(folder_.path());
  {
    const MapCache other(folder_.path(), 1000);  // another server was faster
    EXPECT_NE(Failure(sha256, 1000, ErrorCode::kNotReady).find("is the cache of another server"),
              std::string::npos);
  }
  EXPECT_EQ(Get(sha256), std::string(1000, 'x'));
}

TEST_F(MapCacheTest, AFolderThatIsRemovedDuringAFetchLeavesNothing) {
  const std::string sha256 = store_.Add(std::string(1000, 'x'));
  store_.meanwhile = [&] { fs::remove_all(folder_.path()); };
  const auto descriptors = [] {
    return std::distance(fs::directory_iterator("/proc/self/fd"), {});
  };
  const auto before = descriptors();
  for (int i = 0; i < 3; ++i) {
    EXPECT_NE(Failure(sha256, 1000, ErrorCode::kNotReady).find("No such file"), std::string::npos);
    EXPECT_EQ(cache_->usage().bytes, 0);
  }
  EXPECT_EQ(descriptors(), before);
  store_.meanwhile = nullptr;
  EXPECT_EQ(Get(sha256), std::string(1000, 'x'));
}

TEST_F(MapCacheTest, WantOfRoomIsToldWithoutPathsAndOtherErrorsAreNone) {
  const std::string sha256 = store_.Add(std::string(5000, 'x'));
  {
    const FileSizeLimit limit(3000);
    try {
      cache_->Get(store_, sha256, 5000);
      ADD_FAILURE() << "no error";
    } catch (const FullDiskError& error) {
      EXPECT_EQ(error.code(), ErrorCode::kNoRoom);
      EXPECT_NE(std::string(error.what()).find(folder_.path().string()), std::string::npos);
      EXPECT_NE(std::string(error.what()).find("File too large"), std::string::npos);
      EXPECT_EQ(error.told(),
                "the map's file can't be written: File too large, 0.0 MB required; the server's "
                "log says more");
    }
  }
  EXPECT_EQ(Get(sha256), std::string(5000, 'x'));
  fs::remove(Cached(sha256));
  fs::create_directory(folder_ / (sha256.substr(7) + ".part"));
  EXPECT_NE(Failure(sha256, 5000, ErrorCode::kNotReady).find("Is a directory"), std::string::npos);
}

TEST_F(MapCacheTest, AFileOfAnotherSizeLeavesItsRoom) {
  const std::string sha256 = store_.Add(std::string(1000, 'x'));
  Get(sha256);
  EXPECT_NE(Failure(sha256, 20'000, ErrorCode::kNoRoom).find("the cache may hold"),
            std::string::npos);
  EXPECT_EQ(cache_->usage().bytes, 0);
}

TEST_F(MapCacheTest, TheLeastRecentlyUsedFilesMakeRoom) {
  std::vector<std::string> hashes;
  for (char c = 'a'; c < 'f'; ++c) hashes.push_back(store_.Add(std::string(3000, c)));
  for (int i = 0; i < 3; ++i) Get(hashes[i]);
  Get(hashes[0]);
  Get(hashes[3]);  // in place of 1
  EXPECT_EQ(cache_->usage().files, 3);
  EXPECT_LE(cache_->usage().bytes, 10'000);
  EXPECT_NE(cache_->Find(hashes[0]), nullptr);
  EXPECT_EQ(cache_->Find(hashes[1]), nullptr);
  std::this_thread::sleep_for(std::chrono::milliseconds(50));  // file times have ticks
  EXPECT_NE(cache_->Find(hashes[2]), nullptr);
  Restart(3500);  // a smaller bound than before
  EXPECT_EQ(cache_->usage().files, 1);
  EXPECT_NE(cache_->Find(hashes[2]), nullptr) << "the last one that was used";
  // What is in use stays, and is said to be.
  const MapCache::FilePtr used = cache_->Find(hashes[2]);
  ASSERT_TRUE(used);
  EXPECT_NE(Failure(hashes[4], 3000, ErrorCode::kNoRoom)
                .find("the cache is full of files that are in use: 0.0 MB of"),
            std::string::npos);
  EXPECT_TRUE(fs::exists(used->path()));
  EXPECT_NE(Failure(hashes[4], 4000, ErrorCode::kNoRoom).find("give it more room (--cache-size)"),
            std::string::npos);
}

// The bound is larger than the disk.
TEST_F(MapCacheTest, OnAFullDiskFilesThatNobodyUsesMakeRoomAndOthersStay) {
  cache_.reset();
  const MountedFolder disk(folder_.path(), "size=256k");
  if (!disk.mounted()) GTEST_SKIP() << "mounting a file system isn't possible here";
  Restart(1'000'000'000);
  std::vector<std::string> hashes;
  for (char c = 'a'; c < 'e'; ++c) hashes.push_back(store_.Add(std::string(100'000, c)));
  EXPECT_EQ(Get(hashes[0]), store_.files[hashes[0]]);
  EXPECT_EQ(Get(hashes[1]), store_.files[hashes[1]]);
  EXPECT_EQ(Get(hashes[2]), store_.files[hashes[2]]) << "in place of the first one";
  EXPECT_EQ(cache_->Find(hashes[0]), nullptr);
  MapCache::FilePtr used = cache_->Find(hashes[1]);
  MapCache::FilePtr also_used = cache_->Find(hashes[2]);
  ASSERT_TRUE(used && also_used);
  const std::string error = Failure(hashes[3], 100'000, ErrorCode::kNoRoom);
  EXPECT_NE(error.find("No space left on device"), std::string::npos) << error;
  EXPECT_NE(error.find(folder_.path().string()), std::string::npos) << error;
  EXPECT_THROW(cache_->Get(store_, hashes[3], 100'000), FullDiskError);
  EXPECT_EQ(ReadAll(used->path()), store_.files[hashes[1]]);
  EXPECT_EQ(ReadAll(also_used->path()), store_.files[hashes[2]]);
  used.reset();
  also_used.reset();
  cache_.reset();  // before what it lies on is unmounted
}

TEST_F(MapCacheTest, ThreadsThatWantOneFileShareItsFetch) {
  const std::string sha256 = store_.Add(std::string(5000, 'x'));
  std::vector<std::thread> threads;
  std::atomic<int> good = 0;
  for (int i = 0; i < 8; ++i) {
    threads.emplace_back([&] { good += Get(sha256) == store_.files.at(sha256) ? 1 : 0; });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(good, 8);
  EXPECT_EQ(store_.fetches, 1);
}

TEST_F(MapCacheTest, ManyThreadsWithinASmallBound) {
  std::vector<std::string> hashes;
  for (char c = 'a'; c < 'm'; ++c) hashes.push_back(store_.Add(std::string(2000, c)));
  std::vector<std::thread> threads;
  std::atomic<int> wrong = 0;
  for (int t = 0; t < 4; ++t) {
    threads.emplace_back([&, t] {
      for (int i = 0; i < 100; ++i) {
        const std::string& sha256 = hashes[(7 * t + 5 * i) % hashes.size()];
        wrong += Get(sha256) == store_.files.at(sha256) ? 0 : 1;
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(wrong, 0);
  EXPECT_LE(cache_->usage().bytes, 10'000);
}

TEST_F(MapCacheTest, AnotherServerHasACacheOfItsOwn) {
  try {
    const MapCache second(folder_.path(), 1000);
    ADD_FAILURE() << "two caches of one folder";
  } catch (const MapError& error) {
    EXPECT_NE(std::string(error.what()).find("is the cache of another server that runs"),
              std::string::npos);
  }
}

TEST_F(MapCacheTest, StopEndsFetches) {
  const std::string sha256 = store_.Add(std::string(1000, 'x'));
  cache_->Stop();
  EXPECT_EQ(Failure(sha256, 1000, ErrorCode::kNotReady), "the server is shutting down");
}

}  // namespace
}  // namespace waystone
