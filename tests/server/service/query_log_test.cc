// SPDX-License-Identifier: Apache-2.0
#include "server/service/query_log.h"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <csignal>
#include <filesystem>
#include <string>
#include <vector>

#include "api/logged_query.h"
#include "tests/registry/test_folder.h"

namespace waystone {
namespace {

// Files larger than a bound can't be written, as on a full disk, while this exists.
class FileSizeLimit {
 public:
  explicit FileSizeLimit(rlim_t bytes) : handler_(std::signal(SIGXFSZ, SIG_IGN)) {
    getrlimit(RLIMIT_FSIZE, &before_);
    const rlimit limit = {bytes, before_.rlim_max};
    setrlimit(RLIMIT_FSIZE, &limit);
  }
  ~FileSizeLimit() {
    setrlimit(RLIMIT_FSIZE, &before_);
    std::signal(SIGXFSZ, handler_);
  }
  FileSizeLimit(const FileSizeLimit&) = delete;
  FileSizeLimit& operator=(const FileSizeLimit&) = delete;

 private:
  void (*handler_)(int);
  rlimit before_ = {};
};

// `replay` reads the log of a disk that was full for a while.
TEST(QueryLog, HasWholeQueriesAlone) {
  const TestFolder folder;
  std::vector<std::string> errors;
  QueryLog log(folder / "log", 1'000'000,
               [&](const std::string& error) { errors.push_back(error); });
  const auto add = [&](const std::string& bytes) {
    QueryRequest request;
    request.images.push_back({"photo", bytes});
    log.Add("id", "lab", request, {{"verdict", "not_in_map"}});
  };
  add("one");
  {
    const FileSizeLimit limit(std::filesystem::file_size(folder / "log" / kQueryLogLines) + 20);
    add("the line is cut");
  }
  {
    const FileSizeLimit limit(5000);
    add(std::string(10'000, 'x'));
  }
  EXPECT_EQ(errors.size(), 2u);
  add("two");
  const std::vector<LoggedQuery> queries = ReadQueryLog(folder / "log");
  ASSERT_EQ(queries.size(), 2u);
  EXPECT_EQ(queries[1].request.images[0].bytes, "two");
}

}  // namespace
}  // namespace waystone
