// SPDX-License-Identifier: Apache-2.0
// Stores: a folder, and web servers good and bad.
#include <gtest/gtest.h>
// After Eigen, for which the macro _res of the resolver's header spells trouble.
#include <httplib.h>
#include <sys/stat.h>

#include <map>
#include <mutex>
#include <thread>

#include "core/base/error.h"
#include "registry/store.h"
#include "schema/file/sha256.h"
#include "tests/registry/file_size_limit.h"
#include "tests/registry/test_folder.h"
#include "tests/schema/mounted_folder.h"

namespace waystone {
namespace {

namespace fs = std::filesystem;

std::string Sha256OfText(const std::string& bytes) {
  return Sha256({reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size()});
}

// What came of a file.
class TextSink : public FileSink {
 public:
  void Begin(int64_t offset) override {
    begun = offset;
    text.resize(static_cast<size_t>(offset));
  }
  bool Take(std::span<const char> bytes) override {
    text.append(bytes.begin(), bytes.end());
    return text.size() < limit;
  }
  std::string text;
  int64_t begun = -1;
  size_t limit = SIZE_MAX;
};

class StoreServer {
 public:
  StoreServer() {
    server_.Get("/maps/.*", [this](const httplib::Request& in, httplib::Response& out) {
      const std::lock_guard lock(mutex_);
      if (!token.empty() && in.get_header_value("Authorization") != "Bearer " + token) {
        out.status = 401;
        return;
      }
      if (!files.contains(in.path)) {
        out.status = 404;
        return;
      }
      if (ranges) {
        const ssize_t start = in.ranges.empty() ? 0 : in.ranges[0].first;
        if (start >= std::ssize(files[in.path])) {  // the library would send it
          out.status = 416;
          return;
        }
        out.set_content(files[in.path], "application/octet-stream");
        return;
      }
      // The library cuts what is set as content.
      out.status = 200;
      const std::string file = files[in.path];
      out.set_chunked_content_provider("application/octet-stream",
                                       [file](size_t offset, httplib::DataSink& sink) {
                                         if (offset == 0) sink.write(file.data(), file.size());
                                         sink.done();
                                         return true;
                                       });
    });
    server_.Put("/maps/.*", [this](const httplib::Request& in, httplib::Response& out) {
      const std::lock_guard lock(mutex_);
      out.status = takes ? 201 : 403;
      if (takes) files[in.path] = in.body;
    });
    port_ = server_.bind_to_any_port("127.0.0.1");
    thread_ = std::thread([this] { server_.listen_after_bind(); });
    while (!server_.is_running()) std::this_thread::yield();
  }
  ~StoreServer() {
    server_.stop();
    thread_.join();
  }
  std::string url() const { return "http://127.0.0.1:" + std::to_string(port_) + "/maps/"; }

  std::map<std::string, std::string> files;
  bool ranges = true;
  bool takes = true;
  std::string token;

