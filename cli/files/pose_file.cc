// SPDX-License-Identifier: Apache-2.0
#include "cli/files/pose_file.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <utility>

#include "api/tum_pose.h"
#include "cli/files/csv_file.h"
#include "core/base/error.h"
#include "core/base/text.h"

namespace waystone {
namespace {

namespace fs = std::filesystem;

constexpr double kSameTime_s = 0.02;
constexpr size_t kKittiNumbers = 12;
constexpr size_t kColmapFields = 10;

Eigen::Isometry3d PoseOf(const Eigen::Vector3d& at, const Eigen::Quaterniond& rotation) {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.translation() = at;
  // Stable: a quaternion far from unit length is no reason for one that isn't a rotation.
  pose.linear() = Eigen::Quaterniond(rotation.coeffs().stableNormalized()).toRotationMatrix();
  return pose;
}

int FrameNumber(const CsvFile& file, const CsvFile::Row& row, size_t column) {
  constexpr double kMost = 1e9;
  const double number = file.Number(row, column);
  if (number != std::floor(number) || std::abs(number) > kMost) {
    file.Fail(row.line, "frame is " + row.cells[column] + "; it must be an integer");
  }
  return static_cast<int>(number);
}

std::optional<size_t> FirstColumn(const CsvFile& file, std::initializer_list<const char*> names) {
  for (const char* name : names) {
    if (const auto column = file.Column(name)) return column;
  }
  return std::nullopt;
}

std::vector<FilePose> ReadCsvPoses(const fs::path& path) {
  const CsvFile file(path);
  const auto columns = PoseColumns::Find(file);
  if (!columns) file.Fail(1, "the header has no columns x, y and z");
  const auto name = FirstColumn(file, {"image", "keyframe", "id"});
  const auto frame = file.Column("frame");
  const auto time = file.Column("time_s");
  std::vector<FilePose> poses;
  for (const CsvFile::Row& row : file.rows()) {
    const std::optional<TruePose> read = columns->Read(file, row);
    if (!read) continue;
    FilePose pose;
    if (name) pose.name = row.cells[*name];
    if (time && !name && !frame) pose.time_s = file.Number(row, *time);
    pose.number = frame ? FrameNumber(file, row, *frame) : static_cast<int>(poses.size());
    pose.pose = *read;
    poses.push_back(std::move(pose));
  }
  return poses;
}

// A line's fields as numbers; nothing where one isn't.
std::optional<std::vector<double>> ParseNumbers(const std::vector<std::string>& fields) {
  std::vector<double> numbers;
  for (const std::string& field : fields) {
    const std::optional<double> number = ToNumber(field);
    if (!number || !std::isfinite(*number)) return std::nullopt;
    numbers.push_back(*number);
  }
  return numbers;
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
  const auto n = ParseNumbers({fields.begin(), fields.begin() + 9});
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
      const std::vector<std::string> fields = Words(text);
      if (std::exchange(skip_, false) || fields.empty() || fields[0].starts_with('#')) continue;
      FilePose pose = Parse(text, fields, line);
      pose.number = static_cast<int>(poses.size());
      poses.push_back(std::move(pose));
    }
    return poses;
  }

 private:
  std::optional<FilePose> AnyPose(const std::string& text, const std::vector<std::string>& fields) {
    if (const auto tum = ParseTumPose(text)) {
      return FilePose{{}, tum->time_s, 0, {PoseOf(tum->position, tum->rotation), true}};
    }
    const auto numbers = ParseNumbers(fields);
    if (numbers && numbers->size() == kKittiNumbers) return KittiPose(*numbers);
    std::optional<FilePose> pose = ColmapPose(fields);
    skip_ = pose.has_value();  // the line of its points
    return pose;
  }

  FilePose Parse(const std::string& text, const std::vector<std::string>& fields, int line) {
    if (auto pose = AnyPose(text, fields);
        pose && pose->pose.world_from_camera.matrix().allFinite()) {
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

std::optional<PoseColumns> PoseColumns::Find(const CsvFile& file) {
  const std::array x{file.Column("x"), file.Column("y"), file.Column("z")};
  const std::array q{file.Column("qw"), file.Column("qx"), file.Column("qy"), file.Column("qz")};
  const auto is_there = [](const std::optional<size_t>& column) { return column.has_value(); };
  if (std::ranges::none_of(x, is_there)) return std::nullopt;
  if (!std::ranges::all_of(x, is_there)) {
    file.Fail(1, "the header must have all of the columns x, y and z, or none");
  }
  PoseColumns columns;
  columns.position_ = {*x[0], *x[1], *x[2]};
  if (std::ranges::all_of(q, is_there)) columns.rotation_ = {*q[0], *q[1], *q[2], *q[3]};
  return columns;
}

std::optional<TruePose> PoseColumns::Read(const CsvFile& file, const CsvFile::Row& row) const {
  if (std::ranges::all_of(position_, [&](size_t column) { return row.cells[column].empty(); })) {
    return std::nullopt;
  }
  const auto number = [&](size_t column) { return file.Number(row, column); };
  const auto& [x, y, z] = position_;
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();
  if (rotation_) {
    const auto& [qw, qx, qy, qz] = *rotation_;
    rotation = {number(qw), number(qx), number(qy), number(qz)};
  }
  return TruePose{PoseOf({number(x), number(y), number(z)}, rotation), rotation_.has_value()};
}

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
