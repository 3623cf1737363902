// SPDX-License-Identifier: Apache-2.0
#include "cli/pose_file.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <sstream>
#include <utility>

#include "cli/csv_file.h"
#include "core/base/error.h"

namespace waystone {
namespace {

namespace fs = std::filesystem;

constexpr double kSameTime_s = 0.02;
constexpr size_t kTumNumbers = 8;
constexpr size_t kKittiNumbers = 12;
constexpr size_t kColmapFields = 10;

Eigen::Isometry3d PoseOf(const Eigen::Vector3d& at, const Eigen::Quaterniond& rotation) {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.translation() = at;
  pose.linear() = rotation.normalized().toRotationMatrix();
  return pose;
}

std::optional<size_t> FirstColumn(const CsvFile& file, std::initializer_list<const char*> names) {
  for (const char* name : names) {
    if (const auto column = file.Column(name)) return column;
  }
  return std::nullopt;
}

// The columns of a name; nothing unless all are there.
template <size_t kCount>
std::optional<std::array<size_t, kCount>> Columns(const CsvFile& file,
                                                  const std::array<const char*, kCount>& names) {
  std::array<size_t, kCount> columns{};
  for (size_t i = 0; i < kCount; ++i) {
    const auto column = file.Column(names[i]);
    if (!column) return std::nullopt;
    columns[i] = *column;
  }
  return columns;
}

std::vector<FilePose> ReadCsvPoses(const fs::path& path) {
  const CsvFile file(path);
  const auto at = Columns<3>(file, {"x", "y", "z"});
  if (!at) file.Fail(1, "the header has no columns x, y and z");
  const auto quaternion = Columns<4>(file, {"qw", "qx", "qy", "qz"});
  const auto name = FirstColumn(file, {"image", "keyframe", "id"});
  const auto frame = file.Column("frame");
  const auto time = file.Column("time_s");
  std::vector<FilePose> poses;
  for (const CsvFile::Row& row : file.rows()) {
    if (row.cells[(*at)[0]].empty()) continue;
    const auto number = [&](size_t column) { return file.Number(row, column); };
    FilePose pose;
    if (name) pose.name = row.cells[*name];
    if (time && !name && !frame) pose.time_s = number(*time);
    pose.number = frame ? static_cast<int>(number(*frame)) : static_cast<int>(poses.size());
    pose.pose.has_rotation = quaternion.has_value();
    const Eigen::Quaterniond rotation =
        quaternion ? Eigen::Quaterniond(number((*quaternion)[0]), number((*quaternion)[1]),
                                        number((*quaternion)[2]), number((*quaternion)[3]))
                   : Eigen::Quaterniond::Identity();
    pose.pose.world_from_camera =
        PoseOf({number((*at)[0]), number((*at)[1]), number((*at)[2])}, rotation);
    poses.push_back(std::move(pose));
  }
  return poses;
}

// A line's fields as numbers; nothing where one isn't.
std::optional<std::vector<double>> NumbersOf(const std::vector<std::string>& fields) {
  std::vector<double> numbers;
  for (const std::string& field : fields) {
    std::istringstream text(field);
    double number = 0;
    if (!(text >> number) || !text.eof() || !std::isfinite(number)) return std::nullopt;
    numbers.push_back(number);
  }
  return numbers;
}

FilePose TumPose(const std::vector<double>& n) {
  FilePose pose;
  pose.time_s = n[0];
  pose.pose = {PoseOf({n[1], n[2], n[3]}, {n[7], n[4], n[5], n[6]}), true};
  return pose;
}

FilePose KittiPose(const std::vector<double>& n) {
  FilePose pose;
  const Eigen::Map<const Eigen::Matrix<double, 3, 4, Eigen::RowMajor>> matrix(n.data());
  pose.pose = {PoseOf(matrix.col(3), Eigen::Quaterniond(Eigen::Matrix3d(matrix.leftCols<3>()))),
               true};
  return pose;
}

// "IMAGE_ID QW QX QY QZ TX TY TZ CAMERA_ID NAME", camera_from_world; a name may have blanks.
std::optional<FilePose> ColmapPose(const std::vector<std::string>& fields) {
  if (fields.size() < kColmapFields) return std::nullopt;
  const auto n = NumbersOf({fields.begin(), fields.begin() + 9});
  if (!n) return std::nullopt;
  FilePose pose;
  pose.pose = {PoseOf({(*n)[5], (*n)[6], (*n)[7]}, {(*n)[1], (*n)[2], (*n)[3], (*n)[4]}).inverse(),
               true};
  pose.name = fields[9];
  for (size_t i = kColmapFields; i < fields.size(); ++i) pose.name += " " + fields[i];
  return pose;
}

class TextPoses {
 public:
  explicit TextPoses(const fs::path& path) : path_(path), in_(path) {
    if (in_) return;
    throw MapError(ErrorCode::kFileUnreadable,
                   path.string() + " can't be read; check the path and the permissions");
  }

