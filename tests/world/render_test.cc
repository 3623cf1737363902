// SPDX-License-Identifier: Apache-2.0
#include "world/render.h"

#include <gtest/gtest.h>
#include <tbb/parallel_for.h>

#include <numbers>
#include <opencv2/imgproc.hpp>

#include "core/base/check.h"
#include "core/base/error.h"
#include "tests/world/test_worlds.h"

namespace waystone {
namespace {

cv::Mat GreyOf(const RenderOptions& options) {
  return Render(TwoRoomWorld(), SmallCamera(), InWestRoom(), options).grey;
}

double MeanOf(const cv::Mat& image) { return cv::mean(image)[0]; }

// How much neighbouring pixels differ.
double Sharpness(const cv::Mat& image) {
  cv::Mat edges;
  cv::Laplacian(image, edges, CV_32F);
  return cv::norm(edges, cv::NORM_L1) / static_cast<double>(image.total());
}

TEST(Render, GivesPlaneAndDepthOfEveryPixel) {
  const World& world = TwoRoomWorld();
  const Camera camera = SmallCamera();
  RenderOptions options;
  options.depth = true;
  const Eigen::Isometry3d pose = InWestRoom(0.3, 0.1);
  const RenderedFrame frame = Render(world, camera, pose, options);
  ASSERT_EQ(frame.grey.type(), CV_8UC1);
  ASSERT_EQ(frame.plane_ids.type(), CV_16UC1);
  ASSERT_EQ(frame.depth.type(), CV_32FC1);
  for (int y = 0; y < camera.height; ++y) {
    for (int x = 0; x < camera.width; ++x) {
      const WorldPlane& plane = world.PlaneById(frame.plane_ids.at<uint16_t>(y, x));
      EXPECT_EQ(world.FaceById(frame.face_ids.at<uint16_t>(y, x)).plane, plane.id);
      const Eigen::Vector3d ray = Unproject(camera, {x, y});
      const double t = plane.normal.dot(plane.origin - pose.translation()) /
                       plane.normal.dot(pose.linear() * ray);
      ASSERT_NEAR(frame.depth.at<float>(y, x), t * ray.z(), 1e-3) << x << " " << y;
    }
  }
}

TEST(Render, SameSeedSameBytesOnAnyThreadAndOtherSeedOther) {
  RenderOptions options;
  options.noise_sigma = 3.0;
  options.lens_blur_px = 0.8;
  const cv::Mat first = GreyOf(options);
  const World again(TwoRooms(), TestOptions());
  std::vector<cv::Mat> images(4);
  tbb::parallel_for(size_t{0}, images.size(), [&](size_t i) {
    images[i] = Render(again, SmallCamera(), InWestRoom(), options).grey;
  });
  for (const cv::Mat& image : images) EXPECT_TRUE(SameBytes(image, first));

  WorldOptions other = TestOptions();
  other.seed = 2;
  const cv::Mat unlike = Render(World(TwoRooms(), other), SmallCamera(), InWestRoom()).grey;
  EXPECT_GT(cv::norm(unlike, first, cv::NORM_L1) / first.total(), 10.0);
}

TEST(Render, NoiseHasTheAskedSigmaAndItsOwnSeed) {
  const cv::Mat clean = GreyOf({});
  RenderOptions options;
  options.noise_sigma = 5.0;
  const cv::Mat noisy = GreyOf(options);
  const cv::Mat inside = (clean > 30) & (clean < 225);
  cv::Mat difference;
  cv::subtract(noisy, clean, difference, inside, CV_32F);
  cv::Scalar mean;
  cv::Scalar sigma;
  cv::meanStdDev(difference, mean, sigma, inside);
  EXPECT_NEAR(mean[0], 0.0, 0.2);
  EXPECT_NEAR(sigma[0], 5.0, 0.25);
  EXPECT_TRUE(SameBytes(noisy, GreyOf(options)));
  options.noise_seed = 1;
  EXPECT_FALSE(SameBytes(noisy, GreyOf(options)));
}

TEST(Render, ExposureScalesTheLight) {
  RenderOptions options;
  options.exposure_gain = 0.5;
  EXPECT_NEAR(MeanOf(GreyOf(options)), 0.5 * MeanOf(GreyOf({})), 0.6);
  options.exposure_gain = 20.0;
  EXPECT_GT(cv::countNonZero(GreyOf(options) == 255), 160 * 120 * 9 / 10);
}

TEST(Render, LensAndMotionBlurKeepTheLightAndTakeTheDetail) {
  const cv::Mat sharp = GreyOf({});
  RenderOptions lens;
  lens.lens_blur_px = 1.5;
  RenderOptions motion;
  motion.motion_samples = 8;
  motion.motion.linear() = Eigen::AngleAxisd(0.06, Eigen::Vector3d::UnitY()).toRotationMatrix();
  for (const RenderOptions& options : {lens, motion}) {
    const cv::Mat blurred = GreyOf(options);
    EXPECT_NEAR(MeanOf(blurred), MeanOf(sharp), 3.0);
    EXPECT_LT(Sharpness(blurred), 0.6 * Sharpness(sharp));
  }
  motion.motion.setIdentity();
  EXPECT_LE(cv::norm(GreyOf(motion), sharp, cv::NORM_INF), 1.0) << "a still camera has no blur";
}

TEST(Render, PartsOfAMotionAddUp) {
  Eigen::Isometry3d motion = Eigen::Isometry3d::Identity();
  motion.linear() = Eigen::AngleAxisd(0.4, Eigen::Vector3d(1, 2, 3).normalized()).matrix();
  EXPECT_TRUE((PartOfMotion(motion, 0.25) * PartOfMotion(motion, 0.75)).isApprox(motion, 1e-12));
  EXPECT_TRUE(PartOfMotion(motion, 0.0).isApprox(Eigen::Isometry3d::Identity()));
}

// Wherever a pixel of `camera` looks, the reference picture shows the same there.
void ExpectSameSight(const RenderedFrame& frame, const Camera& camera,
                     const Eigen::Matrix3d& reference_from_camera, const RenderedFrame& reference,
                     const Camera& reference_camera) {
  int compared = 0;
  int agree = 0;
  for (int y = 0; y < camera.height; y += 3) {
    for (int x = 0; x < camera.width; x += 3) {
      const auto pixel =
          Project(reference_camera, reference_from_camera * Unproject(camera, {x, y}));
      ASSERT_TRUE(pixel);
      const cv::Point at(static_cast<int>(std::lround(pixel->x())),
                         static_cast<int>(std::lround(pixel->y())));
      if (!cv::Rect({0, 0}, reference.plane_ids.size()).contains(at)) continue;
      ++compared;
      agree += frame.plane_ids.at<uint16_t>(y, x) == reference.plane_ids.at<uint16_t>(at);
    }
  }
  EXPECT_GT(compared, 100);
  EXPECT_GT(agree, 0.97 * compared);
}

TEST(Render, RigFacesAndPinholeAgreeWithThePanorama) {
  const World& world = TwoRoomWorld();
  const Eigen::Isometry3d pose = InWestRoom(0.4);
  const Camera panorama_camera = PanoramaCamera(512);
  const RenderedFrame panorama = Render(world, panorama_camera, pose);
  for (const RigFace& face : SixFaceRig(96)) {
    SCOPED_TRACE(face.name);
    EXPECT_NEAR(face.rig_from_camera.determinant(), 1.0, 1e-12);
    Eigen::Isometry3d face_pose = pose;
    face_pose.linear() = pose.linear() * face.rig_from_camera;
    ExpectSameSight(Render(world, face.camera, face_pose), face.camera, face.rig_from_camera,
                    panorama, panorama_camera);
  }
  ExpectSameSight(Render(world, SmallCamera(), pose), SmallCamera(), Eigen::Matrix3d::Identity(),
                  panorama, panorama_camera);
}

TEST(Render, RigLooksWhereItsNamesSay) {
  const auto rig = SixFaceRig(64);
  const std::array<Eigen::Vector3d, 6> forward = {Eigen::Vector3d{0, 0, 1},  {1, 0, 0},  {0, 0, -1},
                                                  Eigen::Vector3d{-1, 0, 0}, {0, -1, 0}, {0, 1, 0}};
  for (size_t i = 0; i < rig.size(); ++i) {
    EXPECT_TRUE(rig[i].rig_from_camera.col(2).isApprox(forward[i])) << rig[i].name;
    EXPECT_NEAR(rig[i].camera.params[0], 32.0, 1e-9);
  }
}

TEST(Render, DistantTexturesDoNotAlias) {
  // A small move of the camera must not make far walls flicker.
  const World& world = TwoRoomWorld();
  const Camera wide = PinholeCamera(160, 120, 2.4);
  const Eigen::Isometry3d a = WorldFromCamera({1.0, 2.0, 1.4}, 0.0);
  const Eigen::Isometry3d b = WorldFromCamera({1.0, 2.0004, 1.4}, 0.0);
  const cv::Mat first = Render(world, wide, a).grey;
  const cv::Mat second = Render(world, wide, b).grey;
  EXPECT_LT(cv::norm(first, second, cv::NORM_L1) / first.total(), 0.5);
}

TEST(Render, RefusesBadOptionsCamerasAndPoses) {
  RenderOptions options;
  options.noise_sigma = -1.0;
  EXPECT_THROW(GreyOf(options), MapError);
  options = {};
  options.motion_samples = 0;
  EXPECT_THROW(GreyOf(options), MapError);
  EXPECT_THROW(Renderer(Camera{}), MapError);
  EXPECT_THROW(PanoramaCamera(511), MapError);
  EXPECT_THROW(PinholeCamera(640, 480, 3.2), MapError);
  EXPECT_THROW(SixFaceRig(0), MapError);
  const Eigen::Isometry3d in_wall = WorldFromCamera({0.1, 0.1, 1.0}, 0.0);
  EXPECT_THROW(Render(TwoRoomWorld(), SmallCamera(), in_wall), CheckFailure);
}

}  // namespace
}  // namespace waystone
