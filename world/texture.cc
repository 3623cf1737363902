// SPDX-License-Identifier: Apache-2.0
#include "world/texture.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>

#include "core/base/check.h"
#include "core/base/random.h"

namespace waystone {
namespace {

constexpr int kSubpixelBits = 4;  // OpenCV's fixed point for drawing
// Each finer size covers less, so that the coarse shapes stay visible beneath.
constexpr double kFinerCoverage = 0.9;

// How a style looks. Sizes are side lengths in metres; grey values run from 0 to 255.
struct Look {
  double coverage = 0.0;  // shapes' area over the picture's, for each size
  double contrast = 0.0;  // half the range of the shapes' grey values
  double grain = 0.0;     // amplitude of the fine noise that makes flat areas differ
  double base_low = 0.0;  // the background's grey value is between these
  double base_high = 0.0;
  std::vector<double> sizes_m;  // coarse to fine; the finest come last and stay whole
};

Look LookOf(TextureStyle style) {
  switch (style) {
    case TextureStyle::kWall:
      return {0.45, 90.0, 5.0, 95.0, 190.0, {0.8, 0.4, 0.2, 0.1, 0.05}};
    case TextureStyle::kBareWall:
      return {0.0, 0.0, 1.0, 150.0, 210.0, {}};
    case TextureStyle::kFloor:
      return {0.4, 50.0, 4.0, 80.0, 120.0, {0.8, 0.4, 0.2, 0.1}};
    case TextureStyle::kCeiling:
      return {0.05, 18.0, 2.0, 200.0, 220.0, {0.6, 0.3, 0.15}};
    case TextureStyle::kPoster:
      return {0.6, 120.0, 3.0, 60.0, 220.0, {0.4, 0.2, 0.1, 0.05}};
  }
  return {};
}

class Painter {
 public:
  explicit Painter(const TextureSpec& spec)
      : spec_(spec), look_(LookOf(spec.style)), random_(spec.seed) {}

  cv::Mat Paint() {
    base_ = random_.Uniform(look_.base_low, look_.base_high);
    image_ = cv::Mat(spec_.size_px, CV_8UC1, cv::Scalar(base_));
    // Each surface prefers some kinds of shapes, so that walls differ at a glance too.
    for (double& weight : kind_weights_) weight = random_.Uniform(0.15, 1.0);
    double coverage = look_.coverage;
    for (const double size_m : look_.sizes_m) {
      PaintSize(size_m / spec_.texel_m, coverage);
      coverage *= kFinerCoverage;
    }
    if (spec_.trim) PaintTrim();
    AddGrain();
    if (spec_.style == TextureStyle::kPoster) PaintFrame();
    return image_;
  }

 private:
  void PaintSize(double size_px, double coverage) {
    const double area = static_cast<double>(image_.cols) * image_.rows;
    const auto count = std::lround(spec_.richness * coverage * area / (size_px * size_px));
    for (int64_t i = 0; i < count; ++i) PaintShape(size_px * random_.Uniform(0.5, 1.3));
  }

  void PaintShape(double size_px) {
    const cv::Point2d centre(random_.Uniform(0.0, image_.cols), random_.Uniform(0.0, image_.rows));
    const double angle_rad = random_.Uniform(0.0, 2.0 * std::numbers::pi);
    const cv::Scalar grey(ShapeGrey());
    switch (DrawKind()) {
      case 0:
        return FillPolygon(Box(centre, angle_rad, size_px, random_.Uniform(0.3, 1.0)), grey);
      case 1:
        return FillPolygon(Star(centre, angle_rad, size_px, 3 + random_.Below(4)), grey);
      case 2:
        return DrawDisc(centre, size_px, grey);
      default:
        return DrawGlyph(centre, angle_rad, size_px, grey);
    }
  }

  int DrawKind() {
    double total = 0.0;
    for (const double weight : kind_weights_) total += weight;
    double draw = random_.Uniform(0.0, total);
    int kind = 0;
    while (kind + 1 < static_cast<int>(kind_weights_.size()) &&
           draw >= kind_weights_[static_cast<size_t>(kind)]) {
      draw -= kind_weights_[static_cast<size_t>(kind++)];
    }
    return kind;
  }

  double ShapeGrey() {
    // Away from the background, so that a shape is seen: between a third and all of the contrast.
    const double step = look_.contrast * random_.Uniform(0.33, 1.0);
    return std::clamp(base_ + (random_.Below(2) == 0 ? step : -step), 8.0, 247.0);
  }

  static cv::Point2d Polar(const cv::Point2d& centre, double angle_rad, double radius) {
    return {centre.x + radius * std::cos(angle_rad), centre.y + radius * std::sin(angle_rad)};
  }

