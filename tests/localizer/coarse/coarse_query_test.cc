// SPDX-License-Identifier: Apache-2.0
// How an image is described for the search of all maps.
#include "localizer/coarse/coarse_query.h"

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

#include "tests/world/test_worlds.h"

namespace waystone {
namespace {

std::vector<CoarseDescriptors> DescribePanorama(const cv::Mat& grey) {
  ImageFeatures features;
  return DescribeForCoarse(grey, {{.type = FeatureType::kSift, .panoramas = true}}, {}, {},
                           features);
}

// Panoramas that answers take, to 2 %, are searched for as well.
TEST(CoarseQuery, PanoramasMayBeALittleWiderOrNarrower) {
  const World rooms(TwoRooms(), TestOptions());
  const Renderer renderer(PanoramaCamera(512));
  const cv::Mat exact = renderer.Render(rooms, WorldFromCamera({1.5, 1.7, 1.2}, 0.4)).grey;
  const int rows = DescribePanorama(exact).front().rows.rows();
  ASSERT_GT(rows, 50);
  for (const int width : {506, 514, 517}) {
    cv::Mat scaled;
    cv::resize(exact, scaled, {width, exact.rows}, 0, 0, cv::INTER_LINEAR);
    const auto described = DescribePanorama(scaled);
    ASSERT_EQ(described.size(), 1U);
    EXPECT_GT(described.front().rows.rows(), rows / 2) << width;
  }
}

}  // namespace
}  // namespace waystone
