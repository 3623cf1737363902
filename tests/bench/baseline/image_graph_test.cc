// SPDX-License-Identifier: Apache-2.0
#include "bench/baseline/image_graph.h"

#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include "tests/bench/baseline/made_graph.h"

namespace waystone::bench {
namespace {

TEST(ImageGraph, JoinsImagesThatShareAPlaneAndNoOthers) {
  const ImageGraph graph = BuildImageGraph(MadeNodes(), {});
  ASSERT_EQ(graph.edges.size(), 1u);
  EXPECT_EQ(graph.edges[0].a, KeyframeId{1});
  EXPECT_EQ(graph.edges[0].b, KeyframeId{2});
  EXPECT_GE(graph.edges[0].inliers, 75);
  for (const Eigen::Vector2d& x : {Eigen::Vector2d(50, 50), Eigen::Vector2d(600, 400)}) {
    const Eigen::Vector2d moved = Apply(graph.edges[0].b_from_a, x);
    EXPECT_LT((moved - Apply(MadeHomography(), x)).norm(), 0.1);
  }
}

TEST(ImageGraph, ComparesEveryImageWithEveryOther) {
  const Features first = MadeImage(120, 1);
  std::vector<ImageNode> nodes;
  for (int i = 0; i < 6; ++i) nodes.push_back({KeyframeId{i + 1}, i, first});
  EXPECT_EQ(BuildImageGraph(nodes, {}).edges.size(), 15u);
}

TEST(ImageGraph, IsTheSameOnAnyNumberOfThreads) {
  const auto on = [](int threads) {
    tbb::task_arena arena(threads);
    return arena.execute([] { return BuildImageGraph(MadeNodes(), {}); });
  };
  EXPECT_TRUE(on(1) == on(3));
}

class Localization : public testing::Test {
 protected:
  ImageGraph graph_ = BuildImageGraph(MadeNodes(), {});
  ImageGraphOptions options_;
};

TEST_F(Localization, TheImageWithMostInliersWins) {
  // 60 features of image 3 and 30 of image 1.
  const Features& third = graph_.nodes[2].features;
  Features query = Seen(third, MadeHomography(), 60, 9);
  for (int i = 0; i < 30; ++i) {
    query.keypoints.push_back(graph_.nodes[0].features.keypoints[100 + i]);
    query.descriptors.Append(graph_.nodes[0].features.descriptors.row(100 + i));
  }
  const ImageAnswer answer = LocalizeInImages(graph_, query, options_);
  EXPECT_EQ(answer.node, 2);
  EXPECT_GE(answer.inliers, 50);
  EXPECT_EQ(answer.homographies_tried, 1);  // 30 matches can't beat it
  ASSERT_FALSE(answer.query_points.empty());
  const Eigen::Matrix3d truth = MadeHomography().inverse();
  for (const Eigen::Vector2d& x : answer.query_points) {
    EXPECT_LT((Apply(answer.node_from_query, x) - Apply(truth, x)).norm(), 0.5);
  }
}

TEST_F(Localization, AQueryOfNothingKnownHasNoAnswer) {
  const ImageAnswer answer = LocalizeInImages(graph_, MadeImage(200, 77), options_);
  EXPECT_EQ(answer.node, -1);
  EXPECT_TRUE(answer.query_points.empty());
}

TEST_F(Localization, MatchesWithoutAHomographyAreNoAnswer) {
  Features query = graph_.nodes[2].features;
  Random random(5);
  for (Keypoint& k : query.keypoints) k = At({random.Uniform(0, 640), random.Uniform(0, 480)});
  EXPECT_EQ(LocalizeInImages(graph_, query, options_).node, -1);
}

TEST_F(Localization, OpenCvsWayFindsTheSameImage) {
  std::vector<cv::Mat> floats;
  for (const ImageNode& node : graph_.nodes) floats.push_back(FloatDescriptors(node.features));
  const Features query = Seen(graph_.nodes[2].features, MadeHomography(), 60, 9);
  const ImageAnswer answer = LocalizeWithOpenCv(graph_, floats, query, options_);
  EXPECT_EQ(answer.node, 2);
  EXPECT_GE(answer.inliers, 50);
  EXPECT_EQ(LocalizeWithOpenCv(graph_, floats, MadeImage(200, 77), options_).node, -1);
}

}  // namespace
}  // namespace waystone::bench