  static std::vector<cv::Point2d> Box(const cv::Point2d& centre, double angle_rad, double size_px,
                                      double aspect) {
    const double radius = 0.5 * size_px * std::hypot(1.0, aspect);
    const double half = std::atan(aspect);
    return {Polar(centre, angle_rad + half, radius), Polar(centre, angle_rad - half, radius),
            Polar(centre, angle_rad + half + std::numbers::pi, radius),
            Polar(centre, angle_rad - half + std::numbers::pi, radius)};
  }

  // A polygon around its centre with corners at random distances, so rarely convex.
  std::vector<cv::Point2d> Star(const cv::Point2d& centre, double angle_rad, double size_px,
                                int corners) {
    std::vector<cv::Point2d> points;
    for (int i = 0; i < corners; ++i) {
      const double turn = (i + random_.Uniform(-0.3, 0.3)) * 2.0 * std::numbers::pi / corners;
      points.push_back(Polar(centre, angle_rad + turn, size_px * random_.Uniform(0.25, 0.75)));
    }
    return points;
  }

  static cv::Point Fixed(const cv::Point2d& point) {
    // Texel centres are at halves in our coordinates and at whole numbers in OpenCV's.
    constexpr double kScale = 1 << kSubpixelBits;
    return {static_cast<int>(std::lround((point.x - 0.5) * kScale)),
            static_cast<int>(std::lround((point.y - 0.5) * kScale))};
  }

  void FillPolygon(const std::vector<cv::Point2d>& corners, const cv::Scalar& grey) {
    std::vector<cv::Point> points;
    for (const cv::Point2d& corner : corners) points.push_back(Fixed(corner));
    cv::fillPoly(image_, points, grey, cv::LINE_AA, kSubpixelBits);
  }

  void DrawDisc(const cv::Point2d& centre, double size_px, const cv::Scalar& grey) {
    const bool ring = random_.Below(2) == 0;
    const int width = ring ? std::max(2, static_cast<int>(size_px * 0.15)) : cv::FILLED;
    const int radius = static_cast<int>(size_px * 0.45 * (1 << kSubpixelBits));
    cv::circle(image_, Fixed(centre), radius, grey, width, cv::LINE_AA, kSubpixelBits);
  }

  // A few thick strokes over a 3 x 3 grid, like a letter of an unknown script.
  void DrawGlyph(const cv::Point2d& centre, double angle_rad, double size_px,
                 const cv::Scalar& grey) {
    const auto node = [&](int index) {
      const cv::Point2d right = Polar({0.0, 0.0}, angle_rad, 0.5 * size_px);
      const int across = index % 3 - 1;
      const int down = index / 3 - 1;
      return Fixed({centre.x + across * right.x - down * right.y,
                    centre.y + across * right.y + down * right.x});
    };
    const int width = std::max(2, static_cast<int>(size_px * 0.14));
    const int strokes = 2 + random_.Below(3);
    int from = random_.Below(9);
    for (int i = 0; i < strokes; ++i) {
      const int to = (from + 1 + random_.Below(8)) % 9;
      cv::line(image_, node(from), node(to), grey, width, cv::LINE_AA, kSubpixelBits);
      from = to;
    }
  }

  // Noise at two scales: SIFT needs gradients around a corner to tell it from the next one.
  void AddGrain() {
    for (const double size_m : {0.05, 0.012}) {
      const int step = std::max(1, static_cast<int>(std::lround(size_m / spec_.texel_m)));
      cv::Mat coarse(image_.rows / step + 2, image_.cols / step + 2, CV_32FC1);
      for (int y = 0; y < coarse.rows; ++y) {
        for (int x = 0; x < coarse.cols; ++x) {
          coarse.at<float>(y, x) = static_cast<float>(random_.Uniform(-look_.grain, look_.grain));
        }
      }
      cv::Mat fine;
      cv::resize(coarse, fine, {coarse.cols * step, coarse.rows * step}, 0, 0, cv::INTER_LINEAR);
      cv::add(image_, fine(cv::Rect({0, 0}, image_.size())), image_, cv::noArray(), CV_8U);
    }
  }

  void PaintTrim() {
    switch (spec_.style) {
      case TextureStyle::kWall:
      case TextureStyle::kBareWall:
        return PaintWallTrim();
      case TextureStyle::kCeiling:
        return PaintGrid(0.6, 0.03, -70.0);  // panels
      case TextureStyle::kFloor:
        return PaintGrid(0.6, 0.015, 60.0);  // tiles and their joints
      case TextureStyle::kPoster:
        return;
    }
  }

  int Texels(double metres) const {
    return std::max(1, static_cast<int>(std::lround(metres / spec_.texel_m)));
  }

  // Clipped at the picture's border.
  void PaintBar(int left, int top, int width, int height, double grey) {
    const cv::Rect bar = cv::Rect(left, top, width, height) & cv::Rect({0, 0}, image_.size());
    if (!bar.empty()) image_(bar) = cv::Scalar(std::clamp(grey, 8.0, 247.0));
  }

