// SPDX-License-Identifier: Apache-2.0
// `waystone eval` on panoramas.
#include <gtest/gtest.h>

#include <filesystem>
#include <sstream>
#include <string>
#include <vector>

#include "api/json.h"
#include "tests/e2e/panorama_walk.h"
#include "tests/e2e/shared_map.h"

namespace waystone {
namespace {

// The walk's own panoramas, whose poses are known in each format.
class PanoramaEval : public PanoramaMap {
 protected:
  static Eigen::Isometry3d PoseAt(int step) {
    return WorldFromCamera({5.6 + 0.2 * step, 10.5, 1.5}, 0.05 * step);
  }

  static std::string Numbers(const std::vector<double>& numbers, const char* apart) {
    std::ostringstream text;
    text.precision(12);
    for (size_t i = 0; i < numbers.size(); ++i) text << (i == 0 ? "" : apart) << numbers[i];
    return text.str();
  }

  static std::string Line(const std::string& format, int step) {
    const Eigen::Isometry3d pose = PoseAt(step);
    const Eigen::Vector3d& p = pose.translation();
    const Eigen::Quaterniond q(pose.linear());
    const std::string number = std::to_string(step);
    if (format == "tum") {
      return Numbers({1.0 * step, p.x(), p.y(), p.z(), q.x(), q.y(), q.z(), q.w()}, " ");
    }
    if (format == "csv") {
      return number + ".png," + Numbers({p.x(), p.y(), p.z(), q.x(), q.y(), q.z(), q.w()}, ",");
    }
    if (format == "kitti") {
      std::vector<double> rows;
      for (int i = 0; i < 12; ++i) rows.push_back(pose.matrix()(i / 4, i % 4));
      return Numbers(rows, " ");
    }
    const Eigen::Isometry3d inverse = pose.inverse();
    const Eigen::Vector3d& t = inverse.translation();
    const Eigen::Quaterniond r(inverse.linear());
    return number + " " + Numbers({r.w(), r.x(), r.y(), r.z(), t.x(), t.y(), t.z()}, " ") + " 1 " +
           number + ".png\n";  // and no points
  }

  fs::path WritePoses(const std::string& format) const {
    std::string text = format == "csv" ? "image,x,y,z,qx,qy,qz,qw\n" : "";
    for (int i = 0; i < kPanoramas; ++i) text += Line(format, i) + "\n";
    fs::path path = folder_ / ("poses." + (format == "csv" ? format : "txt"));
    WriteFile(path, text);
    return path;
  }
};

TEST_F(PanoramaEval, TakesTruthInEveryFormat) {
  ASSERT_EQ(build_.code, 0) << build_.err;
  for (const char* format : {"csv", "tum", "kitti", "colmap"}) {
    const RunResult run = RunWaystone({"eval", home_ / "hall.db", home_ / "walk", "--truth",
                                       WritePoses(format), "--json", "--quiet"});
    ASSERT_EQ(run.code, 0) << format << run.err;
    const Json json = Json::parse(run.out);
    EXPECT_EQ(json["positives"], kPanoramas) << format;
    EXPECT_EQ(json["right"], kPanoramas) << format << run.out;
    ASSERT_EQ(json["within"].size(), 4u) << format;
    EXPECT_EQ(json["within"][1]["metres"], 0.25);
    EXPECT_EQ(json["within"][1]["pose"], 1.0) << format << json["within"];
    EXPECT_LT(json["position_m"]["max"].get<double>(), 0.1) << format;
  }
  const RunResult text = RunWaystone(
      {"eval", home_ / "hall.db", home_ / "walk", "--truth", WritePoses("tum"), "--quiet"});
  EXPECT_NE(text.out.find("0.25 m"), std::string::npos) << text.out;
}

TEST_F(PanoramaEval, LabelsNamePanoramasAndFalseAnswersAreListed) {
  ASSERT_EQ(build_.code, 0) << build_.err;
  WriteFile(folder_ / "queries.csv", "image,keyframe\n" + (home_ / "walk/3.png").string() +
                                         ",3.png\n" + (home_ / "walk/5.png").string() + ",\n");
  const RunResult run =
      RunWaystone({"eval", home_ / "hall.db", folder_ / "queries.csv", "--json", "--quiet"});
  ASSERT_EQ(run.code, 0) << run.err;
  const Json json = Json::parse(run.out);
  EXPECT_EQ(json["right"], 1) << run.out;
  EXPECT_EQ(json["false_accepts"], 1) << run.out;
  EXPECT_EQ(json["failures"][0]["best"], "5.png");
  const RunResult bare = RunWaystone({"eval", home_ / "hall.db", home_ / "walk"});
  EXPECT_EQ(bare.code, 2);
  EXPECT_NE(bare.err.find("--truth"), std::string::npos) << bare.err;
}

}  // namespace
}  // namespace waystone
