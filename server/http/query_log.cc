// SPDX-License-Identifier: Apache-2.0
#include "server/http/query_log.h"

#include <openssl/sha.h>

#include <array>
#include <chrono>
#include <fstream>
#include <iterator>
#include <utility>

#include "core/base/error.h"

namespace waystone {
namespace {

namespace fs = std::filesystem;

constexpr const char* kLines = "queries.jsonl";

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
    if (entry.is_regular_file()) bytes += static_cast<int64_t>(entry.file_size());
  }
  return bytes;
}

std::string ReadWhole(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  if (!in) throw MapError(ErrorCode::kFileUnreadable, path.string() + " can't be read");
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

LoggedQuery ParseLine(const fs::path& folder, const std::string& line) {
  const Json json = Json::parse(line);
  LoggedQuery query;
  query.id = json.at("id").get<std::string>();
  query.map = json.at("map");
  query.answer = json.at("answer");
  query.request = ParseRequestObject(json.at("request"), {});
  for (const Json& image : json.at("images")) {
    // The name alone: a log from elsewhere must not read files beside it.
    const fs::path file = fs::path(image.at("file").get<std::string>()).filename();
    query.request.images.push_back({image.at("name").get<std::string>(), ReadWhole(folder / file)});
  }
  return query;
}

}  // namespace

QueryLog::QueryLog(fs::path folder, int64_t max_bytes,
                   std::function<void(const std::string&)> on_error)
    : folder_(std::move(folder)), max_bytes_(max_bytes), on_error_(std::move(on_error)) {
  std::error_code error;
  if (fs::create_directories(folder_, error)) {
    fs::permissions(folder_, fs::perms::owner_all, error);
  }
  if (!std::ofstream(folder_ / kLines, std::ios::app)) {
    throw MapError(ErrorCode::kFileUnwritable,
                   folder_.string() + " can't be written; choose another folder for --query-log");
  }
  bytes_ = BytesIn(folder_);
}

void QueryLog::Add(const std::string& id, const Json& map, const LocalizeRequest& request,
                   const Json& answer) {
  const std::lock_guard lock(mutex_);
  if (full_) return;
  Json line = {{"id", id},
               {"time_s", SecondsSinceEpoch()},
               {"map", map},
               {"request", RequestObject(request)},
               {"images", Json::array()}};
  for (const QueryImage& image : request.images) {
    line["images"].push_back({{"name", image.name}, {"file", Store(image.bytes)}});
  }
  line["answer"] = answer;
  const std::string text = Dump(line) + "\n";
  std::ofstream out(folder_ / kLines, std::ios::app | std::ios::binary);
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

std::vector<LoggedQuery> ReadQueryLog(const fs::path& folder) {
  std::ifstream in(folder / kLines, std::ios::binary);
  if (!in) {
    throw MapError(ErrorCode::kFileUnreadable,
                   (folder / kLines).string() +
                       " can't be read; expected a folder written by `waystone serve --query-log`");
  }
  std::vector<LoggedQuery> queries;
  int number = 0;
  for (std::string line; std::getline(in, line);) {
    ++number;
    try {
      queries.push_back(ParseLine(folder, line));
    } catch (const Json::exception&) {
      throw MapError(ErrorCode::kBadRequest, (folder / kLines).string() + ", line " +
                                                 std::to_string(number) +
                                                 " is not a logged query; remove the line");
    }
  }
  return queries;
}

}  // namespace waystone
