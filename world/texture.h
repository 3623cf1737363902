// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

namespace waystone {

enum class TextureStyle { kWall, kBareWall, kFloor, kCeiling, kPoster };

struct TextureSpec {
  TextureStyle style = TextureStyle::kWall;
  cv::Size size_px;       // texels
  double texel_m = 0.0;   // metres per texel
  double richness = 1.0;  // density of shapes, 0 to 2
  bool trim = false;      // draw building trim along the picture's sides: see WorldOptions
  uint64_t seed = 0;
};

// A grey picture (CV_8UC1) of many overlapping polygons, discs and glyphs of several sizes: depends
// only on the spec. Bare walls and ceilings have few marks or none. Pure; thread-safe, as is
// MixSeeds.
cv::Mat DrawTexture(const TextureSpec& spec);

// A seed that depends on every bit of both numbers.
uint64_t MixSeeds(uint64_t a, uint64_t b);

// A grey picture at its own size, half, a quarter, ..., for sampling without aliasing. Immutable
// and thread-safe.
class MipMap {
 public:
  explicit MipMap(const cv::Mat& base);

  // The grey value around (u, v), in texels of the base: (0, 0) is the corner of the first texel,
  // (0.5, 0.5) its centre. `level` is log2 of the wanted blur in texels, clamped to what there is;
  // values between levels and texels are interpolated. Outside, the border continues.
  float Sample(float u, float v, float level) const;

 private:
  struct Level {
    cv::Mat image;
    float scale = 1.0F;  // texels of this level over those of the base
    // The same as in `image`, at hand for the innermost loop.
    const uint8_t* data = nullptr;
    int stride = 0;
    int width = 0;
    int height = 0;
  };
  void AddLevel(const cv::Mat& image, float scale);
  static float Bilinear(const Level& level, float u, float v);

  std::vector<Level> levels_;
};

}  // namespace waystone
