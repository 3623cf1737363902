// SPDX-License-Identifier: Apache-2.0
// The program's parts that need no process of their own.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <opencv2/core.hpp>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include "api/audit_text.h"
#include "cli/files/csv_file.h"
#include "cli/files/map_file.h"
#include "cli/files/trajectory_file.h"
#include "cli/output/answer_text.h"
#include "cli/output/build_text.h"
#include "cli/output/eval_text.h"
#include "cli/output/printable_output.h"
#include "cli/output/progress.h"
#include "cli/output/trajectory_plot.h"
#include "cli/program.h"
#include "core/base/error.h"

namespace waystone {
namespace {

// Commands run what they do in parallel themselves, each part in one thread.
TEST(Program, ImagesAreComputedInOneThread) {
  cv::setNumThreads(2);
  std::string name = "waystone";
  std::string flag = "--version";
  char* arguments[] = {name.data(), flag.data(), nullptr};
  testing::internal::CaptureStdout();
  EXPECT_EQ(RunProgram(2, arguments), 0);
  testing::internal::GetCapturedStdout();
  EXPECT_EQ(cv::getNumThreads(), 1);
}

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

TEST(PrintableOutput, ShowsControlCharactersAndLeavesTheRest) {
  std::ostringstream out;
  {
    const PrintableOutput printable(out);
    out << "a\tb\n\x1b[2J\r\x7f" << '\x07' << "Gar\u00e7on \u4f4d" << std::flush;
    out << '\xC2' << std::flush << '\x9B' << "31m";  // CSI, in two pieces
    out << "\u00a9";                                 // begins with C2 as well
    out << '\xE2' << std::flush << "\x80" << std::flush << "\xAE"
        << "cod.exe \u2026";
  }
  out << "\x1b";
  EXPECT_EQ(out.str(),
            "a\tb\n\\u001b[2J\\u000d\\u007f\\u0007Gar\u00e7on \u4f4d\\u009b31m\u00a9\\u202ecod.exe "
            "\u2026\x1b");
}

// As the lines of a server's log, which all its threads write.
TEST(PrintableOutput, KeepsTheLinesOfThreadsWhole) {
  constexpr int kThreads = 4;
  constexpr int kLines = 5000;
  std::stringbuf written;
  {
    PrintableBuffer printable(written);
    std::vector<std::thread> threads;
    for (int i = 0; i < kThreads; ++i) {
      threads.emplace_back([&printable, i] {
        const std::string line = std::string(20 + 10 * i, static_cast<char>('a' + i)) + "\x1b\n";
        for (int k = 0; k < kLines; ++k) {
          printable.sputn(line.data(), std::ssize(line));
          printable.pubsync();
        }
      });
    }
    for (std::thread& thread : threads) thread.join();
  }
  std::map<std::string, int> lines;
  std::istringstream in(written.str());
  for (std::string line; std::getline(in, line);) ++lines[line];
  ASSERT_EQ(lines.size(), static_cast<size_t>(kThreads));
  for (const auto& [line, count] : lines) EXPECT_EQ(count, kLines) << line;
}

TEST(SummaryText, CountsUsedAndSkippedFramesOfAll) {
  BuildResult result;
  result.report.planes.emplace();
  result.report.planes->frames = 5;
  result.report.planes->skipped = 2;
  result.report.planes->skipped_names = {"a.jpg: truncated", "b.jpg: empty"};
  const std::string text =
      SummaryText({.path = "m.db", .version = "1", .tables = {}, .result = &result});
  EXPECT_NE(text.find("3 of 5 used, 2 skipped"), std::string::npos) << text;
  EXPECT_NE(text.find("a.jpg: truncated"), std::string::npos) << text;
}

TEST(AnswerLine, SaysWhereInOneLine) {
  EXPECT_EQ(AnswerLine(Json::parse(R"({"image":"q.jpg","verdict":"localized","planes":
      [{"id":3,"inliers":143}],"place":{"image":"rgb/1.jpg","position":null},"timing_ms":{"total":69.4}})")),
            "q.jpg: localized near rgb/1.jpg (plane 3, 143 inliers, 69 ms)");
  EXPECT_EQ(AnswerLine(Json::parse(R"({"image":"p","verdict":"localized","planes":[],
      "place":{"image":"7.jpg","position":{"x":1.2,"y":-3.45},"heading":{"rad":0.5}},"timing_ms":{"total":12}})")),
            "p: localized near 7.jpg at (1.20, -3.45), heading 29 deg (12 ms)");
  EXPECT_EQ(AnswerLine(Json::parse(R"({"image":"q","verdict":"not_in_map","message":"go on",
      "timing_ms":{"total":5}})")),
            "q: not_in_map: go on (5 ms)");
  // Of a server that is not of our version, or not ours.
  EXPECT_EQ(AnswerLine(Json::parse(R"({"verdict":"localized","planes":[1],
      "place":{"position":[]},"timing_ms":"soon"})")),
            ": localized (plane 0, 0 inliers, 0 ms)");
  EXPECT_EQ(AnswerLine(Json::parse("[1]")), ":  (0 ms)");
  EXPECT_EQ(AnswerLine(Json::parse(R"({"verdict":"localized","pose":{"position":["x",1,2]}})")),
            ": localized (0 ms)");
}

TEST(AnswerLine, SaysWhichMapsWereNotSearched) {
  const auto line = [](const std::string& searched, const std::string& partial) {
    return AnswerLine(Json::parse(R"({"image":"q","verdict":"not_in_map","timing_ms":{"total":5},
        "searched":)" + searched + R"(,"partial":)" +
                                  partial + "}"));
  };
  const std::string hall = R"({"map":"hall","state":"too_large","score":2})";
  const std::string lab = R"({"map":"lab","state":"failed","score":1,"message":"damaged"})";
  const std::string room = R"({"map":"room","state":"asked","score":9})";
  EXPECT_EQ(line("[" + room + "," + hall + "," + lab + "]", "true"),
            "q: not_in_map (5 ms) (2 of 3 maps weren't searched: hall too_large, lab failed)");
  EXPECT_EQ(line("[" + room + "," + hall + "]", "true"),
            "q: not_in_map (5 ms) (1 of 2 maps wasn't searched: hall too_large)");
  EXPECT_EQ(line("[" + room + "]", "false"), "q: not_in_map (5 ms)");
  EXPECT_EQ(line("[]", "true"), "q: not_in_map (5 ms) (no map was searched)");
  std::string many = lab;
  for (int i = 0; i < 6; ++i) many += "," + lab;
  EXPECT_NE(line("[" + many + "]", "true").find("(7 of 7 maps weren't searched: lab failed, "),
            std::string::npos);
  EXPECT_TRUE(line("[" + many + "]", "true").ends_with(", lab failed, ...)"));
  // Of a server that is not of our version, or not ours.
  EXPECT_EQ(line("7", "true"), "q: not_in_map (5 ms)");
  EXPECT_EQ(line("[1,{}]", "true"), "q: not_in_map (5 ms)");
}

TEST(MapNameOf, IsTheFilesNameAlone) {
  EXPECT_EQ(MapNameOf("/maps/lab.db"), "lab");
  EXPECT_EQ(MapNameOf("lab.v2.db"), "lab.v2");
  EXPECT_EQ(MapNameOf("lab"), "lab");
}

class CsvTest : public testing::Test {
 protected:
  ~CsvTest() override { std::filesystem::remove(path_); }
  CsvFile Read(const std::string& text) const {
    std::ofstream(path_, std::ios::binary) << text;
    return CsvFile(path_);
  }

