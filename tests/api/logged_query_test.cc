// SPDX-License-Identifier: Apache-2.0
#include "api/logged_query.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <string>

#include "api/query_request_json.h"
#include "core/base/error.h"
#include "tests/api/read_queries.h"

namespace waystone {
namespace {

namespace fs = std::filesystem;

class LoggedQueryTest : public testing::Test {
 protected:
  LoggedQueryTest() {
    std::string name = (fs::temp_directory_path() / "waystone-log-XXXXXX").string();
    EXPECT_NE(mkdtemp(name.data()), nullptr);
    folder_ = name;
    std::ofstream(folder_ / "a.jpg") << "an image";
  }
  ~LoggedQueryTest() override { fs::remove_all(folder_); }

  // A sound line with `value` in place of a field, which `pointer` names; without it for nothing.
  static std::string LineWith(const std::string& pointer, const std::string& value) {
    Json line = Json::parse(R"({"id": "a1", "time_s": 12.5, "map": "lab", "request": {"top_k": 3},
        "images": [{"name": "q.jpg", "file": "a.jpg"}],
        "answer": {"verdict": "localized", "keyframe": {"sequence": "walk", "source": "1.jpg"},
                   "panorama": {"node": {"sequence": "s", "source": "2.jpg"}}, "belief": []}})");
    if (!pointer.empty()) line[Json::json_pointer(pointer)] = Json::parse(value);
    return Dump(line);
  }

  std::vector<LoggedQuery> Read(const std::string& lines) {
    std::ofstream(folder_ / kQueryLogLines) << lines;
    return ReadQueries(folder_);
  }

  // What reading says of a log whose second line is this one.
  std::string ErrorOf(const std::string& line) {
    try {
      Read(LineWith("", "") + "\n" + line + "\n");
    } catch (const MapError& error) {
      return error.what();
    }
    return "";
  }

  fs::path folder_;
};

TEST_F(LoggedQueryTest, TellsWhatAnAnswerCameTo) {
  const std::vector<LoggedQuery> queries =
      Read(LineWith("", "") + "\n" + LineWith("/answer", R"({"verdict": "not_in_map"})") + "\n" +
           LineWith("/answer/panorama/node", "null"));
  ASSERT_EQ(queries.size(), 3U);
  EXPECT_EQ(queries[0].outcome, (QueryOutcome{"localized", "s/2.jpg"}));
  EXPECT_EQ(queries[1].outcome, (QueryOutcome{"not_in_map", ""}));
  EXPECT_EQ(queries[2].outcome, (QueryOutcome{"localized", "walk/1.jpg"}));
}

struct WrongField {
  std::string pointer;
  std::string value;
  std::string cause;
};

TEST_F(LoggedQueryTest, NamesLineAndFieldOfAValueOfAnotherType) {
  const std::vector<WrongField> wrong = {
      {"/id", "7", "the line's id must be a string, not number"},
      {"/map", "[]", "the line's map must be a string or null, not array"},
      {"/request", "3", "the request must be a JSON object"},
      {"/request/top_k", "\"3\"", "top_k must be an integer between 1 and 50"},
      {"/request/odometry", "[null, null]",
       "odometry has 2 motions for 1 images; give one motion or null per image"},
      {"/images", "{}", "the line's images must be a list, not object"},
      {"/images", "[]", "the line's images are none; expected one at least"},
      {"/images/0", "null", "images[0] must be an object, not null"},
      {"/images/0/file", "1.5", "images[0]'s file must be a string, not number"},
      {"/images/0/name", "{}", "images[0]'s name must be a string, not object"},
      {"/answer", "null", "the answer must be an object, not null"},
      {"/answer/verdict", "true", "the answer's verdict must be a string, not boolean"},
      {"/answer/keyframe", "\"1\"", "the answer's keyframe must be an object, not string"},
      {"/answer/keyframe/source", "1",
       "the answer's keyframe's source must be a string, not number"},
      {"/answer/panorama", "[1]", "the answer's panorama must be an object, not array"},
      {"/answer/panorama/node", "1", "the panorama's node must be an object, not number"},
      {"/answer/panorama/node/sequence", "[]",
       "the panorama's node's sequence must be a string, not array"},
      {"/answer/belief", "{}", "the answer's belief must be a list, not object"}};
  for (const WrongField& field : wrong) {
    EXPECT_EQ(ErrorOf(LineWith(field.pointer, field.value)),
              (folder_ / kQueryLogLines).string() + ", line 2 is not a logged query (" +
                  field.cause + "); remove the line")
        << field.pointer;
  }
  EXPECT_NE(ErrorOf("[]").find("(the line must be an object, not array)"), std::string::npos);
  EXPECT_NE(ErrorOf("{\"id\":\n").find("line 2 is not"), std::string::npos);
}

TEST_F(LoggedQueryTest, AnAnswerMayHaveManyValuesAndARequestMayNot) {
  std::string list = "[0";
  for (int i = 0; i < 30'000; ++i) list += ",0";
  EXPECT_EQ(Read(LineWith("/answer/planes", list + "]")).size(), 1U);
  try {
    ParseJson(R"({"images":)" + list + "]}");
    FAIL() << "parsed";
  } catch (const MapError& error) {
    EXPECT_EQ(error.code(), ErrorCode::kBadRequest);
    EXPECT_STREQ(error.what(), "the JSON has too many values");
  }
}

}  // namespace
}  // namespace waystone
