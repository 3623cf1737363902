// SPDX-License-Identifier: Apache-2.0
#include "server/http/query_log.h"

#include <openssl/sha.h>

#include <array>
#include <chrono>
#include <fstream>
#include <utility>
#include <vector>

#include "api/logged_query.h"
#include "core/base/error.h"

namespace waystone {
namespace {

namespace fs = std::filesystem;

std::string Sha256Hex(const std::string& bytes) {
  std::array<unsigned char, SHA256_DIGEST_LENGTH> digest{};
  SHA256(reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size(), digest.data());
  static constexpr char kDigits[] = "0123456789abcdef";
  std::string hex;
  for (const unsigned char byte : digest) hex += {kDigits[byte >> 4], kDigits[byte & 15]};
  return hex;
}

double SecondsSinceEpoch() {
  return std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch()).count();
}

int64_t BytesIn(const fs::path& folder) {
  int64_t bytes = 0;
  for (const auto& entry : fs::directory_iterator(folder)) {
    std::error_code ignored;  // of a link that leads nowhere
    if (entry.is_regular_file(ignored)) bytes += static_cast<int64_t>(entry.file_size(ignored));
  }
  return bytes;
}

}  // namespace

QueryLog::QueryLog(fs::path folder, int64_t max_bytes,
                   std::function<void(const std::string&)> on_error)
    : folder_(std::move(folder)), max_bytes_(max_bytes), on_error_(std::move(on_error)) {
  std::error_code error;
  if (fs::create_directories(folder_, error)) {
    fs::permissions(folder_, fs::perms::owner_all, error);
  }
  if (!std::ofstream(folder_ / kQueryLogLines, std::ios::app)) {
    throw MapError(ErrorCode::kFileUnwritable,
                   folder_.string() + " can't be written; choose another folder for --query-log");
  }
  bytes_ = BytesIn(folder_);
}

void QueryLog::Add(const std::string& id, const Json& map, const QueryRequest& request,
                   const Json& answer) {
  const std::lock_guard lock(mutex_);
  if (full_) return;
  std::vector<std::string> files;
  for (const QueryImage& image : request.images) files.push_back(Store(image.bytes));
  const std::string text =
      Dump(LoggedQueryJson({id, map, request, answer}, SecondsSinceEpoch(), files)) + "\n";
  std::ofstream out(folder_ / kQueryLogLines, std::ios::app | std::ios::binary);
  if (!(out << text).flush()) on_error_("the query log " + folder_.string() + " can't be written");
  bytes_ += static_cast<int64_t>(text.size());
  full_ = bytes_ >= max_bytes_;
  if (full_)
    on_error_("the query log " + folder_.string() + " is full; further queries are not logged");
}

std::string QueryLog::Store(const std::string& bytes) {
  std::string name = Sha256Hex(bytes) + ".image";
  if (fs::exists(folder_ / name)) return name;
  std::ofstream out(folder_ / name, std::ios::binary);
  if (!out.write(bytes.data(), static_cast<std::streamsize>(bytes.size())).flush()) {
    on_error_("an image of the query log " + folder_.string() + " can't be written");
  }
  bytes_ += static_cast<int64_t>(bytes.size());
  return name;
}

}  // namespace waystone