 private:
  httplib::Server server_;
  std::mutex mutex_;
  int port_ = 0;
  std::thread thread_;
};

class StoreTest : public testing::Test {
 protected:
  StoreTest() {
    for (int64_t i = 0; i < 100'000; ++i) bytes_ += static_cast<char>('a' + (i * i >> 5) % 26);
    sha256_ = Sha256OfText(bytes_);
    WriteBytes(folder_ / "map.db", bytes_);
  }
  void Put(const Store& store) { store.Put(folder_ / "map.db", sha256_, std::ssize(bytes_)); }
  TextSink Fetched(const Store& store, int64_t offset) {
    TextSink sink;
    store.Fetch(sha256_, offset, std::ssize(bytes_), sink);
    return sink;
  }
  std::string Failure(const std::function<void()>& call, ErrorCode code) {
    try {
      call();
    } catch (const MapError& error) {
      EXPECT_EQ(error.code(), code) << error.what();
      return error.what();
    }
    ADD_FAILURE() << "no error";
    return "";
  }

  TestFolder folder_;
  std::string bytes_;
  std::string sha256_;
};

TEST_F(StoreTest, AFolderKeepsFilesByTheirHash) {
  const auto store = OpenStore((folder_ / "store").string());
  Put(*store);
  const fs::path file = folder_.path() / "store" / StorePath(sha256_);
  EXPECT_EQ(StorePath(sha256_), sha256_.substr(7, 2) + "/" + sha256_.substr(7) + ".db");
  EXPECT_TRUE(ReadAll(file) == bytes_);
  EXPECT_TRUE(Fetched(*store, 0).text == bytes_);
  EXPECT_TRUE(Fetched(*store, 99'990).text.substr(99'990) == bytes_.substr(99'990));
  WriteBytes(file, "damaged");
  Put(*store);
  EXPECT_TRUE(ReadAll(file) == bytes_) << "publishing again mends it";
}

// Servers of other users read it, also a map and a coarse entry that their maker alone may read.
TEST_F(StoreTest, AFolderKeepsFilesWithTheRightsOfTheUmask) {
  const auto store = OpenStore((folder_ / "store").string());
  fs::permissions(folder_ / "map.db", fs::perms::owner_read);
  const mode_t before = umask(022);
  Put(*store);
  umask(before);
  EXPECT_EQ(fs::status(folder_.path() / "store" / StorePath(sha256_)).permissions(),
            fs::perms(0644));
}

TEST_F(StoreTest, AFolderSaysWhyItDoesntTakeAFile) {
  const auto store = OpenStore((folder_ / "store").string());
  const auto put = [&] { Put(*store); };
  {
    const FileSizeLimit limit(10'000);
    const std::string error = Failure(put, ErrorCode::kFileUnwritable);
    EXPECT_NE(error.find("can't be written: File too large, 0.1 MB required"), std::string::npos)
        << error;
  }
  Put(*store);
  const fs::path kept = folder_.path() / "store" / StorePath(sha256_);
  EXPECT_EQ(std::distance(fs::directory_iterator(kept.parent_path()), {}), 1) << "nothing is left";
  fs::remove(folder_ / "map.db");
  fs::remove(kept);
  const std::string error = Failure(put, ErrorCode::kFileUnreadable);
  EXPECT_NE(error.find("map.db: No such file"), std::string::npos) << error;
}

TEST_F(StoreTest, AFolderOnAFullDiskIsSaid) {
  fs::create_directory(folder_ / "store");
  const MountedFolder disk(folder_ / "store", "size=64k");
  if (!disk.mounted()) GTEST_SKIP() << "mounting a file system isn't possible here";
  const auto store = OpenStore((folder_ / "store").string());
  const std::string error = Failure([&] { Put(*store); }, ErrorCode::kFileUnwritable);
  EXPECT_NE(error.find("can't be written: No space left on device, 0.1 MB required, 0.1 MB free"),
            std::string::npos)
      << error;
}

TEST_F(StoreTest, AFileThatIsAnotherByNowIsRefused) {
  StoreServer server;
  WriteBytes(folder_ / "map.db", "another map");
  for (const std::string& location : {(folder_ / "store").string(), server.url()}) {
    const auto store = OpenStore(location);
    EXPECT_NE(Failure([&] { Put(*store); }, ErrorCode::kFileUnreadable)
                  .find("was replaced by another program"),
              std::string::npos);
    EXPECT_THROW(Fetched(*store, 0), MapError);
  }
}

TEST_F(StoreTest, AServerTakesAndGivesFiles) {
  StoreServer server;
  const auto store = OpenStore(server.url());
  Put(*store);
  EXPECT_TRUE(server.files["/maps/" + StorePath(sha256_)] == bytes_);
  EXPECT_TRUE(Fetched(*store, 0).text == bytes_);
  const TextSink rest = Fetched(*store, 60'000);
  EXPECT_EQ(rest.begun, 60'000);
  EXPECT_TRUE(rest.text.substr(60'000) == bytes_.substr(60'000));
  TextSink some;
  some.limit = 1;
  store->Fetch(sha256_, 0, std::ssize(bytes_), some);
  EXPECT_LT(some.text.size(), bytes_.size()) << "the sink ended it";
}

TEST_F(StoreTest, AServerWithoutRangesSendsAll) {
  StoreServer server;
  const auto store = OpenStore(server.url());
  Put(*store);
  server.ranges = false;
  const TextSink all = Fetched(*store, 60'000);
  EXPECT_EQ(all.begun, 0);
  EXPECT_TRUE(all.text == bytes_);
}

TEST_F(StoreTest, WhatAServerHasNotIsSaid) {
  StoreServer server;
  const auto store = OpenStore(server.url());
  EXPECT_NE(Failure([&] { Fetched(*store, 0); }, ErrorCode::kStoreUnavailable).find("status 404"),
            std::string::npos);
  server.files["/maps/" + StorePath(sha256_)] = bytes_.substr(0, 5000);
  EXPECT_NE(Failure([&] { Fetched(*store, 0); }, ErrorCode::kStoreUnavailable).find("ends early"),
            std::string::npos);
  EXPECT_NE(
      Failure([&] { Fetched(*store, 6000); }, ErrorCode::kStoreUnavailable).find("ends early"),
      std::string::npos);
  server.takes = false;
  EXPECT_NE(Failure([&] { Put(*store); }, ErrorCode::kFileUnwritable).find("status 403"),
            std::string::npos);
}

TEST_F(StoreTest, AServerThatIsAwayIsSaid) {
  std::string url;
  {
    StoreServer server;
    url = server.url();
  }
  const auto store = OpenStore(url);
  Failure([&] { Fetched(*store, 0); }, ErrorCode::kStoreUnavailable);
  Failure([&] { Put(*store); }, ErrorCode::kStoreUnavailable);
}

TEST_F(StoreTest, TheTokenIsSent) {
  StoreServer server;
  Put(*OpenStore(server.url()));
  server.token = "secret";
  EXPECT_THROW(Fetched(*OpenStore(server.url()), 0), MapError);
  setenv("WAYSTONE_STORE_TOKEN", "secret", 1);
  const auto store = OpenStore(server.url());
  unsetenv("WAYSTONE_STORE_TOKEN");
  EXPECT_TRUE(Fetched(*store, 0).text == bytes_);
}

TEST_F(StoreTest, WhatIsNoStoreIsRefused) {
  for (const std::string location : {"", "s3://bucket", "http://", "https:///x"}) {
    Failure([&] { OpenStore(location); }, ErrorCode::kUsage);
  }
  for (const std::string port : {"99999999999", "65536", "0", "-1", "x", ""}) {
    for (const std::string host : {"http://localhost:", "https://[::1]:"}) {
      EXPECT_NE(Failure([&] { OpenStore(host + port + "/maps"); }, ErrorCode::kUsage)
                    .find("no port from 1 to 65535"),
                std::string::npos);
    }
  }
  for (const std::string location :
       {"http://localhost", "http://[::1]/x", "http://[::1]:65535/x"}) {
    EXPECT_NO_THROW(OpenStore(location));
  }
}

}  // namespace
}  // namespace waystone