  const std::filesystem::path path_ =
      std::filesystem::path(testing::TempDir()) /
      (std::string("waystone_") + testing::UnitTest::GetInstance()->current_test_info()->name() +
       ".csv");
};

TEST_F(CsvTest, CellsByTheirColumn) {
  const CsvFile file = Read("# about\n image , x\r\n\na b.jpg, -1.5e1\r\n,\n");
  ASSERT_EQ(file.rows().size(), 2u);
  EXPECT_EQ(file.Column("image"), 0u);
  EXPECT_EQ(file.Column("z"), std::nullopt);
  EXPECT_EQ(file.rows()[0].line, 4);
  EXPECT_EQ(file.rows()[0].cells[0], "a b.jpg");
  EXPECT_EQ(file.Number(file.rows()[0], 1), -15);
  EXPECT_EQ(file.rows()[1].cells, (std::vector<std::string>{"", ""}));
  EXPECT_THROW(file.Number(file.rows()[1], 1), MapError);
}

TEST_F(CsvTest, NumbersAreAllOfTheCell) {
  const CsvFile file = Read("x,y,z,v\n1m,nan,inf,0x1\n");
  for (size_t column = 0; column < 4; ++column) {
    EXPECT_THROW(file.Number(file.rows()[0], column), MapError) << column;
  }
}

TEST_F(CsvTest, LinesOfAnotherLengthAreNamed) {
  try {
    Read("a,b\n1,2\n1,2,3\n");
    FAIL();
  } catch (const MapError& error) {
    EXPECT_NE(std::string(error.what()).find("line 3: 3 fields"), std::string::npos)
        << error.what();
  }
}

TEST_F(CsvTest, AByteOrderMarkIsNoPartOfTheHeader) {
  EXPECT_EQ(Read("\xef\xbb\xbfimage,x\na,1\n").Column("image"), 0u);
  const CsvFile comment = Read("\xef\xbb\xbf# about\nimage,x\na,1\n");
  EXPECT_EQ(comment.Column("image"), 0u);
  EXPECT_EQ(comment.rows()[0].line, 3);
  EXPECT_EQ(Read("x\n1\n").rows().size(), 1u);  // shorter than a mark and its text
  EXPECT_EQ(Read("x").Column("x"), 0u);
}

TEST_F(CsvTest, TwoColumnsOfOneNameAreRefused) {
  try {
    Read("# about\na,b, a\n1,2,3\n");
    FAIL();
  } catch (const MapError& error) {
    EXPECT_NE(std::string(error.what()).find("line 2: the header has two columns \"a\""),
              std::string::npos)
        << error.what();
  }
  EXPECT_EQ(Read("a,,\n1,2,3\n").Column("a"), 0u);  // nobody asks for columns without a name
}

TEST(EvaluationText, SaysWhatIsEmpty) {
  const auto index = MapIndex::Build({});
  const Evaluation evaluation = Evaluate(*index, {});
  const Json json = EvaluationJson(evaluation);
  EXPECT_TRUE(json["threshold"].is_null());
  EXPECT_TRUE(json["position_m"].is_null());
  for (const char* share : {"recall", "precision", "recall_at_full_precision"}) {
    EXPECT_TRUE(json[share].is_null()) << share;
  }
  EXPECT_NE(EvaluationText(evaluation).find("  precision                    -\n"),
            std::string::npos)
      << EvaluationText(evaluation);
  EXPECT_TRUE(json["reliability"][9]["stated"].is_null());
  EXPECT_EQ(json["latency_ms"]["total"]["p99"], 0.0);
  EXPECT_NE(EvaluationText(evaluation).find("0 queries"), std::string::npos);
  EXPECT_EQ(MistakesText(*index, {}), "");
}

TEST(EvaluationText, AnglesOfUnknownOrientationsAreNone) {
  Evaluation evaluation = Evaluate(*MapIndex::Build({}), {});
  evaluation.position.emplace();
  evaluation.within = {{0.25, 2, 0.5, std::nullopt}, {5, 10, 1, 0.75}};
  const Json within = EvaluationJson(evaluation)["within"];
  EXPECT_TRUE(within[0]["pose"].is_null()) << within;
  EXPECT_EQ(within[1]["pose"], 0.75);
  const std::string text = EvaluationText(evaluation);
  EXPECT_NE(text.find("0.25 m   50.0%, and    2 degrees       -\n"), std::string::npos) << text;
  EXPECT_NE(text.find("5.00 m  100.0%, and   10 degrees   75.0%\n"), std::string::npos) << text;
}

TEST(AuditText, FindingsComeWithAdvice) {
  MapData map;
  map.sequences.push_back({SequenceId{1}, "hall", "folder", 9, 0, std::nullopt});
  Keyframe keyframe;
  keyframe.id = KeyframeId{1};
  keyframe.sequence = SequenceId{1};
  keyframe.source = "7.jpg";
  map.keyframes.push_back(keyframe);
  const auto index = MapIndex::Build(map);
  AuditReport report;
  report.weak.push_back({KeyframeId{1}, KeyframeId{1}, 1});
  const std::string text = AuditText(*index, report);
  EXPECT_NE(text.find("0 pairs of perceptually aliased places"), std::string::npos) << text;
  EXPECT_NE(text.find("1 run of weak keyframes"), std::string::npos) << text;
  EXPECT_NE(text.find("7.jpg: no plane in view (1 keyframe)\n    record this place again"),
            std::string::npos)
      << text;
  const Json json = AuditJson(*index, report);
  map.keyframes[0].source = "7\n8.jpg";
  const std::string escaped = AuditText(*MapIndex::Build(map), report);
  EXPECT_NE(escaped.find("7\\u000a8.jpg: no plane"), std::string::npos) << escaped;
  EXPECT_EQ(json["weak"][0]["weakness"], "no_plane");
  EXPECT_EQ(json["weak"][0]["first"]["sequence"], "hall");
  EXPECT_TRUE(json["aliases"].empty());
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
  EXPECT_THROW(ProgressStyleByName("fancy", true), MapError);
}

class TrajectoryTest : public testing::Test {
 protected:
  ~TrajectoryTest() override {
    std::filesystem::remove(Path(".csv"));
    std::filesystem::remove(Path(".txt"));
  }
  std::filesystem::path Path(const std::string& extension) const {
    return std::filesystem::path(testing::TempDir()) /
           (std::string("waystone_way_") +
            testing::UnitTest::GetInstance()->current_test_info()->name() + extension);
  }
  Trajectory Read(const std::string& extension, const std::string& text) const {
    std::ofstream(Path(extension), std::ios::binary) << text;
    return ReadTrajectory(Path(extension));
  }
  // What reading says is wrong.
  std::string Refusal(const std::string& extension, const std::string& text) const {
    try {
      Read(extension, text);
    } catch (const MapError& error) {
      return error.what();
    }
    return "";
  }
};

TEST_F(TrajectoryTest, ReadsCsvByItsColumns) {
  const Trajectory plain = Read(".csv", "y,x\n2,1\n4,3\n");
  EXPECT_EQ(plain.poses, (std::vector<Pose2>{{1, 2, 0}, {3, 4, 0}}));
  EXPECT_TRUE(plain.times_s.empty());
  EXPECT_FALSE(plain.has_headings);
  const Trajectory full = Read(".csv", "time_s,x,y,theta_rad\n0.5,1,2,7\n1,3,4,0\n");
  EXPECT_EQ(full.times_s, (std::vector<double>{0.5, 1}));
  EXPECT_TRUE(full.has_headings);
  EXPECT_NEAR(full.poses[0].theta_rad, 7 - 2 * 3.14159265, 1e-6);
}

// A camera that looks along x: its z axis is the world's x, its y axis points down.
TEST_F(TrajectoryTest, ReadsTum) {
  const Trajectory trajectory = Read(".txt", "# time x y z q\n10.5 1 2 3 -0.5 0.5 -0.5 0.5\n\n");
  ASSERT_EQ(trajectory.poses.size(), 1u);
  EXPECT_EQ(trajectory.times_s[0], 10.5);
  EXPECT_EQ(trajectory.poses[0].y, 2);
  EXPECT_NEAR(trajectory.poses[0].theta_rad, 0, 1e-12);
}

TEST_F(TrajectoryTest, SaysWhichLineIsWrong) {
  EXPECT_NE(Refusal(".csv", "a,b\n1,2\n").find("x and y"), std::string::npos);
  EXPECT_NE(Refusal(".csv", "x,y,time_s\n1,2,5\n1,2,5\n").find("line 3"), std::string::npos);
  for (const char* line : {"1 2 3", "1 2 3 4 0 0 0 1 9", "1 2 3 4 0 0 0 nan", "1 2 3 4 0 0 0 1m"}) {
    EXPECT_NE(Refusal(".txt", line).find("line 1: expected eight numbers"), std::string::npos)
        << line;
  }
  EXPECT_THROW(ReadTrajectory("no such file.txt"), MapError);
}

TEST(PlotTrajectories, ShowsEveryLineAndEscapesLabels) {
  const std::string svg = PlotTrajectories(
      "a & b", {{"<truth>", "#222", {{0, 0}, {4, 0}}}, {"estimate", "#00f", {{0, 1}, {4, 2}}}});
  EXPECT_EQ(svg.find("<svg"), 0u);
  EXPECT_NE(svg.find("a &amp; b"), std::string::npos);
  EXPECT_NE(svg.find("&lt;truth&gt;"), std::string::npos);
  size_t lines = 0;
  for (size_t at = 0; (at = svg.find("<polyline", at)) != std::string::npos; ++at) ++lines;
  EXPECT_EQ(lines, 2u);
  // One place alone still has a picture.
  EXPECT_EQ(PlotTrajectories("", {{"", "red", {{3, 3}}}}).find("nan"), std::string::npos);
}

}  // namespace
}  // namespace waystone
