// SPDX-License-Identifier: Apache-2.0
#include <iostream>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>

#include "bench/accuracy/common.h"
#include "cli/system/child_process.h"
#include "core/base/error.h"
#include "core/base/random.h"
#include "server/http/http_server.h"
#include "server/service/application.h"

namespace waystone::bench {
namespace {

constexpr int kFeatures = 20;       // of a plane, at most; the page shows only their number
constexpr int kNext = 3;            // of the next planes, at most, that one is seen together with
constexpr int kPlanesPerLoop = 50;  // one in so many is seen together with a plane far away

// A picture of noise, which compresses as badly as a photo.
std::vector<uint8_t> Picture(Random& random) {
  cv::Mat picture(120, 160, CV_8U);
  for (int i = 0; i < static_cast<int>(picture.total()); ++i) {
    picture.data[i] = static_cast<uint8_t>(random.Below(256));
  }
  std::vector<uint8_t> jpeg;
  cv::imencode(".jpg", picture, jpeg);
  return jpeg;
}

Plane MakePlane(int number, Random& random) {
  Plane plane;
  plane.id = PlaneId{number};
  plane.reference = KeyframeId{number};
  plane.descriptors = Descriptors(DescriptorBytes(FeatureType::kSift));
  for (int i = 0; i <= random.Below(kFeatures); ++i) {
    const float x = static_cast<float>(random.Below(640));
    plane.features.push_back({{x, static_cast<float>(random.Below(480)), 4.0F, 0.0F}, 2, 2});
    std::vector<uint8_t> row(128);
    for (uint8_t& byte : row) byte = static_cast<uint8_t>(random.Below(128));
    plane.descriptors.Append(row.data());
  }
  plane.outline = {{0, 0}, {640, 0}, {640, 480}, {0, 480}};
  plane.views = {{plane.reference, Eigen::Matrix3d::Identity(), kFeatures}};
  return plane;
}

// A map like that of a long walk, to be viewed: one plane per keyframe, joined to the next ones and
// now and then to one that was passed earlier.
MapData WalkLikeMap(int planes) {
  Random random(1);
  MapData map;
  map.info = {"walk", "waystone-bench", FeatureType::kSift, "{}", "sha256:bench"};
  map.sequences.push_back({SequenceId{1}, "walk", "folder", planes, 0, std::nullopt});
  const std::vector<uint8_t> jpeg = Picture(random);
  for (int i = 1; i <= planes; ++i) {
    map.keyframes.push_back({KeyframeId{i},
                             SequenceId{1},
                             (i - 1) * 8 / planes,
                             i,
                             std::to_string(i) + ".jpg",
                             std::nullopt,
                             640,
                             480,
                             jpeg,
                             {}});
    map.planes.push_back(MakePlane(i, random));
    const auto join = [&](int a, int b) {
      map.edges.push_back({PlaneId{a}, PlaneId{b}, KeyframeId{b - 1}, KeyframeId{b},
                           Eigen::Matrix3d::Identity(), 1.5});
    };
    if (i > 1 && i % kPlanesPerLoop == 0) join(1 + random.Below(i - kNext), i);
    for (int step = 1; step <= 1 + random.Below(kNext); ++step) {
      if (i > step) join(i - step, i);
    }
  }
  return map;
}

nlohmann::json Measure(int planes, const std::string& script) {
  Application app({{"walk", MapIndex::Build(WalkLikeMap(planes))}}, {}, {});
  HttpOptions options;
  options.port = 0;
  HttpServer server(options, [&](const HttpRequest& in) { return app.Answer(in); });
  server.Start();
  ChildProcess browser({"/usr/bin/env", "node", script, server.url()}, true);
  const std::string line = browser.ReadLine();
  if (browser.Wait() != 0) {
    throw MapError(ErrorCode::kUsage,
                   "the browser didn't run; this takes Node 20, 'make web' and Chromium");
  }
  return nlohmann::json::parse(line);
}

}  // namespace

int RunPage(const Args& args) {
  std::vector<int> sizes;
  for (const std::string& arg : args) sizes.push_back(ParseRange(arg + ":" + arg).from);
  if (sizes.empty()) sizes = {500, 10'000};
  nlohmann::json results = nlohmann::json::array();
  for (const int planes : sizes) {
    const nlohmann::json result =
        Measure(planes, WAYSTONE_SOURCE_DIR "/bench/web/measure_page.mjs");
    std::cout << planes << " planes: first view after " << result["first_view_ms"]
              << " ms, graph after " << result["graph_ms"] << " ms, "
              << result["frames_per_s_laying_out"] << " frames/s while it is laid out, "
              << result["frames_per_s"] << " afterwards\n";
    results.push_back(result);
  }
  std::cout << nlohmann::json{{"bench", "page"}, {"maps", results}} << std::endl;
  return 0;
}

}  // namespace waystone::bench
