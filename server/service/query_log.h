// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <mutex>
#include <string>
#include <vector>

#include "api/json.h"
#include "localizer/query.h"

namespace waystone {

// Writes what was asked, for asking it again (api/logged_query.h has the format). Thread-safe. The
// folder holds photos of people's rooms: it and its files are made for their owner alone, whatever
// the umask. Images are written whole or not at all, and so are lines: what a program that was
// killed left of either is removed.
class QueryLog {
 public:
  // Makes the folder. Writes nothing more once it holds `max_bytes`; `on_error` hears of that and
  // of files that can't be written. Throws MapError(kFileUnwritable).
  QueryLog(std::filesystem::path folder, int64_t max_bytes,
           std::function<void(const std::string&)> on_error);

  // A query of which a part can't be written is left out, with what of it was written before.
  void Add(const std::string& id, const Json& map, const QueryRequest& request, const Json& answer);

 private:
  class NewImages;

  void Count(int64_t bytes);
  // With the lock held, as one: what another query stored meanwhile might be removed again.
  void Write(const QueryRequest& request, const std::vector<std::string>& files,
             const std::string& line);
  void Store(const std::string& bytes, const std::string& file, NewImages& images);

  std::filesystem::path folder_;
  int64_t max_bytes_;
  std::function<void(const std::string&)> on_error_;
  std::mutex mutex_;  // of the files
  std::atomic<int64_t> bytes_ = 0;
};

}  // namespace waystone