  // Rows count from the ceiling down.
  void PaintWallTrim() {
    const int width = image_.cols;
    const int height = image_.rows;
    const double dark = base_ - 70;
    const double light = base_ + 70;
    PaintBar(0, 0, width, Texels(0.06), light);                     // cornice
    PaintBar(0, height - Texels(0.1), width, Texels(0.1), dark);    // skirting board
    PaintBar(0, height - Texels(1.0), width, Texels(0.08), light);  // rail
    PaintBar(0, 0, Texels(0.08), height, dark);                     // frames at both ends
    PaintBar(width - Texels(0.08), 0, Texels(0.08), height, dark);
  }

  void PaintGrid(double cell_m, double bar_m, double contrast) {
    const int bar = Texels(bar_m);
    for (double at = 0; at < image_.cols * spec_.texel_m; at += cell_m) {
      PaintBar(Texels(at), 0, bar, image_.rows, base_ + contrast);
    }
    for (double at = 0; at < image_.rows * spec_.texel_m; at += cell_m) {
      PaintBar(0, Texels(at), image_.cols, bar, base_ + contrast);
    }
  }

  void PaintFrame() {
    const int width = std::max(2, static_cast<int>(0.03 / spec_.texel_m));
    const cv::Scalar grey(random_.Below(2) == 0 ? 20.0 : 240.0);
    const cv::Size size = image_.size();
    image_(cv::Rect(0, 0, size.width, width)) = grey;
    image_(cv::Rect(0, size.height - width, size.width, width)) = grey;
    image_(cv::Rect(0, 0, width, size.height)) = grey;
    image_(cv::Rect(size.width - width, 0, width, size.height)) = grey;
  }

  const TextureSpec& spec_;
  const Look look_;
  Random random_;
  cv::Mat image_;
  double base_ = 0.0;
  std::array<double, 4> kind_weights_{};
};

}  // namespace

cv::Mat DrawTexture(const TextureSpec& spec) {
  WS_CHECK(spec.size_px.width > 0 && spec.size_px.height > 0 && spec.texel_m > 0.0,
           "a texture needs a size");
  return Painter(spec).Paint();
}

uint64_t MixSeeds(uint64_t a, uint64_t b) {
  uint64_t mixed = a * 0x9E3779B97F4A7C15ULL + b + 0x632BE59BD9B4E019ULL;
  for (const int shift : {30, 27, 31}) {
    mixed = (mixed ^ (mixed >> shift)) * 0xD6E8FEB86659FD93ULL;
  }
  return mixed ^ (mixed >> 32);
}

MipMap::MipMap(const cv::Mat& base) {
  WS_CHECK(base.type() == CV_8UC1 && !base.empty(), "a mip map is made of a grey picture");
  AddLevel(base.clone(), 1.0F);
  while (std::min(levels_.back().width, levels_.back().height) > 1) {
    const Level& last = levels_.back();
    cv::Mat even;  // a repeated border keeps texel (0, 0) of every level at the same corner
    cv::copyMakeBorder(last.image, even, 0, last.height % 2, 0, last.width % 2,
                       cv::BORDER_REPLICATE);
    cv::Mat half;
    cv::resize(even, half, {even.cols / 2, even.rows / 2}, 0, 0, cv::INTER_AREA);
    AddLevel(half, last.scale * 0.5F);
  }
}

void MipMap::AddLevel(const cv::Mat& image, float scale) {
  levels_.push_back(
      {image, scale, image.data, static_cast<int>(image.step[0]), image.cols, image.rows});
}

float MipMap::Bilinear(const Level& level, float u, float v) {
  const float x = std::clamp(u * level.scale - 0.5F, 0.0F, static_cast<float>(level.width - 1));
  const float y = std::clamp(v * level.scale - 0.5F, 0.0F, static_cast<float>(level.height - 1));
  const int x0 = static_cast<int>(x);
  const int y0 = static_cast<int>(y);
  const int right = x0 + 1 < level.width ? 1 : 0;
  const uint8_t* top = level.data + static_cast<std::ptrdiff_t>(y0) * level.stride + x0;
  const uint8_t* bottom = y0 + 1 < level.height ? top + level.stride : top;
  const float fx = x - static_cast<float>(x0);
  const float fy = y - static_cast<float>(y0);
  const auto mix = [](float a, float b, float share) { return a + (b - a) * share; };
  return mix(mix(top[0], top[right], fx), mix(bottom[0], bottom[right], fx), fy);
}

float MipMap::Sample(float u, float v, float level) const {
  if (!(level > 0.0F)) return Bilinear(levels_.front(), u, v);
  const auto last = static_cast<float>(levels_.size() - 1);
  if (level >= last) return Bilinear(levels_.back(), u, v);
  const auto below = static_cast<size_t>(level);
  const float share = level - static_cast<float>(below);
  const float fine = Bilinear(levels_[below], u, v);
  return fine + (Bilinear(levels_[below + 1], u, v) - fine) * share;
}

}  // namespace waystone
