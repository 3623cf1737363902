// SPDX-License-Identifier: Apache-2.0
#include "core/camera/rig.h"

#include <gtest/gtest.h>

#include "core/base/error.h"

namespace waystone {
namespace {

TEST(CubeRig, SeesEveryDirectionOnce) {
  const Rig rig = CubeRig(64);
  CheckRig(rig);
  for (const Eigen::Vector3d& ray :
       {Eigen::Vector3d(0.1, 0.2, 1), Eigen::Vector3d(1, -0.3, 0.2), Eigen::Vector3d(0.2, 0.1, -1),
        Eigen::Vector3d(-1, 0.2, 0.4), Eigen::Vector3d(0.3, -1, 0.2),
        Eigen::Vector3d(0.3, 1, -0.2)}) {
    int seen = 0;
    for (const RigCamera& camera : rig.cameras) {
      const auto pixel = Project(camera.camera, camera.rig_from_camera.inverse() * ray);
      seen += pixel && pixel->minCoeff() >= -0.5 && pixel->maxCoeff() < 63.5 ? 1 : 0;
    }
    EXPECT_EQ(seen, 1) << ray.transpose();
  }
}

TEST(CubeRig, FacesLookWhereTheirNamesSay) {
  const Rig rig = CubeRig(10);
  const auto forward = [&](int i) -> Eigen::Vector3d {
    return rig.cameras[i].rig_from_camera * Eigen::Vector3d::UnitZ();
  };
  EXPECT_EQ(rig.cameras[1].name, "right");
  EXPECT_TRUE(forward(1).isApprox(Eigen::Vector3d::UnitX()));
  EXPECT_EQ(rig.cameras[2].name, "back");
  EXPECT_TRUE(forward(2).isApprox(-Eigen::Vector3d::UnitZ()));
  EXPECT_EQ(rig.cameras[4].name, "up");
  EXPECT_TRUE(forward(4).isApprox(-Eigen::Vector3d::UnitY()));
}

std::string RigRefusalOf(const Rig& rig) {
  try {
    CheckRig(rig);
  } catch (const MapError& error) {
    EXPECT_EQ(error.code(), ErrorCode::kBadCamera);
    return error.what();
  }
  return "";
}

TEST(CheckRig, RefusesWhatIsNoRig) {
  EXPECT_NE(RigRefusalOf({}).find("a rig of 0 cameras"), std::string::npos);
  Rig twice = CubeRig(8);
  twice.cameras[1].name = "front";
  EXPECT_NE(RigRefusalOf(twice).find("'front' is duplicated"), std::string::npos);
  Rig skewed = CubeRig(8);
  skewed.cameras[2].rig_from_camera.linear() *= 1.01;
  EXPECT_NE(RigRefusalOf(skewed).find("camera 'back'"), std::string::npos);
  Rig flat = CubeRig(8);
  flat.cameras[3].camera.params[0] = 0;
  EXPECT_NE(RigRefusalOf(flat).find("camera 'left'"), std::string::npos);
  EXPECT_THROW(CubeRig(0), MapError);
}

TEST(CheckImageSize, NamesBothSizes) {
  const RigCamera camera = CubeRig(8).cameras[0];
  CheckImageSize(camera, 8, 8);
  try {
    CheckImageSize(camera, 9, 8);
    ADD_FAILURE();
  } catch (const MapError& error) {
    EXPECT_EQ(error.code(), ErrorCode::kBadImage);
    EXPECT_NE(std::string(error.what()).find("9x8"), std::string::npos);
    EXPECT_NE(std::string(error.what()).find("8x8"), std::string::npos);
  }
}

}  // namespace
}  // namespace waystone
