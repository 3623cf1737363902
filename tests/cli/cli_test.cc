// SPDX-License-Identifier: Apache-2.0
// The program's parts that need no process of their own.
#include <gtest/gtest.h>

#include <algorithm>
#include <sstream>
#include <string>

#include "cli/build_text.h"
#include "cli/map_file.h"
#include "cli/progress.h"
#include "core/base/error.h"

namespace waystone {
namespace {

TEST(Duration, ReadsAsPeopleSayIt) {
  EXPECT_EQ(Duration(0.4), "0 s");
  EXPECT_EQ(Duration(59.4), "59 s");
  EXPECT_EQ(Duration(200), "3 min 20 s");
  EXPECT_EQ(Duration(7500), "2 h 5 min");
  EXPECT_EQ(Duration(-1), "0 s");
}

TEST(BytesText, ReadsAsPeopleSayIt) {
  EXPECT_EQ(BytesText(0), "0 B");
  EXPECT_EQ(BytesText(999), "999 B");
  EXPECT_EQ(BytesText(1'900'000), "1.9 MB");
  EXPECT_EQ(BytesText(12'300'000'000'000), "12300.0 GB");
}

TEST(MapNameOf, IsTheFilesNameAlone) {
  EXPECT_EQ(MapNameOf("/maps/lab.db"), "lab");
  EXPECT_EQ(MapNameOf("lab.v2.db"), "lab.v2");
  EXPECT_EQ(MapNameOf("lab"), "lab");
}

class ProgressTest : public testing::Test {
 protected:
  // Shows `steps` steps of 10 s each of a work of 10 steps.
  std::string Show(ProgressStyle style, int steps, bool colour = false) {
    std::ostringstream out;
    double now_s = 100;
    ProgressMeter meter(out, style, colour, [&now_s] { return now_s; });
    meter.Update({"frames", 0, 10, "1 keyframes"});
    for (int i = 1; i <= steps; ++i) {
      now_s += 10;
      meter.Update({"frames", i, 10, "1 keyframes"});
    }
    meter.Finish();
    return out.str();
  }
};

TEST_F(ProgressTest, LinesSayHowLongItTakes) {
  EXPECT_EQ(Show(ProgressStyle::kLines, 2),
            "1/10 frames, 1 keyframes, 1 min 30 s left\n"
            "2/10 frames, 1 keyframes, 1 min 20 s left\n");
}

TEST_F(ProgressTest, LinesHaveNoEscapes) {
  EXPECT_EQ(Show(ProgressStyle::kLines, 9).find('\x1b'), std::string::npos);
  EXPECT_EQ(Show(ProgressStyle::kLines, 9).find('\r'), std::string::npos);
}

TEST_F(ProgressTest, BarIsDrawnOverItselfAndClearedAtTheEnd) {
  const std::string text = Show(ProgressStyle::kBar, 5);
  EXPECT_NE(text.find("[############............]"), std::string::npos) << text;
  EXPECT_TRUE(text.ends_with("\r\x1b[K")) << text;
  EXPECT_EQ(text.find('\n'), std::string::npos);
  EXPECT_EQ(text.find("\x1b[36m"), std::string::npos);
  EXPECT_NE(Show(ProgressStyle::kBar, 5, true).find("\x1b[36m"), std::string::npos);
}

TEST_F(ProgressTest, JsonIsAnObjectALine) {
  std::istringstream lines(Show(ProgressStyle::kJson, 3));
  int count = 0;
  for (std::string line; std::getline(lines, line); ++count) {
    EXPECT_EQ(Json::parse(line)["total"], 10) << line;
  }
  EXPECT_EQ(count, 3);
}

TEST_F(ProgressTest, NoneIsSilent) { EXPECT_EQ(Show(ProgressStyle::kNone, 10), ""); }

TEST_F(ProgressTest, UnknownTotalShowsNoTimeLeft) {
  std::ostringstream out;
  double now_s = 0;
  ProgressMeter meter(out, ProgressStyle::kLines, false, [&now_s] { return now_s; });
  now_s = 60;
  meter.Update({"frames", 7, 0, ""});
  EXPECT_EQ(out.str(), "7 frames\n");
}

TEST_F(ProgressTest, OftenCalledIsSeldomDrawn) {
  std::ostringstream out;
  double now_s = 0;
  ProgressMeter meter(out, ProgressStyle::kLines, false, [&now_s] { return now_s; });
  for (int i = 0; i < 1000; ++i) {
    now_s += 0.01;
    meter.Update({"frames", i, 1000, ""});
  }
  const std::string text = out.str();
  EXPECT_LE(std::count(text.begin(), text.end(), '\n'), 2);
}

TEST(ProgressStyle, OnlyKnownNames) {
  EXPECT_EQ(ProgressStyleByName("none", false), ProgressStyle::kNone);
  EXPECT_EQ(ProgressStyleByName("auto", true), ProgressStyle::kNone);
  EXPECT_EQ(ProgressStyleByName("json", true), ProgressStyle::kJson);
  EXPECT_THROW(ProgressStyleByName("fancy", false), MapError);
}

}  // namespace
}  // namespace waystone
