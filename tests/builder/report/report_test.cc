// SPDX-License-Identifier: Apache-2.0
#include "builder/report/report.h"

#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <set>
#include <string>

#include "builder/report/colours.h"
#include "builder/report/graph_layout.h"
#include "builder/report/html.h"
#include "builder/report/overlay.h"
#include "builder/report/surface_graph.h"
#include "core/base/error.h"
#include "schema/layers/planes/surfaces.h"
#include "tests/registry/file_size_limit.h"

namespace waystone {
namespace {

// `planes` planes of which the first `chained` hang together in a chain.
MapData Chain(int planes, int chained) {
  MapData map;
  map.info.name = "<lab>";
  map.keyframes.push_back({KeyframeId{1}, SequenceId{1}, 0, 0, "a&b.jpg", {}, 320, 240, {}, {}});
  for (int i = 1; i <= planes; ++i) {
    Plane plane;
    plane.id = PlaneId{i};
    plane.reference = KeyframeId{1};
    plane.features.push_back({{100.0F, 80.0F, 4.0F, 0.0F}, 1, 1});
    plane.views.push_back({KeyframeId{1}, Eigen::Matrix3d::Identity(), 1});
    map.planes.push_back(plane);
    if (i < 2 || i > chained) continue;
    Edge edge;
    edge.a = PlaneId{i - 1};
    edge.b = PlaneId{i};
    edge.homology.row(0) << 1, 0, 5;  // two planes
    map.edges.push_back(edge);
  }
  return map;
}

std::vector<Eigen::Vector2d> LayOut(const MapData& map) {
  const SurfaceGraph graph = SurfacesOf(map);
  return LayOutGraph(graph.surfaces.size(), graph.edges);
}

TEST(GraphLayout, StaysInTheUnitSquareAndApart) {
  for (const auto& [planes, chained] :
       {std::pair{0, 0}, {1, 0}, {2, 0}, {2, 2}, {9, 5}, {30, 30}}) {
    const auto at = LayOut(Chain(planes, chained));
    ASSERT_EQ(at.size(), static_cast<size_t>(planes));
    for (size_t i = 0; i < at.size(); ++i) {
      EXPECT_GE(at[i].minCoeff(), -1e-9);
      EXPECT_LE(at[i].maxCoeff(), 1 + 1e-9);
      for (size_t j = 0; j < i; ++j) EXPECT_GT((at[i] - at[j]).norm(), 1e-3) << i << ' ' << j;
    }
  }
}

TEST(GraphLayout, SameMapSamePicture) { EXPECT_EQ(LayOut(Chain(20, 12)), LayOut(Chain(20, 12))); }

TEST(GraphLayout, NeighboursAreNearerThanEndsOfTheChain) {
  const auto at = LayOut(Chain(10, 10));
  EXPECT_LT((at[4] - at[5]).norm(), (at[0] - at[9]).norm());
}

// The surfaces of a rendered building: the springs never came to rest.
TEST(GraphLayout, EndsThoughTheSpringsSwingForEver) {
  const std::vector<std::pair<size_t, size_t>> edges = {
      {0, 1},  {0, 2},  {2, 3},   {2, 4},   {3, 4},   {3, 5},   {4, 5},
      {4, 6},  {5, 6},  {5, 7},   {5, 8},   {5, 9},   {7, 8},   {7, 9},
      {9, 10}, {9, 11}, {10, 11}, {11, 12}, {12, 13}, {13, 14}, {14, 15}};
  const auto at = LayOutGraph(16, edges);
  ASSERT_EQ(at.size(), 16u);
  EXPECT_LT((at[13] - at[14]).norm(), (at[0] - at[15]).norm());
}

// A long corridor with doors, and surfaces in pairs.
std::vector<std::pair<size_t, size_t>> CorridorAndPairs(size_t corridor, size_t pairs) {
  std::vector<std::pair<size_t, size_t>> edges;
  for (size_t i = 1; i < corridor; ++i) edges.emplace_back(i - 1, i);
  for (size_t i = 3; i < corridor; i += 7) edges.emplace_back(i - 3, i);
  for (size_t i = 0; i < pairs; ++i) edges.emplace_back(corridor + 2 * i, corridor + 2 * i + 1);
  return edges;
}

TEST(GraphLayout, ManyNodesTakeSeconds) {
  const auto edges = CorridorAndPairs(10'000, 5'000);
  const auto start = std::chrono::steady_clock::now();
  EXPECT_EQ(LayOutGraph(20'000, edges).size(), 20'000u);
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(30));
}

TEST(GraphLayout, ForcesLayOutManyNodes) {
  constexpr size_t kNodes = 1000;
  const auto edges = CorridorAndPairs(kNodes, 0);
  const auto at = LayOutGraph(kNodes, edges);
  double near = 0;
  double far = 0;
  for (size_t i = 0; i < kNodes / 2; ++i) {
    near += (at[i] - at[i + 1]).norm();
    far += (at[i] - at[i + kNodes / 2]).norm();
  }
  EXPECT_LT(near, far / 5);
  EXPECT_EQ(at, LayOutGraph(kNodes, edges));
}

TEST(SurfaceGraph, PlanesOfOneSurfaceAreOneNode) {
  MapData map = Chain(4, 4);
  map.edges[1].homology.setIdentity();  // planes 2 and 3
  const SurfaceGraph graph = SurfacesOf(map);
  ASSERT_EQ(graph.surfaces.size(), 3u);
  EXPECT_EQ(graph.surfaces[1].planes, (std::vector{PlaneId{2}, PlaneId{3}}));
  EXPECT_EQ(graph.surfaces[1].features, 2u);
  EXPECT_EQ(graph.edges, (std::vector<std::pair<size_t, size_t>>{{0, 1}, {1, 2}}));
  EXPECT_EQ(graph.of_plane.at(PlaneId{3}), PlaneId{2});
}

TEST(Colours, NeighbouringIdsDiffer) {
  std::set<std::string> seen;
  for (int i = 1; i <= 50; ++i) seen.insert(CssColourOf(PlaneId{i}));
  EXPECT_EQ(seen.size(), 50u);
  EXPECT_EQ(CssColourOf(PlaneId{7}).size(), 7u);
  EXPECT_EQ(CssColourOf(PlaneId{0}), "#ff6161") << "as on the page";
}

cv::Mat DrawFirst(const MapData& map) {
  return DrawPlanes(map, FindSurfaces(map.planes, map.edges), map.keyframes[0]);
}

TEST(Overlay, DrawsAFeatureWhereItIs) {
  const MapData map = Chain(1, 0);
  const cv::Mat picture = DrawFirst(map);
  ASSERT_EQ(picture.size(), cv::Size(640, 480));
  const auto pixel = picture.at<cv::Vec3b>(160, 200);  // (100, 80) at twice the size
  const cv::Scalar colour = ColourOf(PlaneId{1});
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(pixel[c], colour[c], 1.0);
  EXPECT_EQ(picture.at<cv::Vec3b>(20, 20), cv::Vec3b(90, 90, 90));
}

TEST(Overlay, OfANarrowImageIsNotTooHigh) {
  MapData map = Chain(1, 0);
  map.keyframes[0].width = 100;
  map.keyframes[0].height = 60'000;
  EXPECT_EQ(DrawFirst(map).size(), cv::Size(6, 4096));
}

TEST(Overlay, PlanesOfOneSurfaceHaveOneColour) {
  MapData map = Chain(2, 2);
  map.planes[1].features[0].reference.x_px = 200;
  map.edges[0].homology.setIdentity();
  const cv::Mat picture = DrawFirst(map);
  EXPECT_EQ(picture.at<cv::Vec3b>(160, 200), picture.at<cv::Vec3b>(160, 400));
}

TEST(Overlay, FeaturesBehindTheCameraAreNotDrawn) {
  MapData map = Chain(1, 0);
  map.planes[0].views[0].reference_from_keyframe << 1, 0, 0, 0, 1, 0, 0, 0, 1e-300;
  EXPECT_NO_THROW(DrawFirst(map));
}

TEST(WriteReport, WritesAPageThatNamesNothingUnescaped) {
  const auto dir = std::filesystem::path(testing::TempDir()) / "waystone-report-test";
  std::filesystem::remove_all(dir);
  WriteReport(Chain(3, 3), {}, {{"planes", 3, 100}}, dir);
  std::ifstream in(dir / "index.html");
  const std::string page{std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
  EXPECT_NE(page.find("&lt;lab&gt;"), std::string::npos);
  EXPECT_EQ(page.find("<lab>"), std::string::npos);
  EXPECT_NE(page.find("a&amp;b.jpg"), std::string::npos);
  EXPECT_TRUE(std::filesystem::exists(dir / "images" / "1.jpg"));
  std::filesystem::remove_all(dir);
}

TEST(WriteReport, APageOfPanoramasHasNoTablesOfPlanes) {
  MapData map;
  map.info.name = "hall";
  map.appearance.emplace();
  for (int64_t id = 1; id <= 2; ++id) {
    AppearanceNode node;
    node.id = AppearanceNodeId{id};
    node.pose.x = static_cast<double>(id);
    map.appearance->nodes.push_back(node);
  }
  BuildReport report;
  report.appearance.emplace();
  report.appearance->panoramas = 2;
  const std::string page = ReportHtml(map, report, {});
  EXPECT_NE(page.find("Trajectory of the panoramas"), std::string::npos);
  EXPECT_NE(page.find("loop candidates"), std::string::npos);
  EXPECT_EQ(page.find("planes created"), std::string::npos);
  EXPECT_EQ(page.find("Keyframes and their planes"), std::string::npos);
}

TEST(WriteReport, ReplacesItsOwnFilesAlone) {
  const auto dir = std::filesystem::path(testing::TempDir()) / "waystone-report-walk";
  std::filesystem::remove_all(dir);
  std::filesystem::create_directories(dir / "images");
  std::ofstream(dir / "images" / "1.jpg") << "a photo";
  EXPECT_THROW(CheckReportFolder(dir), MapError);
  EXPECT_THROW(WriteReport(Chain(1, 0), {}, {}, dir), MapError);
  EXPECT_EQ(std::filesystem::file_size(dir / "images" / "1.jpg"), 7U);
  std::filesystem::remove_all(dir);
  WriteReport(Chain(1, 0), {}, {}, dir);
  WriteReport(Chain(1, 0), {}, {}, dir);
  std::ofstream(dir / "index.html") << "a page";
  EXPECT_THROW(WriteReport(Chain(1, 0), {}, {}, dir), MapError);
  std::filesystem::remove_all(dir);
}

TEST(WriteReport, NoPictureOfAnEarlierReportStays) {
  const std::filesystem::path dir =
      std::filesystem::path(testing::TempDir()) / "waystone_report_twice";
  std::filesystem::remove_all(dir);
  CheckReportFolder(dir / "deep");
  EXPECT_FALSE(std::filesystem::exists(dir)) << "asking leaves no folder";
  MapData two = Chain(1, 0);
  two.keyframes.push_back({KeyframeId{2}, SequenceId{1}, 0, 1, "b.jpg", {}, 320, 240, {}, {}});
  WriteReport(two, {}, {}, dir);
  std::ofstream(dir / "images" / "notes.txt") << "mine";
  ASSERT_TRUE(std::filesystem::exists(dir / "images" / "2.jpg"));
  WriteReport(Chain(1, 0), {}, {}, dir);
  EXPECT_TRUE(std::filesystem::exists(dir / "images" / "1.jpg"));
  EXPECT_FALSE(std::filesystem::exists(dir / "images" / "2.jpg"));
  EXPECT_TRUE(std::filesystem::exists(dir / "images" / "notes.txt"));
  std::filesystem::remove_all(dir);
}

// Once there is room, the report is written to the same folder.
TEST(WriteReport, AFullDiskLeavesNoFolderOfSomebodyElse) {
  const auto dir = std::filesystem::path(testing::TempDir()) / "waystone-report-full";
  std::filesystem::remove_all(dir);
  for (const rlim_t bytes : {rlim_t{0}, rlim_t{1000}}) {
    const FileSizeLimit limit(bytes);
    try {
      WriteReport(Chain(3, 3), {}, {}, dir);
      ADD_FAILURE() << "nothing was thrown";
    } catch (const MapError& error) {
      EXPECT_EQ(error.code(), ErrorCode::kFileUnwritable);
      EXPECT_NE(std::string(error.what()).find("index.html can't be written: "), std::string::npos)
          << error.what();
    }
    EXPECT_TRUE(std::filesystem::is_empty(dir));
  }
  WriteReport(Chain(3, 3), {}, {}, dir);
  const auto page = std::filesystem::file_size(dir / "index.html");
  {
    const FileSizeLimit limit(1000);
    EXPECT_THROW(WriteReport(Chain(3, 3), {}, {}, dir), MapError);
  }
  EXPECT_EQ(std::filesystem::file_size(dir / "index.html"), page) << "the earlier one stays";
  EXPECT_NO_THROW(CheckReportFolder(dir));
  std::filesystem::remove_all(dir);
}

TEST(WriteReport, FolderThatCannotBeMade) {
  EXPECT_THROW(CheckReportFolder("/proc/waystone-report"), MapError);
  EXPECT_THROW(CheckReportFolder("/proc/version"), MapError);
  EXPECT_THROW(WriteReport(Chain(1, 0), {}, {}, "/proc/waystone-report"), MapError);
}

}  // namespace
}  // namespace waystone
