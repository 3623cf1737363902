// SPDX-License-Identifier: Apache-2.0
#include "server/service/query_log.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "api/logged_query.h"
#include "tests/api/read_queries.h"
#include "tests/registry/file_size_limit.h"
#include "tests/registry/test_folder.h"

namespace waystone {
namespace {

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
  const std::vector<LoggedQuery> queries = ReadQueries(folder / "log");
  ASSERT_EQ(queries.size(), 2u);
  EXPECT_EQ(queries[1].request.images[0].bytes, "two");
}

size_t CountImages(const std::filesystem::path& folder) {
  size_t count = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    count += entry.path().extension() == ".image" ? 1 : 0;
  }
  return count;
}

// What the disk had room for of a query that isn't logged would stay there for good.
TEST(QueryLog, ImagesOfAQueryThatIsLeftOutGo) {
  const TestFolder folder;
  std::vector<std::string> errors;
  QueryLog log(folder / "log", 100'000, [&](const std::string& error) { errors.push_back(error); });
  const auto add = [&](const std::vector<std::string>& images) {
    QueryRequest request;
    for (const std::string& bytes : images) request.images.push_back({"photo", bytes});
    log.Add("id", "lab", request, {{"verdict", "not_in_map"}});
  };
  add({"kept"});
  {
    const FileSizeLimit limit(5000);
    add({"kept", "first", std::string(10'000, 'x')});
  }
  EXPECT_EQ(CountImages(folder / "log"), 1u) << "that of the query before";
  {
    const FileSizeLimit limit(std::filesystem::file_size(folder / "log" / kQueryLogLines) + 20);
    add({"kept", "the line is cut"});
  }
  EXPECT_EQ(CountImages(folder / "log"), 1u);
  ASSERT_EQ(errors.size(), 2u);
  for (const std::string& error : errors) {
    EXPECT_NE(error.find("can't be written: File too large"), std::string::npos) << error;
    EXPECT_NE(error.find("; free up space"), std::string::npos) << error;
  }
  add({"first", "second"});
  EXPECT_EQ(CountImages(folder / "log"), 3u);
  EXPECT_EQ(ReadQueries(folder / "log").size(), 2u);
}

void WriteText(const std::filesystem::path& path, const std::string& text) {
  std::ofstream(path, std::ios::binary) << text;
}

// A program that was killed while it wrote leaves parts of an image and of a line.
TEST(QueryLog, GoesOnAfterAKill) {
  const TestFolder folder;
  const std::filesystem::path log = folder / "log";
  std::vector<std::string> errors;
  const auto on_error = [&](const std::string& error) { errors.push_back(error); };
  QueryRequest request;
  request.images.push_back({"photo", "an image"});
  const Json answer = {{"verdict", "not_in_map"}};
  QueryLog(log, 1'000'000, on_error).Add("id", "lab", request, answer);
  const std::string image = ReadQueries(log).at(0).request.images[0].bytes;
  for (const auto& entry : std::filesystem::directory_iterator(log)) {
    if (entry.path().extension() == ".image") WriteText(entry.path(), "an im");
  }
  WriteText(log / ".part-abcdef", "an im");
  std::ofstream(log / kQueryLogLines, std::ios::app) << R"({"id": "b", "time)";
  QueryLog(log, 1'000'000, on_error).Add("id2", "lab", request, answer);
  const std::vector<LoggedQuery> queries = ReadQueries(log);
  ASSERT_EQ(queries.size(), 2U);
  EXPECT_EQ(queries[0].request.images[0].bytes, image);
  EXPECT_EQ(queries[1].id, "id2");
  EXPECT_FALSE(std::filesystem::exists(log / ".part-abcdef"));
  EXPECT_TRUE(errors.empty());
}

TEST(QueryLog, StaysFullAfterARestart) {
  const TestFolder folder;
  std::vector<std::string> errors;
  const auto on_error = [&](const std::string& error) { errors.push_back(error); };
  QueryRequest request;
  request.images.push_back({"photo", "an image"});
  for (int i = 0; i < 2; ++i) {
    QueryLog(folder / "log", 10, on_error).Add("id", "lab", request, {{"verdict", "bad_image"}});
  }
  EXPECT_EQ(ReadQueries(folder / "log").size(), 1U);
  EXPECT_EQ(errors.size(), 2U) << "each server says once that it is full";
}

}  // namespace
}  // namespace waystone
