// SPDX-License-Identifier: Apache-2.0
#include "cli/files/colmap_images.h"

#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <iterator>
#include <string>

#include "core/base/error.h"

namespace waystone {
namespace {

namespace fs = std::filesystem;

static_assert(std::endian::native == std::endian::little);

constexpr size_t kPointBytes = 24;  // x, y, id

// The bytes of a file from front to back.
class BinaryReader {
 public:
  explicit BinaryReader(const fs::path& path) : path_(path) {
    std::ifstream in(path, std::ios::binary);
    if (!in) {
      throw MapError(ErrorCode::kFileUnreadable,
                     path.string() + " can't be read; check the path and the permissions");
    }
    bytes_.assign(std::istreambuf_iterator<char>(in), {});
  }

  template <class Value>
  Value Take() {
    Value value;
    std::memcpy(&value, Skip(sizeof(value)), sizeof(value));
    return value;
  }

  std::string TakeText() {
    const size_t end = bytes_.find('\0', at_);
    if (end == std::string::npos) Fail("is cut");
    std::string text = bytes_.substr(at_, end - at_);
    at_ = end + 1;
    return text;
  }

  const char* Skip(size_t bytes) {
    if (bytes > bytes_.size() - at_) Fail("is cut");
    at_ += bytes;
    return bytes_.data() + at_ - bytes;
  }

  // Things of at least this many bytes each that can still follow.
  size_t Room(size_t bytes) const { return (bytes_.size() - at_) / bytes; }

  [[noreturn]] void Fail(const std::string& what) const {
    throw MapError(ErrorCode::kBadRequest, path_.string() + " " + what +
                                               " or isn't COLMAP's images.bin; export the model "
                                               "again, as text if in doubt");
  }

 private:
  fs::path path_;
  std::string bytes_;
  size_t at_ = 0;
};

FilePose TakeImage(BinaryReader& reader) {
  reader.Take<uint32_t>();  // id
  Eigen::Vector4d q;        // w x y z
  for (double& value : q) value = reader.Take<double>();
  Eigen::Vector3d t;
  for (double& value : t) value = reader.Take<double>();
  reader.Take<uint32_t>();  // camera
  FilePose pose;
  pose.name = reader.TakeText();
  const auto points = reader.Take<uint64_t>();
  if (points > reader.Room(kPointBytes)) reader.Fail("is cut");
  reader.Skip(points * kPointBytes);
  if (!q.allFinite() || !t.allFinite() || q.norm() == 0) reader.Fail("has a pose that is no pose");
  Eigen::Isometry3d camera_from_world = Eigen::Isometry3d::Identity();
  camera_from_world.linear() =
      Eigen::Quaterniond(q[0], q[1], q[2], q[3]).normalized().toRotationMatrix();
  camera_from_world.translation() = t;
  pose.pose = {camera_from_world.inverse(), true};
  return pose;
}

}  // namespace

std::vector<FilePose> ReadColmapImages(const fs::path& path) {
  BinaryReader reader(path);
  const auto count = reader.Take<uint64_t>();
  if (count > reader.Room(kPointBytes)) reader.Fail("is cut");
  std::vector<FilePose> poses;
  for (uint64_t i = 0; i < count; ++i) {
    poses.push_back(TakeImage(reader));
    poses.back().number = static_cast<int>(i);
  }
  return poses;
}

}  // namespace waystone