  std::vector<FilePose> Read() {
    std::vector<FilePose> poses;
    std::string text;
    for (int line = 1; std::getline(in_, text); ++line) {
      std::istringstream words(text);
      const std::vector<std::string> fields{std::istream_iterator<std::string>(words), {}};
      if (std::exchange(skip_, false) || fields.empty() || fields[0].starts_with('#')) continue;
      FilePose pose = Parse(fields, line);
      pose.number = static_cast<int>(poses.size());
      poses.push_back(std::move(pose));
    }
    return poses;
  }

 private:
  FilePose Parse(const std::vector<std::string>& fields, int line) {
    if (const auto numbers = NumbersOf(fields)) {
      if (numbers->size() == kTumNumbers) return TumPose(*numbers);
      if (numbers->size() == kKittiNumbers) return KittiPose(*numbers);
    }
    if (auto pose = ColmapPose(fields)) {
      skip_ = true;  // the line of its points
      return *pose;
    }
    throw MapError(ErrorCode::kBadRequest,
                   path_.string() + ", line " + std::to_string(line) +
                       ": not a pose; expected a line of a TUM trajectory (8 numbers), of KITTI "
                       "poses (12 numbers) or of COLMAP's images.txt");
  }

  fs::path path_;
  std::ifstream in_;
  bool skip_ = false;
};

}  // namespace

std::vector<FilePose> ReadPoseFile(const fs::path& path) {
  std::vector<FilePose> poses =
      path.extension() == ".csv" ? ReadCsvPoses(path) : TextPoses(path).Read();
  if (!poses.empty()) return poses;
  throw MapError(ErrorCode::kBadRequest, path.string() + " has no poses; expected one a line");
}

ImagePoses::ImagePoses(std::vector<FilePose> poses) : poses_(std::move(poses)) {
  for (const FilePose& pose : poses_) {
    if (!pose.name.empty()) by_name_.emplace(pose.name, &pose.pose);
  }
}

const TruePose* ImagePoses::FindNamed(const std::string& name) const {
  const auto find = [&](const std::string& part) -> const TruePose* {
    const auto found = by_name_.find(part);
    return found == by_name_.end() ? nullptr : found->second;
  };
  for (size_t from = 0; from != std::string::npos;) {  // with fewer and fewer folders
    if (const TruePose* pose = find(name.substr(from))) return pose;
    const size_t slash = name.find('/', from);
    from = slash == std::string::npos ? slash : slash + 1;
  }
  return find(fs::path(name).stem().string());
}

const TruePose* ImagePoses::Find(const std::string& name, const std::optional<double>& time_s,
                                 int number) const {
  if (!by_name_.empty()) return FindNamed(name);
  const auto found = std::ranges::find_if(poses_, [&](const FilePose& pose) {
    if (pose.time_s && time_s) return std::abs(*pose.time_s - *time_s) <= kSameTime_s;
    return pose.number == number;
  });
  return found == poses_.end() ? nullptr : &found->pose;
}

}  // namespace waystone
