// SPDX-License-Identifier: Apache-2.0
// Panoramas with poses, as a user builds, asks, exports and evaluates them.
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <sstream>
#include <string>

#include "api/json.h"
#include "tests/e2e/panorama_walk.h"

namespace waystone {
namespace {

// The walk of PanoramaMap with its poses, in a frame of which z is up.
class PosedPanoramaMap : public PanoramaMap {
 protected:
  static constexpr double kStep_m = 0.2;

  static Eigen::Isometry3d PoseAt(double step) {
    return WorldFromCamera({5.6 + kStep_m * step, 10.5, 1.5}, 0.05 * step);
  }

  static std::string PoseLine(const std::string& name, double step) {
    const Eigen::Isometry3d pose = PoseAt(step);
    const Eigen::Quaterniond q(pose.linear());
    const Eigen::Vector3d at = pose.translation();
    std::ostringstream line;
    line.precision(12);
    line << name << ',' << at.x() << ',' << at.y() << ',' << at.z() << ',' << q.w() << ',' << q.x()
         << ',' << q.y() << ',' << q.z() << '\n';
    return line.str();
  }

  static fs::path WritePoses(const std::string& file, int count) {
    std::ofstream out(home_ / file);
    out << "image,x,y,z,qw,qx,qy,qz\n";
    for (int i = 0; i < count; ++i) out << PoseLine(std::to_string(i) + ".png", i);
    return home_ / file;
  }

  static RunResult BuildPosed(const fs::path& poses, const fs::path& map) {
    return RunWaystone({"build", home_ / "walk", "-o", map, "--poses", poses, "--frame", "hall",
                        "--unit", "metres", "--force", "--json"});
  }
};

TEST_F(PosedPanoramaMap, IsBuiltAskedExportedAndEvaluated) {
  const fs::path map = folder_ / "posed.db";
  const RunResult built = BuildPosed(WritePoses("poses.csv", kPanoramas), map);
  ASSERT_EQ(built.code, 0) << built.err;
  const Json summary = Json::parse(built.out);
  EXPECT_EQ(summary["node_poses"]["posed"], kPanoramas);
  EXPECT_EQ(RunWaystone({"check", map}).code, 0);
  EXPECT_NE(RunWaystone({"info", map}).out.find("poses"), std::string::npos);

  const RunResult asked = RunWaystone({"localize", map, Query(3), "--json"});
  ASSERT_EQ(asked.code, 0) << asked.err;
  const Json answer = Json::parse(asked.out);
  ASSERT_EQ(answer["verdict"], "localized") << asked.out;
  ASSERT_TRUE(answer["pose"].is_object()) << asked.out;
  const Json& pose = answer["pose"];
  EXPECT_EQ(pose["frame"], "hall");
  EXPECT_EQ(pose["unit"], "metres");
  EXPECT_EQ(pose["camera"], "query");
  ASSERT_EQ(pose["covariance"].size(), 6u);
  const Eigen::Vector3d at(pose["position"][0], pose["position"][1], pose["position"][2]);
  EXPECT_LT((at - PoseAt(3.5).translation()).norm(), 0.15);
  const Eigen::Quaterniond q(
      pose["orientation"][3].get<double>(), pose["orientation"][0].get<double>(),
      pose["orientation"][1].get<double>(), pose["orientation"][2].get<double>());
  EXPECT_LT(q.angularDistance(Eigen::Quaterniond(PoseAt(3.5).linear())), 0.05);
  EXPECT_EQ(answer["place"]["position"]["metres_per_unit"], 1.0);
  EXPECT_NE(RunWaystone({"localize", map, Query(3)}).out.find(" m in hall"), std::string::npos);

  // What goes in comes out.
  const RunResult tum = RunWaystone({"export", map, "--format", "tum"});
  ASSERT_EQ(tum.code, 0) << tum.err;
  std::istringstream lines(tum.out);
  std::string line;
  int count = 0;
  while (std::getline(lines, line)) {
    if (line.starts_with('#')) continue;
    std::istringstream fields(line);
    double frame = 0, x = 0, y = 0, z = 0, qx = 0, qy = 0, qz = 0, qw = 0;
    ASSERT_TRUE(fields >> frame >> x >> y >> z >> qx >> qy >> qz >> qw) << line;
    const Eigen::Isometry3d given = PoseAt(count++);
    EXPECT_LT((Eigen::Vector3d(x, y, z) - given.translation()).norm(), 1e-5);
    EXPECT_LT(
        Eigen::Quaterniond(qw, qx, qy, qz).angularDistance(Eigen::Quaterniond(given.linear())),
        1e-5);
  }
  EXPECT_EQ(count, kPanoramas);
  const Json geojson = Json::parse(RunWaystone({"export", map, "--format", "geojson"}).out);
  EXPECT_EQ(geojson["frame"]["name"], "hall");
  EXPECT_EQ(geojson["frame"]["unit"], "m");
  EXPECT_EQ(geojson["features"][0]["geometry"]["coordinates"], Json({5.6, 10.5}));
  EXPECT_EQ(geojson["frame"]["right"], Json({1.0, 0.0, 0.0}));
  EXPECT_EQ(geojson["frame"]["top"], Json({0.0, 1.0, 0.0}));

  const fs::path plan = folder_ / "plan.png";
  ASSERT_TRUE(cv::imwrite(plan.string(), cv::Mat(200, 300, CV_8UC1, cv::Scalar(255))));
  const RunResult anchored = RunWaystone({"plan", map, plan, "--anchor", "20,30=node:1", "--anchor",
                                          "20,130=node:" + std::to_string(kPanoramas)});
  EXPECT_EQ(anchored.code, 0) << anchored.err;

  // Poses of the queries, in the same frame.
  std::ofstream queries(folder_ / "queries.csv");
  queries << "image,frame,x,y,z,qw,qx,qy,qz\n";
  for (const int step : {2, 3, 4}) {
    std::string pose_line = PoseLine(Query(step), step + 0.5);
    queries << pose_line.insert(pose_line.find(','), "," + std::to_string(step));
  }
  queries.close();
  const RunResult eval = RunWaystone({"eval", map, folder_ / "queries.csv", "--json"});
  ASSERT_EQ(eval.code, 0) << eval.err;
  const Json evaluation = Json::parse(eval.out);
  EXPECT_EQ(evaluation["right"], 3);
  EXPECT_LT(evaluation["position_m"]["median"].get<double>(), 0.15);
}

TEST_F(PosedPanoramaMap, PosesOfTooFewPanoramasAreRefused) {
  const fs::path map = folder_ / "refused.db";
  const RunResult refused = BuildPosed(WritePoses("few.csv", 4), map);
  EXPECT_NE(refused.code, 0);
  EXPECT_NE(refused.err.find("only 4 of 12 panoramas have a pose"), std::string::npos)
      << refused.err;
  EXPECT_FALSE(fs::exists(map));
}

}  // namespace
}  // namespace waystone
