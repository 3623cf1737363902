// SPDX-License-Identifier: Apache-2.0
#include "registry/store.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <system_error>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "registry/http_store.h"
#include "schema/file/file_replacer.h"
#include "schema/file/sha256.h"

namespace waystone {
namespace {

namespace fs = std::filesystem;

constexpr size_t kBlockBytes = 1 << 20;

// Copies a file over one that is there, whose permissions stay. In place of fs::copy_file, to which
// a full disk is an "Input/output error".
void CopyBytes(const fs::path& file, const fs::path& temporary, const fs::path& target,
               int64_t bytes) {
  errno = 0;
  std::ifstream in(file, std::ios::binary);
  std::ofstream out(temporary, std::ios::binary);
  std::vector<char> block(kBlockBytes);
  while (in && out) {
    in.read(block.data(), std::ssize(block));
    if (in.bad()) break;
    out.write(block.data(), in.gcount()).flush();
  }
  const std::string cause = errno == 0 ? "cannot be read" : std::strerror(errno);
  if (!out) {
    std::error_code ignored;
    out.close();
    fs::remove(temporary, ignored);  // so that what is free is all that is
    throw UnwritableError(target, cause, bytes);
  }
  if (!in.eof()) {
    throw MapError(ErrorCode::kFileUnreadable,
                   file.string() + ": " + cause + "; check the path and the disk");
  }
}

class FolderStore : public Store {
 public:
  explicit FolderStore(fs::path folder) : folder_(std::move(folder)) {}

  void Put(const fs::path& file, const std::string& sha256, int64_t bytes) const override {
    const fs::path target = folder_ / StorePath(sha256);
    std::error_code error;
    if (fs::exists(target, error) && Sha256OfFile(target) == sha256) return;
    fs::create_directories(target.parent_path(), error);
    if (error) throw UnwritableError(target, error.message(), bytes);
    FileReplacer written(target, true);
    CopyBytes(file, written.temporary(), target, bytes);
    if (Sha256OfFile(written.temporary()) != sha256) ThrowChanged(file);
    written.Commit();
  }

  void Fetch(const std::string& sha256, int64_t offset, int64_t bytes,
             FileSink& sink) const override {
    const fs::path source = folder_ / StorePath(sha256);
    errno = 0;
    std::ifstream in(source, std::ios::binary);
    in.seekg(offset);
    if (!in) Fail(source, std::strerror(errno));
    sink.Begin(offset);
    std::vector<char> block(kBlockBytes);
    int64_t left = bytes - offset;
    while (left > 0) {
      errno = 0;
      in.read(block.data(), std::min<int64_t>(left, std::ssize(block)));
      if (in.gcount() == 0) Fail(source, errno == 0 ? "ends early" : std::strerror(errno));
      if (!sink.Take({block.data(), static_cast<size_t>(in.gcount())})) return;
      left -= in.gcount();
    }
  }

 private:
  [[noreturn]] static void Fail(const fs::path& source, const std::string& cause) {
    throw MapError(ErrorCode::kStoreUnavailable,
                   source.string() + ": " + cause + "; check the store (--store)");
  }

  fs::path folder_;
};

}  // namespace

void ThrowChanged(const fs::path& file) {
  throw MapError(ErrorCode::kFileUnreadable,
                 file.string() + " was replaced by another program meanwhile; try again");
}

std::unique_ptr<Store> OpenStore(const std::string& location) {
  if (location.starts_with("http://") || location.starts_with("https://")) {
    return OpenHttpStore(location);
  }
  if (location.empty() || location.find("://") != std::string::npos) {
    throw MapError(ErrorCode::kUsage, "'" + location +
                                          "' is not a store; give a folder or an address "
                                          "http(s)://HOST/PATH (--store)");
  }
  return std::make_unique<FolderStore>(location);
}

std::string StorePath(const std::string& sha256) {
  const std::string digits = sha256.substr(sha256.find(':') + 1);
  return digits.substr(0, 2) + "/" + digits + ".db";
}

}  // namespace waystone
