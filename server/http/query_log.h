// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <mutex>
#include <string>
#include <vector>

#include "server/http/localize_request.h"

namespace waystone {

// What was asked, for asking it again (`waystone replay`): a folder with queries.jsonl, one object
// a query {id, time, map, request, images: [{name, file}], answer}, and the images' bytes, each
// once, in files named by their SHA-256. `map` is null for a query across all maps. Thread-safe.
// The folder holds photos of people's rooms: it is made for its owner alone.
class QueryLog {
 public:
  // Makes the folder. Writes nothing more once it holds `max_bytes`; `on_error` hears of that and
  // of files that can't be written. Throws MapError(kFileUnwritable).
  QueryLog(std::filesystem::path folder, int64_t max_bytes,
           std::function<void(const std::string&)> on_error);

  void Add(const std::string& id, const Json& map, const LocalizeRequest& request,
           const Json& answer);

 private:
  std::string Store(const std::string& bytes);

  std::filesystem::path folder_;
  int64_t max_bytes_;
  std::function<void(const std::string&)> on_error_;
  std::mutex mutex_;
  int64_t bytes_ = 0;
  bool full_ = false;
};

// One line of a log, with its images read back.
struct LoggedQuery {
  std::string id;
  Json map;
  LocalizeRequest request;
  Json answer;
};

// All queries of a log in their order. Throws MapError: kFileUnreadable; kBadRequest with the line.
std::vector<LoggedQuery> ReadQueryLog(const std::filesystem::path& folder);

}  // namespace waystone
