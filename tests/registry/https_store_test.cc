// SPDX-License-Identifier: Apache-2.0
// A store behind TLS, with a certificate of an authority that is trusted, or isn't.
#include <gtest/gtest.h>
// After Eigen, for which the macro _res of the resolver's header spells trouble.
#include <httplib.h>

#include <cstdlib>
#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <thread>

#include "core/base/error.h"
#include "registry/map_cache.h"
#include "registry/store.h"
#include "schema/file/sha256.h"
#include "tests/registry/test_folder.h"

namespace waystone {
namespace {

namespace fs = std::filesystem;

// The authorities that OpenSSL trusts, while this exists.
class Trusting {
 public:
  explicit Trusting(const fs::path& certificates) {
    setenv("SSL_CERT_FILE", certificates.c_str(), 1);
    setenv("SSL_CERT_DIR", "/nonexistent", 1);
  }
  ~Trusting() {
    unsetenv("SSL_CERT_FILE");
    unsetenv("SSL_CERT_DIR");
  }
  Trusting(const Trusting&) = delete;
  Trusting& operator=(const Trusting&) = delete;
};

class HttpsStoreTest : public testing::Test {
 protected:
  void SetUp() override {
    const std::string command =
        "openssl req -x509 -newkey ec -pkeyopt ec_paramgen_curve:prime256v1 -nodes -days 2 "
        "-subj /CN=localhost -addext subjectAltName=DNS:localhost -keyout " +
        Key().string() + " -out " + Certificate().string() + " 2> " + (folder_ / "log").string();
    const int status = std::system(command.c_str());  // NOLINT(cert-env33-c): our own paths
    ASSERT_EQ(status, 0) << ReadAll(folder_ / "log");
    WriteBytes(folder_ / "map.db", bytes_);
    sha256_ = Sha256OfFile(folder_ / "map.db");
    server_ = std::make_unique<httplib::SSLServer>(Certificate().c_str(), Key().c_str());
    ASSERT_TRUE(server_->is_valid());
    server_->Get("/.*", [this](const httplib::Request& in, httplib::Response& out) {
      const std::lock_guard lock(mutex_);
      const auto it = files_.find(in.path);
      out.status = it == files_.end() ? 404 : 200;
      if (it != files_.end()) out.set_content(it->second, "application/octet-stream");
    });
    server_->Put("/.*", [this](const httplib::Request& in, httplib::Response& out) {
      const std::lock_guard lock(mutex_);
      files_[in.path] = in.body;
      out.status = 201;
    });
    port_ = server_->bind_to_any_port("127.0.0.1");
    thread_ = std::thread([this] { server_->listen_after_bind(); });
    while (!server_->is_running()) std::this_thread::yield();
  }
  void TearDown() override {
    if (!thread_.joinable()) return;
    server_->stop();
    thread_.join();
  }
  fs::path Key() const { return folder_ / "key.pem"; }
  fs::path Certificate() const { return folder_ / "certificate.pem"; }
  std::string Address(const std::string& host) const {
    return "https://" + host + ":" + std::to_string(port_) + "/maps";
  }
  void Put(const Store& store) const { store.Put(folder_ / "map.db", sha256_, std::ssize(bytes_)); }
  std::string PutFailure(const Store& store) const {
    try {
      Put(store);
    } catch (const MapError& error) {
      EXPECT_EQ(error.code(), ErrorCode::kStoreUnavailable) << error.what();
      return error.what();
    }
    return "";
  }

  const std::string bytes_ = std::string(300'000, 'x') + "end";
  TestFolder folder_;
  std::string sha256_;
  std::unique_ptr<httplib::SSLServer> server_;
  std::mutex mutex_;
  std::map<std::string, std::string> files_;
  int port_ = 0;
  std::thread thread_;
};

TEST_F(HttpsStoreTest, FilesComeAndGoThroughTls) {
  const Trusting certificate(Certificate());
  const auto store = OpenStore(Address("localhost"));
  Put(*store);
  EXPECT_TRUE(files_["/maps/" + StorePath(sha256_)] == bytes_);
  MapCache cache(folder_ / "cache", 1'000'000);
  EXPECT_TRUE(ReadAll(cache.Get(*store, sha256_, std::ssize(bytes_))->path()) == bytes_);
}

TEST_F(HttpsStoreTest, AStrangersCertificateIsRefused) {
  const Trusting certificate(folder_ / "no such file");
  EXPECT_NE(PutFailure(*OpenStore(Address("localhost"))).find("SSL"), std::string::npos);
  EXPECT_TRUE(files_.empty());
}

TEST_F(HttpsStoreTest, ACertificateOfAnotherHostIsRefused) {
  const Trusting certificate(Certificate());
  EXPECT_NE(PutFailure(*OpenStore(Address("127.0.0.1"))).find("SSL"), std::string::npos);
  EXPECT_TRUE(files_.empty());
}

}  // namespace
}  // namespace waystone
