// SPDX-License-Identifier: Apache-2.0
#include "core/camera/camera.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <numbers>
#include <opencv2/calib3d.hpp>

#include "core/base/error.h"
#include "core/base/random.h"

namespace waystone {
namespace {

// One camera a model, with the distortion of an ordinary lens (the fisheye: of a wide one).
std::vector<Camera> Cameras() {
  return {
      {CameraModel::kSimplePinhole, 640, 480, {500, 319.5, 239.5}},
      {CameraModel::kPinhole, 640, 480, {500, 510, 300, 250}},
      {CameraModel::kSimpleRadial, 640, 480, {500, 319.5, 239.5, -0.12}},
      {CameraModel::kRadial, 640, 480, {500, 319.5, 239.5, 0.1, 0.05}},
      {CameraModel::kOpenCv, 752, 480, {458, 457, 367, 248, -0.283, 0.074, 2e-4, 1.8e-5}},
      {CameraModel::kOpenCvFisheye, 512, 512, {190, 191, 254, 256, 0.0035, 7e-4, -2e-3, 2e-4}},
      {CameraModel::kFullOpenCv,
       1280,
       720,
       {610, 610, 640, 365, 0.38, -2.5, 4e-4, -2e-4, 1.4, 0.26, -2.3, 1.3}},
      {CameraModel::kEquirectangular, 1024, 512, {}},
  };
}

class EachModel : public testing::TestWithParam<Camera> {};

TEST_P(EachModel, PassesItsCheck) { EXPECT_NO_THROW(CheckCamera(GetParam())); }

TEST_P(EachModel, ProjectUndoesUnprojectAcrossTheImage) {
  const Camera& camera = GetParam();
  for (double v = 0; v <= camera.height - 1; v += (camera.height - 1) / 23.0) {
    for (double u = 0; u <= camera.width - 1; u += (camera.width - 1) / 31.0) {
      const Eigen::Vector3d ray = Unproject(camera, {u, v});
      EXPECT_NEAR(ray.norm(), 1, 1e-12);
      const auto pixel = Project(camera, ray);
      ASSERT_TRUE(pixel.has_value()) << u << " " << v;
      EXPECT_LT((*pixel - Eigen::Vector2d(u, v)).norm(), 1e-6) << u << " " << v;
    }
  }
}

TEST_P(EachModel, TheLengthOfARayDoesNotMatter) {
  const Camera& camera = GetParam();
  Random random(1);
  for (int i = 0; i < 100; ++i) {
    const Eigen::Vector2d pixel(random.Uniform(0, camera.width - 1),
                                random.Uniform(0, camera.height - 1));
    const Eigen::Vector3d ray = Unproject(camera, pixel);
    const auto far = Project(camera, ray * 1e3);
    const auto near = Project(camera, ray * 1e-3);
    ASSERT_TRUE(far && near);
    EXPECT_LT((*far - *near).norm(), 1e-6);
  }
}

TEST_P(EachModel, TheCentreAndWhatIsNotFiniteHaveNoPixel) {
  EXPECT_FALSE(Project(GetParam(), Eigen::Vector3d::Zero()));
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(Project(GetParam(), {0, nan, 1}));
  EXPECT_FALSE(Project(GetParam(), {0, 0, std::numeric_limits<double>::infinity()}));
}

TEST_P(EachModel, FarOutsideTheImageUnprojectStaysFinite) {
  for (const double far : {-1e6, -1e3, 1e4, 1e9}) {
    const Eigen::Vector3d ray = Unproject(GetParam(), {far, far / 2});
    EXPECT_TRUE(ray.allFinite()) << far;
    EXPECT_NEAR(ray.norm(), 1, 1e-9) << far;
  }
}

TEST_P(EachModel, NameLeadsBackToTheModel) {
  const Camera& camera = GetParam();
  EXPECT_EQ(CameraModelByName(NameOf(camera.model)), camera.model);
  EXPECT_EQ(ParameterCount(camera.model), static_cast<int>(camera.params.size()));
  const std::string_view names = ParameterNames(camera.model);
  EXPECT_EQ(std::ranges::count(names, ' ') + (names.empty() ? 0 : 1), camera.params.size());
}

INSTANTIATE_TEST_SUITE_P(Models, EachModel, testing::ValuesIn(Cameras()),
                         [](const auto& each) { return std::string(NameOf(each.param.model)); });

// OpenCV wrote the models down first; ours have to agree with it where it is defined.
TEST(CameraTest, AgreesWithOpenCv) {
  Random random(2);
  for (const Camera& camera : {Cameras()[4], Cameras()[6]}) {
    const cv::Matx33d k(camera.params[0], 0, camera.params[2], 0, camera.params[1],
                        camera.params[3], 0, 0, 1);
    const std::vector<double> distortion(camera.params.begin() + 4, camera.params.end());
    for (int i = 0; i < 100; ++i) {
      const cv::Point3d x(random.Uniform(-0.6, 0.6), random.Uniform(-0.4, 0.4), 1);
      std::vector<cv::Point2d> expected;
      cv::projectPoints(std::vector<cv::Point3d>{x}, cv::Vec3d(), cv::Vec3d(), k, distortion,
                        expected);
      const auto pixel = Project(camera, {x.x, x.y, x.z});
      ASSERT_TRUE(pixel.has_value());
      EXPECT_NEAR(pixel->x(), expected[0].x, 1e-9);
      EXPECT_NEAR(pixel->y(), expected[0].y, 1e-9);
    }
  }
}

TEST(CameraTest, FisheyeAgreesWithOpenCv) {
  const Camera camera = Cameras()[5];
  const std::vector<double>& p = camera.params;
  const cv::Matx33d k(p[0], 0, p[2], 0, p[1], p[3], 0, 0, 1);
  const cv::Vec4d distortion(p[4], p[5], p[6], p[7]);
  Random random(3);
  for (int i = 0; i < 100; ++i) {
    const cv::Point3d x(random.Uniform(-2, 2), random.Uniform(-2, 2), 1);
    std::vector<cv::Point2d> expected;
    cv::fisheye::projectPoints(std::vector<cv::Point3d>{x}, expected, cv::Vec3d(), cv::Vec3d(), k,
                               distortion);
    const auto pixel = Project(camera, {x.x, x.y, x.z});
    ASSERT_TRUE(pixel.has_value());
    EXPECT_NEAR(pixel->x(), expected[0].x, 1e-9);
    EXPECT_NEAR(pixel->y(), expected[0].y, 1e-9);
  }
}

TEST(CameraTest, PerspectiveSeesNothingBehindOrBesideItself) {
  for (const Camera& camera : Cameras()) {
    if (camera.model == CameraModel::kEquirectangular) continue;
    if (camera.model == CameraModel::kOpenCvFisheye) continue;
    EXPECT_FALSE(Project(camera, {0, 0, -1})) << NameOf(camera.model);
    EXPECT_FALSE(Project(camera, {0.1, 0.2, -1})) << NameOf(camera.model);
    EXPECT_FALSE(Project(camera, {1, 0, 0})) << NameOf(camera.model);
  }
}

TEST(CameraTest, FisheyeSeesALittleBehindItself) {
  const Camera camera = {CameraModel::kOpenCvFisheye, 512, 512, {150, 150, 256, 256, 0, 0, 0, 0}};
  const auto pixel = Project(camera, {1, 0, -0.1});
  ASSERT_TRUE(pixel.has_value());
  EXPECT_NEAR(pixel->x(), 256 + 150 * (std::numbers::pi / 2 + std::atan(0.1)), 1e-9);
  EXPECT_FALSE(Project(camera, {0, 0, -1}));
}

// 1 + 3 k s = 0 at s = 1 / 0.9: from there on the distortion comes back towards the centre.
TEST(CameraTest, NothingIsFoldedBackIntoTheImage) {
  const Camera camera = {CameraModel::kSimpleRadial, 640, 480, {500, 319.5, 239.5, -0.3}};
  EXPECT_TRUE(Project(camera, {1.05, 0, 1}));
  EXPECT_FALSE(Project(camera, {1.06, 0, 1}));
  EXPECT_FALSE(Project(camera, {1.8, 0, 1}));  // would land at the centre: 1 - 0.3 * 3.24 = 0.03
  const Camera fisheye = {
      CameraModel::kOpenCvFisheye, 640, 480, {300, 300, 320, 240, -0.3, 0, 0, 0}};
  EXPECT_TRUE(Project(fisheye, {std::sin(1.05), 0, std::cos(1.05)}));
  EXPECT_FALSE(Project(fisheye, {std::sin(1.06), 0, std::cos(1.06)}));
}

TEST(CameraTest, EquirectangularConventions) {
  const Camera camera = {CameraModel::kEquirectangular, 1024, 512, {}};
  const auto at = [&](double x, double y, double z) { return Project(camera, {x, y, z}).value(); };
  EXPECT_LT((at(0, 0, 1) - Eigen::Vector2d(511.5, 255.5)).norm(), 1e-9);   // ahead: the middle
  EXPECT_LT((at(1, 0, 0) - Eigen::Vector2d(767.5, 255.5)).norm(), 1e-9);   // right: a quarter on
  EXPECT_LT((at(-1, 0, 0) - Eigen::Vector2d(255.5, 255.5)).norm(), 1e-9);  // left
  EXPECT_NEAR(at(0, -1, 0).y(), -0.5, 1e-9);                               // up: the upper edge
  EXPECT_NEAR(at(0, 1, 0).y(), 511.5, 1e-9);                               // down: the lower edge
  EXPECT_NEAR(at(1e-9, 0, -1).x(), 1023.5, 1e-6);                          // behind: the seam
  EXPECT_NEAR(at(-1e-9, 0, -1).x(), -0.5, 1e-6);
}

TEST(CameraTest, PixelZeroIsTheCentreOfThePixel) {
  const Camera camera = {CameraModel::kPinhole, 3, 3, {1, 1, 1, 1}};
  EXPECT_EQ(Project(camera, {0, 0, 1}).value(), Eigen::Vector2d(1, 1));
  EXPECT_EQ(Project(camera, {-1, -1, 1}).value(), Eigen::Vector2d(0, 0));
}

std::string RefusalOf(const Camera& camera) {
  try {
    CheckCamera(camera);
  } catch (const MapError& error) {
    EXPECT_EQ(error.code(), ErrorCode::kBadCamera);
    return error.what();
  }
  return "none";
}

TEST(CheckCameraTest, RefusesWithTheNumberAtFault) {
  const Camera good = {CameraModel::kPinhole, 640, 480, {500, 500, 320, 240}};
  EXPECT_EQ(RefusalOf(good), "none");
  Camera bad = good;
  bad.width = 0;
  EXPECT_NE(RefusalOf(bad).find("0x480"), std::string::npos);
  bad = good;
  bad.height = 2'000'000;
  EXPECT_NE(RefusalOf(bad).find("640x2000000"), std::string::npos);
  bad = good;
  bad.params.pop_back();
  EXPECT_NE(RefusalOf(bad).find("has 4 parameters, not 3"), std::string::npos);
  bad = good;
  bad.params[1] = -5;
  EXPECT_NE(RefusalOf(bad).find("parameter 2"), std::string::npos);
  bad = good;
  bad.params[3] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_NE(RefusalOf(bad).find("parameter 4"), std::string::npos);
  bad = good;
  bad.model = static_cast<CameraModel>(77);
  EXPECT_NE(RefusalOf(bad).find("77"), std::string::npos);
}

TEST(CameraTest, UnknownNamesAreNothing) {
  EXPECT_FALSE(CameraModelByName("FISHEYE_OF_DOOM"));
  EXPECT_FALSE(CameraModelByName(""));
  EXPECT_FALSE(CameraModelByName("pinhole"));
}

}  // namespace
}  // namespace waystone
