// SPDX-License-Identifier: Apache-2.0
#include "registry/http_store.h"

#include <httplib.h>

#include <algorithm>
#include <cstdlib>
#include <exception>
#include <fstream>
#include <optional>
#include <vector>

#include "core/base/error.h"
#include "core/base/text.h"
#include "schema/file/sha256.h"

namespace waystone {
namespace {

constexpr int kConnectS = 3;
// How long the store may send nothing: not long, because a server that stops waits for it, and an
// interrupted copy resumes later.
constexpr int kSilentS = 4;
constexpr int kPutS = 60;  // the same while it stores a file
constexpr size_t kSentBlockBytes = 1 << 18;

constexpr int kOk = 200;
constexpr int kPartial = 206;
constexpr int kBadRange = 416;
constexpr int kServerError = 500;  // and above

bool IsSuccess(int status) { return status >= 200 && status < 300; }

// Whether an origin has no port, or one from 1 to 65535: the library doesn't check it.
bool HasUsablePort(const std::string& origin) {
  const size_t bracket = origin.rfind(']');  // behind an IPv6 address
  const size_t host = bracket == std::string::npos ? origin.find("://") + 3 : bracket;
  const size_t colon = origin.find(':', host);
  if (colon == std::string::npos) return true;
  constexpr int64_t kMostPort = 65'535;
  const std::optional<int64_t> port = ToInteger(origin.substr(colon + 1));
  return port && 1 <= *port && *port <= kMostPort;
}

class HttpStore : public Store {
 public:
  explicit HttpStore(const std::string& base) {
    const size_t host = base.find("://") + 3;
    const size_t path = std::min(base.find('/', host), base.size());
    if (path == host) {
      throw MapError(ErrorCode::kUsage,
                     "'" + base + "' names no host; give http(s)://HOST/PATH (--store)");
    }
    origin_ = base.substr(0, path);
    if (!HasUsablePort(origin_)) {
      throw MapError(
          ErrorCode::kUsage,
          "'" + base + "' has no port from 1 to 65535; give http(s)://HOST:PORT/PATH (--store)");
    }
    prefix_ = base.substr(path);
    while (!prefix_.empty() && prefix_.back() == '/') prefix_.pop_back();
    const char* token = std::getenv("WAYSTONE_STORE_TOKEN");
    if (token && *token) headers_.emplace("Authorization", std::string("Bearer ") + token);
  }

  void Put(const std::filesystem::path& file, const std::string& sha256,
           int64_t bytes) const override {
    if (Sha256OfFile(file) != sha256) ThrowChanged(file);
    httplib::Client client = NewClient(kPutS);
    const std::string path = PathOf(sha256);
    std::ifstream in(file, std::ios::binary);
    std::vector<char> block(kSentBlockBytes);
    const auto send = [&](size_t offset, size_t length, httplib::DataSink& out) {
      in.seekg(static_cast<std::streamoff>(offset));
      in.read(block.data(), static_cast<std::streamsize>(std::min(length, block.size())));
      return in.gcount() > 0 && out.write(block.data(), static_cast<size_t>(in.gcount()));
    };
    const auto result =
        client.Put(path, headers_, static_cast<size_t>(bytes), send, "application/octet-stream");
    if (!result) Fail(path, httplib::to_string(result.error()));
    if (Has(client, path, bytes)) return;  // also if it refuses a file that it has
    if (result->status >= kServerError) Fail(path, "status " + std::to_string(result->status));
    Refuse(path, IsSuccess(result->status) ? "the store hasn't kept the file"
                                           : "status " + std::to_string(result->status));
  }

  void Fetch(const std::string& sha256, int64_t offset, int64_t bytes,
             FileSink& sink) const override {
    httplib::Client client = NewClient(kSilentS);
    const std::string path = PathOf(sha256);
    httplib::Headers headers = headers_;
    if (offset > 0) headers.emplace("Range", "bytes=" + std::to_string(offset) + "-");
    Transfer transfer{offset, bytes, &sink, 0, false, nullptr};
    const auto result = client.Get(
        path, headers, [&](const httplib::Response& head) { return transfer.Begin(head); },
        [&](const char* data, size_t length) { return transfer.Take(data, length); });
    if (transfer.error) std::rethrow_exception(transfer.error);
    if (transfer.ended) return;
    if (transfer.status == kBadRange && offset > 0) return Fetch(sha256, 0, bytes, sink);
    if (transfer.status != 0 && transfer.status != kOk && transfer.status != kPartial) {
      Fail(path, "status " + std::to_string(transfer.status));
    }
    if (!result) Fail(path, httplib::to_string(result.error()));
    if (transfer.next < bytes) Fail(path, "the file ends early");
  }

 private:
  // One answer of the store. The library's callbacks must not throw.
  struct Transfer {
    int64_t next;   // offset of the next byte
    int64_t bytes;  // of the whole file
    FileSink* sink;
    int status;
    bool ended;                // by the sink
    std::exception_ptr error;  // of the sink

    bool Begin(const httplib::Response& head) {
      status = head.status;
      if (status != kOk && status != kPartial) return false;
      return Guarded([&] {
        if (status == kOk) next = 0;
        sink->Begin(next);
        return true;
      });
    }
    bool Take(const char* data, size_t length) {
      const auto wanted =
          static_cast<size_t>(std::clamp<int64_t>(bytes - next, 0, static_cast<int64_t>(length)));
      return Guarded([&] {
        next += static_cast<int64_t>(length);  // more than it should be, for a longer file
        return wanted == 0 || sink->Take({data, wanted});
      });
    }
    template <class Call>
    bool Guarded(const Call& call) {
      try {
        if (call()) return true;
        ended = true;
      } catch (...) {
        error = std::current_exception();
      }
      return false;
    }
  };

  httplib::Client NewClient(int silent_s) const {
    httplib::Client client(origin_);
    client.set_connection_timeout(kConnectS);
    client.set_read_timeout(silent_s);
    client.set_write_timeout(silent_s);
    client.set_follow_location(headers_.empty());  // a token is for this store alone
    client.set_tcp_nodelay(true);
    return client;
  }
  std::string PathOf(const std::string& sha256) const { return prefix_ + "/" + StorePath(sha256); }

  bool Has(httplib::Client& client, const std::string& path, int64_t bytes) const {
    const auto result = client.Head(path, headers_);
    return result && result->status == kOk &&
           result->get_header_value("Content-Length") == std::to_string(bytes);
  }

  [[noreturn]] void Refuse(const std::string& path, const std::string& cause) const {
    throw MapError(ErrorCode::kFileUnwritable,
                   origin_ + path + " can't be written: " + cause +
                       "; check the store (--store), its rights and WAYSTONE_STORE_TOKEN");
  }
  [[noreturn]] void Fail(const std::string& path, const std::string& cause) const {
    throw MapError(ErrorCode::kStoreUnavailable,
                   origin_ + path + ": " + cause + "; check the store (--store)");
  }

  std::string origin_;
  std::string prefix_;
  httplib::Headers headers_;
};

}  // namespace

std::unique_ptr<Store> OpenHttpStore(const std::string& base) {
  return std::make_unique<HttpStore>(base);
}

}  // namespace waystone
