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

// Logs queries, so that they can be asked again (api/logged_query.h has the format). The folder
// holds photos of people's rooms: only their owner can read it and its files, whatever the umask.
// Images and lines are written whole or not at all: what a program that was killed left of either
// is removed. Thread-safe.
class QueryLog {
 public:
  // Creates the folder. Writes nothing more once it holds `max_bytes`; `on_error` gets a line for
  // that and for files that can't be written, from any thread. Throws MapError(kFileUnwritable).
  QueryLog(std::filesystem::path folder, int64_t max_bytes,
           std::function<void(const std::string&)> on_error);

  // Leaves out a query of which a part can't be written, and removes what was already written of
  // it.
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
