// SPDX-License-Identifier: Apache-2.0
#include "core/geometry/decompose_homography.h"

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/calib3d.hpp>
#include <opencv2/core/eigen.hpp>

#include "core/geometry/rotation.h"

namespace waystone {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

double DrawBetween(double low, double high) {
  return low + (high - low) * *rc::gen::inRange(0, 1'000'001) / 1e6;
}

Vector3d DrawVector(double most) {
  return {DrawBetween(-most, most), DrawBetween(-most, most), DrawBetween(-most, most)};
}

// A camera that turned and moved beside a plane ahead of it, without passing through it.
PlaneMotion DrawMotion() {
  PlaneMotion motion;
  motion.b_from_a = RotationByVector(DrawVector(0.6));
  motion.normal = Vector3d(DrawBetween(-1, 1), DrawBetween(-1, 1), 1).normalized();
  motion.translation = DrawVector(0.5);
  RC_PRE(motion.translation.norm() > 0.02);
  return motion;
}

Matrix3d HomographyOf(const PlaneMotion& motion) {
  return motion.b_from_a + motion.translation * motion.normal.transpose();
}

double DifferenceOf(const PlaneMotion& m, const PlaneMotion& n) {
  const double sign = m.normal.dot(n.normal) < 0 ? -1 : 1;
  return (m.b_from_a - n.b_from_a).norm() + (m.normal - sign * n.normal).norm() +
         (m.translation - sign * n.translation).norm();
}

TEST(DecomposeHomography, GivesTheTrueMotionBack) {
  EXPECT_TRUE(rc::check("one of the two is the motion, at any scale", [] {
    const PlaneMotion truth = DrawMotion();
    const double scale = DrawBetween(0.1, 10);
    const auto motions = DecomposeHomography(scale * HomographyOf(truth));
    RC_ASSERT(motions.size() == 2u);
    RC_ASSERT(std::min(DifferenceOf(motions[0], truth), DifferenceOf(motions[1], truth)) < 1e-6);
  }));
}

TEST(DecomposeHomography, EachMotionComposesToTheHomography) {
  EXPECT_TRUE(rc::check("R + t n^T is H, and R a rotation", [] {
    const Matrix3d h = HomographyOf(DrawMotion());
    for (const PlaneMotion& motion : DecomposeHomography(h)) {
      RC_ASSERT((HomographyOf(motion) - h).norm() < 1e-9);
      RC_ASSERT((motion.b_from_a * motion.b_from_a.transpose()).isIdentity(1e-9));
      RC_ASSERT(motion.b_from_a.determinant() > 0);
      RC_ASSERT(std::abs(motion.normal.norm() - 1) < 1e-9);
    }
  }));
}

// An implementation of another form of the solution (Malis and Vargas 2007), which divides by 0
// where a minor of H^T H - I is 0: NaN there.
TEST(DecomposeHomography, AgreesWithOpenCv) {
  EXPECT_TRUE(rc::check("each of OpenCV's motions is one of ours", [] {
    const Matrix3d h = HomographyOf(DrawMotion());
    cv::Mat matrix;
    cv::eigen2cv(h, matrix);
    std::vector<cv::Mat> rotations;
    std::vector<cv::Mat> translations;
    std::vector<cv::Mat> normals;
    cv::decomposeHomographyMat(matrix, cv::Mat::eye(3, 3, CV_64F), rotations, translations,
                               normals);
    const auto motions = DecomposeHomography(h);
    RC_ASSERT(rotations.size() == 4u && motions.size() == 2u);
    for (size_t i = 0; i < rotations.size(); ++i) {
      PlaneMotion theirs;
      cv::cv2eigen(rotations[i], theirs.b_from_a);
      cv::cv2eigen(translations[i], theirs.translation);
      cv::cv2eigen(normals[i], theirs.normal);
      const double least =
          std::min(DifferenceOf(motions[0], theirs), DifferenceOf(motions[1], theirs));
      RC_ASSERT(std::isnan(least) || least < 1e-4);
    }
  }));
}

TEST(DecomposeHomography, OfAPureRotationIsOneMotionWithoutANormal) {
  const Matrix3d r = RotationByVector({0.2, -0.4, 0.1});
  for (const double scale : {1.0, 0.2, 30.0}) {
    const auto motions = DecomposeHomography(scale * r, 1e-9);
    ASSERT_EQ(motions.size(), 1u);
    EXPECT_TRUE(motions[0].b_from_a.isApprox(r, 1e-12));
    EXPECT_EQ(motions[0].normal, Vector3d::Zero());
    EXPECT_EQ(motions[0].translation, Vector3d::Zero());
  }
  const Matrix3d nearly = r + 1e-5 * Vector3d::UnitX() * Vector3d::UnitZ().transpose();
  EXPECT_EQ(DecomposeHomography(nearly, 1e-3).size(), 1u);
  EXPECT_EQ(DecomposeHomography(nearly, 1e-9).size(), 2u);
}

TEST(DecomposeHomography, DegenerateInputNeverGivesNaN) {
  EXPECT_TRUE(DecomposeHomography(Matrix3d::Zero()).empty());
  EXPECT_TRUE(DecomposeHomography(Matrix3d::Constant(2)).empty()) << "rank one";
  EXPECT_TRUE(
      DecomposeHomography(Matrix3d::Constant(std::numeric_limits<double>::quiet_NaN())).empty());
  EXPECT_TRUE(
      DecomposeHomography(Matrix3d::Constant(std::numeric_limits<double>::infinity())).empty());
  EXPECT_TRUE(rc::check("nothing, or all finite", [] {
    Matrix3d h;
    for (int k = 0; k < 9; ++k) h(k / 3, k % 3) = *rc::gen::inRange(-2, 3);
    for (const PlaneMotion& motion : DecomposeHomography(h)) {
      RC_ASSERT(motion.b_from_a.allFinite() && motion.translation.allFinite() &&
                motion.normal.allFinite());
    }
  }));
}

}  // namespace
}  // namespace waystone
