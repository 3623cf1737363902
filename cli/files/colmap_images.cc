// SPDX-License-Identifier: Apache-2.0
#include "cli/files/colmap_images.h"

#include <cstdint>
#include <string>

#include "cli/files/map_file.h"
#include "core/base/byte_reader.h"

namespace waystone {
namespace {

namespace fs = std::filesystem;

constexpr int64_t kMaxModelBytes = 16'000'000'000;  // some 60,000 images of 10,000 points
constexpr size_t kPointBytes = 24;                  // x, y, id
constexpr size_t kImageBytes = 73;                  // without a name and points

MapError NotImages(const fs::path& path, const std::string& what) {
  return {ErrorCode::kBadRequest, path.string() + " " + what +
                                      " or isn't COLMAP's images.bin; export the model again, as "
                                      "text if in doubt"};
}

FilePose TakeImage(ByteReader& reader, const fs::path& path) {
  reader.Take<uint32_t>();  // id
  Eigen::Vector4d q;        // w x y z
  for (double& value : q) value = reader.Take<double>();
  Eigen::Vector3d t;
  for (double& value : t) value = reader.Take<double>();
  reader.Take<uint32_t>();  // camera
  FilePose pose;
  pose.name = reader.TakeText();
  reader.Skip(reader.TakeCount(kPointBytes) * kPointBytes);
  Eigen::Isometry3d camera_from_world = Eigen::Isometry3d::Identity();
  // Stable: a quaternion of a length far from 1 must still give a rotation.
  const Eigen::Vector4d unit = q.stableNormalized().normalized();
  camera_from_world.linear() =
      Eigen::Quaterniond(unit[0], unit[1], unit[2], unit[3]).toRotationMatrix();
  camera_from_world.translation() = t;
  pose.pose = {camera_from_world.inverse(), true};
  if (q.isZero(0) || !q.allFinite() || !IsPose(pose.pose)) {
    throw NotImages(path, "has a pose that is no pose");
  }
  return pose;
}

}  // namespace

std::vector<FilePose> ReadColmapImages(const fs::path& path) {
  const std::vector<uint8_t> bytes = ReadBytes(path, "COLMAP's images.bin", kMaxModelBytes);
  ByteReader reader(bytes, NotImages(path, "is cut"));
  const uint64_t count = reader.TakeCount(kImageBytes);
  std::vector<FilePose> poses;
  for (uint64_t i = 0; i < count; ++i) {
    poses.push_back(TakeImage(reader, path));
    poses.back().number = static_cast<int>(i);
  }
  return poses;
}

}  // namespace waystone
