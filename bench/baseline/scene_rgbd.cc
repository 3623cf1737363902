// SPDX-License-Identifier: Apache-2.0
#include "bench/accuracy/rgbd_truth.h"
#include "bench/baseline/scenes.h"
#include "core/homography/homography.h"
#include "core/image/decode.h"

namespace waystone::bench {
namespace {

class RgbdScene : public Scene {
 public:
  RgbdScene(const std::string& folder, const Range& map, const Range& queries,
            const SceneLimits& limits)
      : folder_(folder), map_(map), queries_(queries), limits_(limits), truth_(folder) {
    name_ = std::filesystem::path(folder).filename();
  }

  const std::string& name() const override { return name_; }
  std::unique_ptr<Source> OpenMap() const override {
    return OpenSource(folder_, {.every = map_.step, .from = map_.from, .to = map_.to});
  }
  int queries() const override { return (queries_.to - queries_.from) / queries_.step + 1; }
  cv::Mat Decode(int query) const override {
    return DecodeGrey(ReadBytes(std::filesystem::path(folder_) / truth_.image(FrameOf(query))));
  }
  bool IsRight(int query, const SceneAnswer& answer) const override {
    const auto error_px = truth_.MedianError(FrameOf(query), answer);
    return error_px && *error_px <= limits_.kitchen_px;
  }
  std::string Criterion() const override {
    return "median transfer error by depth and poses <= " +
           std::to_string(static_cast<int>(limits_.kitchen_px)) + " px";
  }

 private:
  int FrameOf(int query) const { return queries_.from + query * queries_.step; }

  std::string folder_;
  std::string name_;
  Range map_;
  Range queries_;
  SceneLimits limits_;
  RgbdTruth truth_;
};

}  // namespace

std::unique_ptr<Scene> OpenRgbdScene(const std::string& folder, const Range& map,
                                     const Range& queries, const SceneLimits& limits) {
  return std::make_unique<RgbdScene>(folder, map, queries, limits);
}

}  // namespace waystone::bench
