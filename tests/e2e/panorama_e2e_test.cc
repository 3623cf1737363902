// SPDX-License-Identifier: Apache-2.0
// The commands on panoramas as a user runs them.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include "api/json.h"
#include "cli/system/child_process.h"
#include "tests/e2e/panorama_walk.h"
#include "tests/e2e/shared_map.h"

// After Eigen, for which the macro _res of the resolver's header spells trouble.
#include <httplib.h>

namespace waystone {
namespace {

namespace fs = std::filesystem;

TEST_F(PanoramaCommands, CompassSaysHowPanoramasAreTurned) {
  const fs::path a = Write("a.png", 0.1);
  const fs::path b = Write("b.png", 0.6);
  const RunResult result = RunWaystone({"compass", a, b, a, "--json"});
  ASSERT_EQ(result.code, 0) << result.err;
  std::istringstream lines(result.out);
  std::string line;
  std::getline(lines, line);
  const Json json = Json::parse(line);
  EXPECT_NEAR(json["heading_deg"].get<double>(), 0.5 * 57.29578, 0.5);
  EXPECT_GT(json["deviation_deg"].get<double>(), 0);
  EXPECT_LT(json["deviation_deg"].get<double>(), 2);
  EXPECT_TRUE(json.contains("runner_up_deg"));
  std::getline(lines, line);
  EXPECT_NEAR(Json::parse(line)["heading_deg"].get<double>(), 0, 0.1);
  const RunResult text = RunWaystone({"compass", a, b});
  EXPECT_NE(text.out.find("+28."), std::string::npos) << text.out;
  EXPECT_NE(text.out.find("runner-up"), std::string::npos) << text.out;
}

TEST_F(PanoramaCommands, UnwrapWritesWhatIsUsed) {
  const fs::path a = Write("a.png", 0.1);
  const RunResult result = RunWaystone({"unwrap", a, "-o", folder_ / "out"});
  ASSERT_EQ(result.code, 0) << result.err;
  const cv::Mat drawn = cv::imread((folder_ / "out" / "a_used.png").string());
  EXPECT_EQ(drawn.size(), cv::Size(256, 128));
  EXPECT_FALSE(cv::imread((folder_ / "out" / "a_panorama.png").string()).empty());
}

TEST_F(PanoramaCommands, UnwrapOverwritesOnlyWithForce) {
  const fs::path a = Write("a.png", 0.1);
  for (const char* name : {"a_panorama.png", "a_used.png"}) {
    fs::remove_all(folder_ / "out");
    fs::create_directory(folder_ / "out");
    WriteFile(folder_ / "out" / name, "mine");
    const RunResult refused = RunWaystone({"unwrap", a, "-o", folder_ / "out"});
    EXPECT_EQ(refused.code, 3);
    EXPECT_NE(refused.err.find("--force"), std::string::npos) << refused.err;
    EXPECT_EQ(ReadFile(folder_ / "out" / name), "mine");
    EXPECT_EQ(std::distance(fs::directory_iterator(folder_ / "out"), {}), 1) << "written before";
    EXPECT_EQ(RunWaystone({"unwrap", a, "-o", folder_ / "out", "--force"}).code, 0);
    EXPECT_FALSE(cv::imread((folder_ / "out" / name).string()).empty());
  }
}

TEST_F(PanoramaCommands, OneLineSaysWhatIsWrong) {
  const fs::path a = Write("a.png", 0.1);
  const RunResult one = RunWaystone({"compass", a});
  EXPECT_EQ(one.code, 2);
  EXPECT_NE(one.err.find("needs at least 2"), std::string::npos) << one.err;
  cv::imwrite((folder_ / "black.png").string(), cv::Mat(128, 256, CV_8UC1, cv::Scalar(0)));
  const RunResult black = RunWaystone({"compass", a, folder_ / "black.png"});
  EXPECT_EQ(black.code, 3);
  EXPECT_NE(black.err.find("black.png"), std::string::npos) << black.err;
  EXPECT_NE(black.err.find("uncover the lens"), std::string::npos) << black.err;
  fs::create_directory(folder_ / "rig");
  const RunResult rig = RunWaystone({"unwrap", folder_ / "rig", "-o", folder_ / "out"});
  EXPECT_EQ(rig.code, 3);
  EXPECT_NE(rig.err.find("front"), std::string::npos) << rig.err;
}

TEST_F(PanoramaMap, BuildKeepsFeaturesWithin20KilobytesANode) {
  ASSERT_EQ(build_.code, 0) << build_.err;
  const RunResult bare = RunWaystone(
      {"build", home_ / "walk", "-o", folder_ / "bare.db", "--node-features", "0", "--quiet"});
  ASSERT_EQ(bare.code, 0) << bare.err;
  const auto with = fs::file_size(home_ / "hall.db");
  EXPECT_GT(with, fs::file_size(folder_ / "bare.db"));
  EXPECT_LT(with, kPanoramas * 20'000 + 250'000);  // and the empty tables and indices
}

TEST_F(PanoramaMap, AnAnswerHasItsPlace) {
  ASSERT_EQ(build_.code, 0) << build_.err;
  const RunResult run =
      RunWaystone({"localize", home_ / "hall.db", home_ / "walk/3.png", "--json"});
  const Json answer = Json::parse(run.out);
  ASSERT_EQ(answer["verdict"], "localized") << answer;
  const Json& place = answer["place"];
  EXPECT_EQ(place["layer"], "appearance");
  EXPECT_TRUE(place["image"].get<std::string>().ends_with("3.png")) << place;
  EXPECT_EQ(place["id"], answer["panorama"]["node"]["id"]);
  EXPECT_EQ(place["position"], answer["panorama"]["position"]);
  EXPECT_EQ(place["heading"], answer["heading"]);
  EXPECT_TRUE(place["position"]["x"].is_number());
}

TEST_F(PanoramaMap, LocalizeAnswersASeriesInOrder) {
  ASSERT_EQ(build_.code, 0) << build_.err;
  const RunResult series = RunWaystone(
      {"localize", home_ / "hall.db", Query(2), Query(3), Query(4), "--series", "--json"});
  ASSERT_EQ(series.code, 0) << series.err;
  std::istringstream lines(series.out);
  std::string line;
  int answers = 0;
  while (std::getline(lines, line)) {
    const Json answer = Json::parse(line);
    EXPECT_EQ(answer["decided_by"], "series");
    EXPECT_EQ(answer["image"], Query(2 + answers).string());
    ++answers;
  }
  EXPECT_EQ(answers, 3);
  EXPECT_EQ(Json::parse(series.out.substr(series.out.rfind("{\"verdict\"")))["verdict"],
            "localized");
}

TEST_F(PanoramaMap, AFieldOfViewSaysWhatAPhotoSees) {
  ASSERT_EQ(build_.code, 0) << build_.err;
  const fs::path photo = folder_ / "photo.png";
  DrawPhoto(photo, 3.5);
  const auto ask = [&](std::vector<std::string> more) {
    more.insert(more.begin(), {"localize", home_ / "hall.db", photo, "--json"});
    return RunWaystone(more);
  };
  const RunResult blind = ask({});
  ASSERT_EQ(blind.code, 0) << blind.err;
  EXPECT_NE(blind.out.find("field of view"), std::string::npos) << blind.out;
  const Json seen = Json::parse(ask({"--fov-deg", "80"}).out);
  ASSERT_EQ(seen["verdict"], "localized") << seen;
  // Two panoramas before or after it at most: 40 cm.
  EXPECT_NEAR(std::stod(seen["place"]["image"].get<std::string>()), 3.5, 2) << seen;
  EXPECT_EQ(ask({"--fov-deg", "200"}).code, 2);
  EXPECT_EQ(ask({"--fov-deg", "80", "--series"}).code, 2);
  ChildProcess server({WAYSTONE_PROGRAM, "serve", home_ / "hall.db", "--port", "0"}, true);
  const std::string line = server.ReadLine();
  const Json served = Json::parse(RunWaystone({"localize", "hall", photo, "--json", "--fov-deg",
                                               "80", "--server", line.substr(line.find("http://"))})
                                      .out);
  EXPECT_EQ(served["camera"]["source"], "fov") << served;
  EXPECT_EQ(served["place"], seen["place"]);
}

TEST_F(PanoramaMap, SeveralPanoramasOverHttpAreASeriesAndTheBeliefGoesOn) {
  ASSERT_EQ(build_.code, 0) << build_.err;
  ChildProcess server({WAYSTONE_PROGRAM, "serve", home_ / "hall.db", "--port", "0"}, true);
  const std::string line = server.ReadLine();
  httplib::Client client(line.substr(line.find("http://")));
  client.set_read_timeout(30);
  const auto ask = [&](const std::vector<int>& steps, const Json& request) {
    httplib::MultipartFormDataItems form;
    for (const int step : steps) {
      form.push_back({"image", ReadFile(Query(step)), std::to_string(step) + ".png", "image/png"});
    }
    form.push_back({"request", request.dump(), "", "application/json"});
    const auto result = client.Post("/v1/maps/hall/localize", form);
    EXPECT_TRUE(result);
    return result ? std::pair(result->status, Json::parse(result->body)) : std::pair(0, Json());
  };
  const auto [status, first] = ask({2, 3}, Json::object());
  ASSERT_EQ(status, 200) << first;
  EXPECT_EQ(first["decided_by"], "series");
  EXPECT_EQ(first["image"], "3.png");  // the last one's answer
  EXPECT_EQ(first["images"].size(), 2U);
  ASSERT_FALSE(first["belief"].empty()) << first;
  double sum = 0;
  for (const Json& belief : first["belief"]) sum += belief["probability"].get<double>();
  EXPECT_LE(sum, 1);

  Json request;
  request["previous"] = {{"belief", first["belief"]}, {"map_version", first["map_version"]}};
  request["odometry"] = {{{"x", 0.1}, {"y", 0}, {"heading_rad", 0.05}}};
  const Json next = ask({4}, request).second;
  EXPECT_EQ(next["decided_by"], "series");
  EXPECT_FALSE(next.contains("unused")) << next;
  EXPECT_EQ(next["verdict"], "localized") << next;
  EXPECT_FALSE(next["panorama"]["position"].is_null());

  request["previous"]["map_version"] = "sha256:another";
  EXPECT_EQ(ask({4}, request).second["unused"], Json({"previous", "odometry"}));
  request["previous"] = {
      {"belief",
       {{{"node", 999}, {"probability", 0.5}, {"heading_rad", 0}, {"deviation_rad", 0.1}}}}};
  const auto [refused, problem] = ask({4}, request);
  EXPECT_EQ(refused, 400);
  EXPECT_NE(problem["detail"].get<std::string>().find("999"), std::string::npos);
}

// What a series of these panoramas gives on the command line, one object an answer.
std::vector<Json> SeriesOnTheCommandLine(const fs::path& map, const std::vector<fs::path>& images) {
  std::vector<std::string> arguments = {"localize", map, "--series", "--json"};
  arguments.insert(arguments.end(), images.begin(), images.end());
  std::istringstream lines(RunWaystone(arguments).out);
  std::vector<Json> answers;
  for (std::string line; std::getline(lines, line);) answers.push_back(Json::parse(line));
  return answers;
}

// In either direction of travel, from the first image on.
TEST_F(PanoramaMap, ASeriesOfMappedPanoramasNamesThem) {
  ASSERT_EQ(build_.code, 0) << build_.err;
  std::vector<fs::path> images;
  for (int i = 2; i < 8; ++i) images.push_back(home_ / "walk" / (std::to_string(i) + ".png"));
  for (int direction = 0; direction < 2; ++direction) {
    const std::vector<Json> answers = SeriesOnTheCommandLine(home_ / "hall.db", images);
    ASSERT_EQ(answers.size(), images.size());
    for (size_t i = 0; i < images.size(); ++i) {
      EXPECT_EQ(answers[i]["decided_by"], "series");
      EXPECT_EQ(answers[i]["verdict"], "localized") << answers[i];
      EXPECT_EQ(answers[i]["place"]["image"], images[i].filename().string()) << answers[i];
      EXPECT_EQ(answers[i]["place"]["id"], answers[i]["panorama"]["node"]["id"]);
    }
    std::ranges::reverse(images);
  }
}

TEST_F(PanoramaMap, TheCommandLineAndTheServerAnswerASeriesAlike) {
  ASSERT_EQ(build_.code, 0) << build_.err;
  const std::vector<fs::path> images = {Query(2), Query(3), Query(4)};
  const std::vector<Json> local = SeriesOnTheCommandLine(home_ / "hall.db", images);
  ASSERT_EQ(local.size(), images.size());
  ChildProcess server({WAYSTONE_PROGRAM, "serve", home_ / "hall.db", "--port", "0"}, true);
  const std::string line = server.ReadLine();
  httplib::Client client(line.substr(line.find("http://")));
  client.set_read_timeout(30);
  httplib::MultipartFormDataItems form;
  for (size_t i = 0; i < images.size(); ++i) {
    form.push_back({"image", ReadFile(images[i]), images[i].string(), "image/png"});
    const auto result = client.Post("/v1/maps/hall/localize", form);
    ASSERT_TRUE(result);
    const Json served = Json::parse(result->body);
    if (i == 0) continue;  // a panorama alone is no series
    for (const auto& [key, value] : local[i].items()) {
      if (key == "timing_ms") continue;
      EXPECT_EQ(served.value(key, Json()), value) << i << ": " << key;
    }
    EXPECT_EQ(served.contains("building"), local[i].contains("building"));
  }
  EXPECT_EQ(local.back()["verdict"], "localized");
}

// An image that can't be used is answered so and leaves the series as it was.
TEST_F(PanoramaMap, ASeriesPassesOverWhatIsNoImage) {
  ASSERT_EQ(build_.code, 0) << build_.err;
  const fs::path broken = folder_ / "broken.png";
  WriteFile(broken, "no image");
  const fs::path map = home_ / "hall.db";
  const std::vector<Json> plain = SeriesOnTheCommandLine(map, {Query(2), Query(3)});
  const std::vector<Json> with = SeriesOnTheCommandLine(map, {Query(2), broken, Query(3)});
  ASSERT_EQ(plain.size(), 2u);
  ASSERT_EQ(with.size(), 3u);
  EXPECT_EQ(with[1]["verdict"], "bad_image");
  EXPECT_EQ(with[2]["probability"], plain[1]["probability"]);
  EXPECT_EQ(with[2]["panorama"], plain[1]["panorama"]);
  const RunResult run = RunWaystone({"localize", map, Query(2), broken, "--series"});
  EXPECT_EQ(run.code, 3);
}

// The log's own map, and one that names the same panoramas otherwise: the belief is of the map that
// is asked, so the series goes on with either.
TEST_F(PanoramaMap, AReplayedSeriesGoesOn) {
  ASSERT_EQ(build_.code, 0) << build_.err;
  {
    ChildProcess server({WAYSTONE_PROGRAM, "serve", home_ / "hall.db", "--port", "0", "--query-log",
                         folder_ / "log"},
                        true);
    const std::string line = server.ReadLine();
    httplib::Client client(line.substr(line.find("http://")));
    client.set_read_timeout(30);
    Json request = Json::object();
    for (const int step : {2, 3, 4}) {
      const httplib::MultipartFormDataItems form = {
          {"image", ReadFile(Query(step)), std::to_string(step) + ".png", "image/png"},
          {"request", request.dump(), "", "application/json"}};
      const auto result = client.Post("/v1/maps/hall/localize", form);
      ASSERT_TRUE(result);
      const Json answer = Json::parse(result->body);
      ASSERT_TRUE(answer.contains("belief")) << answer;
      request["previous"] = {{"belief", answer["belief"]}, {"map_version", answer["map_version"]}};
    }
  }
  const RunResult same = RunWaystone({"replay", folder_ / "log", home_ / "hall.db"});
  EXPECT_EQ(same.out, "0 of 3 answers changed\n") << same.err;
  // Without its first panoramas the walk's nodes have other ids.
  fs::create_directory(folder_ / "walk");
  for (int i = 1; i < kPanoramas; ++i) {
    const std::string name = std::to_string(i) + ".png";
    fs::copy_file(home_ / "walk" / name, folder_ / "walk" / name);
  }
  const RunResult built =
      RunWaystone({"build", folder_ / "walk", "-o", folder_ / "other.db", "--quiet"});
  ASSERT_EQ(built.code, 0) << built.err;
  const RunResult other = RunWaystone({"replay", folder_ / "log", folder_ / "other.db"});
  EXPECT_EQ(other.code, 0) << other.err;
  EXPECT_NE(other.out.find("of 3 answers changed"), std::string::npos) << other.out;
}

}  // namespace
}  // namespace waystone
