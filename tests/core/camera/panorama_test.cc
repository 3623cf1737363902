// SPDX-License-Identifier: Apache-2.0
#include "core/camera/panorama.h"

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/imgproc.hpp>
#include <string>

#include "core/base/error.h"
#include "core/base/random.h"
#include "core/camera/cube_faces.h"
#include "core/geometry/angle.h"

namespace waystone {
namespace {

// A smooth pattern on the sphere, 0 to 255: continuous over the seam.
double Pattern(double azimuth, double elevation) {
  return 128 + 50 * std::sin(3 * azimuth + 1) * std::cos(elevation) +
         40 * std::cos(7 * azimuth) * std::cos(2 * elevation) * std::cos(elevation) +
         30 * std::sin(4 * elevation);
}

cv::Mat PatternPanorama(int width) {
  cv::Mat image(width / 2, width, CV_8UC1);
  for (int y = 0; y < image.rows; ++y) {
    for (int x = 0; x < width; ++x) {
      const double value =
          Pattern(2 * kPi * (x + 0.5) / width - kPi, kPi / 2 - kPi * (y + 0.5) / image.rows);
      image.at<uint8_t>(y, x) = cv::saturate_cast<uint8_t>(value);
    }
  }
  return image;
}

// What a mirror camera sees of the pattern: elevation goes with the radius.
cv::Mat PatternMirror(const cv::Size& size, const MirrorRing& ring, const ElevationBand& band) {
  cv::Mat image(size, CV_8UC1, cv::Scalar(15));
  for (int y = 0; y < size.height; ++y) {
    for (int x = 0; x < size.width; ++x) {
      const cv::Point2d ray = cv::Point2d(x, y) - ring.centre_px;
      const double radius = std::hypot(ray.x, ray.y);
      if (radius > ring.outer_px) continue;
      const double share = (radius - ring.inner_px) / (ring.outer_px - ring.inner_px);
      const double elevation = band.bottom_rad + share * (band.top_rad - band.bottom_rad);
      const double value = Pattern(std::atan2(ray.x, -ray.y), elevation);
      image.at<uint8_t>(y, x) = radius < ring.inner_px ? 240 : cv::saturate_cast<uint8_t>(value);
    }
  }
  return image;
}

double MeanDifference(const cv::Mat& a, const cv::Mat& b) {
  return cv::norm(a, b, cv::NORM_L1) / static_cast<double>(a.total());
}

std::string RefusalOf(const cv::Mat& image, const PanoramaOptions& options = {}) {
  try {
    ToPanorama(image, options);
  } catch (const MapError& error) {
    EXPECT_EQ(error.code(), ErrorCode::kBadImage);
    return error.what();
  }
  return "none";
}

TEST(ToPanorama, TakesEquirectangularImagesAsTheyAre) {
  const cv::Mat image = PatternPanorama(256);
  const Panorama panorama = ToPanorama(image);
  EXPECT_EQ(panorama.band, ElevationBand{});
  EXPECT_EQ(MeanDifference(panorama.grey, image), 0);
}

TEST(ToPanorama, TakesColourAndDropsAlpha) {
  const cv::Mat grey = PatternPanorama(256);
  for (const int code : {cv::COLOR_GRAY2BGR, cv::COLOR_GRAY2BGRA}) {
    cv::Mat image;
    cv::cvtColor(grey, image, code);
    EXPECT_EQ(MeanDifference(ToPanorama(image).grey, grey), 0) << code;
  }
}

TEST(HasPanoramaShape, ToTwoPercent) {
  EXPECT_TRUE(HasPanoramaShape({200, 100}));
  EXPECT_TRUE(HasPanoramaShape({203, 100}));
  EXPECT_TRUE(HasPanoramaShape({197, 100}));
  EXPECT_FALSE(HasPanoramaShape({205, 100}));
  EXPECT_FALSE(HasPanoramaShape({195, 100}));
  EXPECT_FALSE(HasPanoramaShape({0, 0}));
}

TEST(BandsAgree, ToAMillionthOfARadian) {
  EXPECT_TRUE(BandsAgree({0.5, -0.5}, {0.5 + 5e-7, -0.5}));
  EXPECT_FALSE(BandsAgree({0.5, -0.5}, {0.5 + 2e-6, -0.5}));
  EXPECT_FALSE(BandsAgree({0.5, -0.5}, {0.5, -0.5 + 2e-6}));
}

TEST(ToPanorama, TakesAStripAroundTheHorizon) {
  const cv::Mat strip = PatternPanorama(256).rowRange(32, 96).clone();
  EXPECT_EQ(KindOf(strip), PanoramaKind::kStrip);
  const Panorama panorama = ToPanorama(strip);
  EXPECT_NEAR(panorama.band.top_rad, kPi / 4, 1e-12);
  EXPECT_NEAR(panorama.band.bottom_rad, -kPi / 4, 1e-12);
}

TEST(ToPanorama, RefusesWithTheNumberAndWhatToDo) {
  EXPECT_NE(RefusalOf(cv::Mat(128, 256, CV_8UC1, cv::Scalar(0))).find("uncover the lens"),
            std::string::npos);
  EXPECT_NE(RefusalOf(PatternPanorama(32)).find("32x16"), std::string::npos);
  const cv::Mat part = PatternPanorama(512).colRange(0, 300).rowRange(50, 200).clone();
  EXPECT_NE(RefusalOf(part).find("does not cover 360 degrees"), std::string::npos);
  cv::Mat noise(200, 300, CV_8UC1);
  Random random(1);
  noise.forEach<uint8_t>([](uint8_t& pixel, const int* at) {
    pixel = static_cast<uint8_t>(100 + (at[0] * 7 + at[1] * 13) % 40);
  });
  EXPECT_NE(RefusalOf(noise).find("neither a panorama"), std::string::npos);
}

TEST(ToPanorama, SeamMayLieAnywhere) {
  const cv::Mat image = PatternPanorama(256);
  for (int columns = 16; columns < 256; columns += 16) {
    cv::Mat turned;
    cv::hconcat(image.colRange(columns, 256), image.colRange(0, columns), turned);
    EXPECT_EQ(RefusalOf(turned), "none") << columns;
  }
}

TEST(FindMirror, FindsCentreAndRadii) {
  const PanoramaOptions options;
  for (const MirrorRing& ring :
       {MirrorRing{{320, 240}, 60, 220}, MirrorRing{{300.4, 251.7}, 45, 190},
        MirrorRing{{350, 230}, 70, 205.5}}) {
    const MirrorRing found = FindMirror(PatternMirror({640, 480}, ring, options.mirror_band));
    EXPECT_LT(cv::norm(found.centre_px - ring.centre_px), 1.6);
    EXPECT_NEAR(found.outer_px, ring.outer_px, 1.6);
    EXPECT_NEAR(found.inner_px, ring.inner_px, 3);
  }
}

// A lamp, a clock or a table in a photo has bright edges, too.
TEST(FindMirror, ABrightDiscInAPhotoIsNoMirror) {
  cv::RNG random(7);
  for (int i = 0; i < 10; ++i) {
    cv::Mat photo(480, 640, CV_8UC1);
    for (int block = 0; block < 300; ++block) {
      const cv::Point corner(random.uniform(-100, 640), random.uniform(-100, 480));
      const cv::Size size(random.uniform(20, 200), random.uniform(20, 200));
      cv::rectangle(photo, {corner, size}, random.uniform(0, 200), cv::FILLED);
    }
    cv::circle(photo, {320 + 5 * i, 240}, 120 + 10 * i, 230, cv::FILLED);
    EXPECT_NE(RefusalOf(photo).find("% of what surrounds its best circle has"), std::string::npos)
        << RefusalOf(photo);
  }
}

TEST(Unwrap, GivesThePanoramaThatTheMirrorSaw) {
  PanoramaOptions options;
  options.columns = 512;
  const MirrorRing ring = {{300, 250}, 50, 200};
  const cv::Mat image = PatternMirror({640, 480}, ring, options.mirror_band);
  for (const bool given : {true, false}) {
    if (given) options.mirror = ring;
    if (!given) options.mirror.reset();
    const Panorama panorama = ToPanorama(image, options);
    EXPECT_EQ(panorama.band, options.mirror_band);
    ASSERT_EQ(panorama.grey.cols, 512);
    cv::Mat expected(panorama.grey.size(), CV_8UC1);
    const double height = panorama.band.top_rad - panorama.band.bottom_rad;
    for (int y = 0; y < expected.rows; ++y) {
      for (int x = 0; x < expected.cols; ++x) {
        expected.at<uint8_t>(y, x) = cv::saturate_cast<uint8_t>(
            Pattern(2 * kPi * (x + 0.5) / expected.cols - kPi,
                    panorama.band.top_rad - (y + 0.5) * height / expected.rows));
      }
    }
    EXPECT_LT(MeanDifference(panorama.grey, expected), given ? 1.0 : 4.0) << given;
  }
}

TEST(CubeFaces, FacesOfAPanoramaGiveItBack) {
  const cv::Mat image = PatternPanorama(512);
  FaceImages faces;
  for (int i = 0; i < kCubeFaces; ++i) faces[i] = FaceOf(image, static_cast<CubeFace>(i), 256);
  PanoramaOptions options;
  options.columns = 512;
  const Panorama whole = FromFaces(faces, options);
  ASSERT_EQ(whole.grey.size(), image.size());
  EXPECT_LT(MeanDifference(whole.grey, image), 1.0);
  faces[static_cast<size_t>(CubeFace::kDown)] = cv::Mat();
  const Panorama five = FromFaces(faces, options);
  EXPECT_NEAR(five.band.bottom_rad, -std::atan(1 / std::sqrt(2.0)), 1e-12);
  EXPECT_EQ(five.band.top_rad, kPi / 2);
  EXPECT_LT(MeanDifference(five.grey, image.rowRange(0, five.grey.rows)), 3.0);
}

TEST(CubeFaces, AreRotationsThatLookWhereTheirNamesSay) {
  for (int i = 0; i < kCubeFaces; ++i) {
    const Eigen::Matrix3d rotation = RigFromFace(static_cast<CubeFace>(i));
    EXPECT_TRUE((rotation.transpose() * rotation).isIdentity()) << i;
    EXPECT_NEAR(rotation.determinant(), 1, 1e-12) << i;
  }
  EXPECT_EQ(RigFromFace(CubeFace::kRight).col(2), Eigen::Vector3d::UnitX());
  EXPECT_EQ(RigFromFace(CubeFace::kUp).col(2), -Eigen::Vector3d::UnitY());
  EXPECT_EQ(NameOf(CubeFace::kBack), "back");
}

TEST(Unwrap, RefusesWhatWouldTakeTooMuchMemory) {
  const cv::Mat image(300, 400, CV_8UC1, cv::Scalar(90));
  PanoramaOptions options;
  options.columns = 16'384;
  const auto code = [&](const MirrorRing& ring, const cv::Mat& grey) {
    try {
      Unwrap(grey, ring, options);
    } catch (const MapError& error) {
      return error.code();
    }
    return ErrorCode::kInternal;
  };
  EXPECT_EQ(code({{200, 150}, 10, 32'000}, image), ErrorCode::kBadImage);
  EXPECT_EQ(code({{200, 150}, 10, 1e6}, image), ErrorCode::kBadOptions);
  EXPECT_EQ(code({{std::nan(""), 150}, 10, 100}, image), ErrorCode::kBadOptions);
  EXPECT_EQ(code({{200, 1e300}, 10, 100}, image), ErrorCode::kBadOptions);
  EXPECT_EQ(code({{200, 150}, 10, 100}, cv::Mat(32'767, 20, CV_8UC1, cv::Scalar(90))),
            ErrorCode::kBadImage);
}

TEST(CubeFaces, RefuseFacesThatAreTooWide) {
  FaceImages faces;
  faces.fill(cv::Mat(5462, 5462, CV_8UC1, cv::Scalar(90)));
  EXPECT_THROW(FromFaces(faces), MapError);
}

TEST(CubeFaces, RefuseMissingSidesAndOtherSizes) {
  const cv::Mat image = PatternPanorama(128);
  FaceImages faces;
  for (int i = 0; i < kCubeFaces; ++i) faces[i] = FaceOf(image, static_cast<CubeFace>(i), 32);
  FaceImages missing = faces;
  missing[2] = cv::Mat();
  EXPECT_THROW(FromFaces(missing), MapError);
  FaceImages odd = faces;
  odd[1] = faces[1].rowRange(0, 30).clone();
  EXPECT_THROW(FromFaces(odd), MapError);
}

TEST(PanoramaOptions, RefuseWhatIsOutOfRange) {
  PanoramaOptions options;
  EXPECT_NO_THROW(options.Check());
  options.mirror = {{10, 10}, 50, 40};
  EXPECT_THROW(options.Check(), MapError);
  options = {};
  options.mirror_band = {-0.5, 0.5};
  EXPECT_THROW(options.Check(), MapError);
  options = {};
  options.max_seam = 0;
  EXPECT_THROW(options.Check(), MapError);
}

}  // namespace
}  // namespace waystone
