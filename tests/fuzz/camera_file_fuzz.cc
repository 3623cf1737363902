// SPDX-License-Identifier: Apache-2.0
#include "builder/sources/source.h"
#include "tests/fuzz/camera_yaml.h"
#include "tests/fuzz/fuzz_targets.h"

namespace waystone {
namespace {

// The rays through the image's corners and its middle are finite, and so are their pixels.
void CheckRays(const Camera& camera) {
  const double right = camera.width - 1;
  const double bottom = camera.height - 1;
  for (const Eigen::Vector2d& pixel :
       {Eigen::Vector2d(0, 0), Eigen::Vector2d(right, bottom), Eigen::Vector2d(right / 2, 0)}) {
    const Eigen::Vector3d ray = Unproject(camera, pixel);
    Require(ray.allFinite(), "the ray through a pixel is finite");
    const auto back = Project(camera, ray);
    Require(!back || back->allFinite(), "the pixel of a ray is finite");
  }
}

bool CheckCameraFile(const std::filesystem::path& path) {
  const auto camera = ReadOrRefuse([&] { return ReadCameraFile(path); });
  if (!camera) return false;
  CheckRays(*camera);
  const auto written = WriteInput("written.yaml", CameraYaml(*camera, ""));
  const Camera again = ReadBack([&] { return ReadCameraFile(written); }, "a camera");
  Require(again == *camera, "a camera is written and read to the same");
  return true;
}

}  // namespace

// As text and as COLMAP's binary file. A camera is sound, and written in our own format it is read
// to the same.
bool FuzzCameraFile(FuzzInput input) {
  const bool text = CheckCameraFile(WriteInput("camera.yaml", TextOf(input)));
  const bool binary = CheckCameraFile(WriteInput("cameras.bin", TextOf(input)));
  return text || binary;
}

}  // namespace waystone
