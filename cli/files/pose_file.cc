// SPDX-License-Identifier: Apache-2.0
#include "cli/files/pose_file.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <initializer_list>
#include <limits>
#include <string_view>
#include <utility>

#include "api/tum_pose.h"
#include "cli/files/colmap_images.h"
#include "cli/files/csv_file.h"
#include "cli/files/map_file.h"
#include "core/base/error.h"
#include "core/base/text.h"

namespace waystone {
namespace {

namespace fs = std::filesystem;

constexpr const char* kWanted = "a file of poses";
constexpr size_t kKittiNumbers = 12;
constexpr size_t kColmapFields = 10;

// Bound on positions, in any unit: far beyond an Earth-centred frame in millimetres.
constexpr double kMostPosition = 1e12;
// Bound on how far the 9 numbers of a KITTI pose may be from a rotation.
constexpr double kMostSkew = 0.1;
constexpr const char* kNoPose =
    "not a pose: the rotation must be one (a quaternion other than 0), and no coordinate beyond "
    "1e12";

// NaN where the quaternion is 0.
Eigen::Isometry3d PoseOf(const Eigen::Vector3d& at, const Eigen::Quaterniond& rotation) {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.translation() = at;
  if (rotation.coeffs().isZero(0)) {
    pose.linear().setConstant(std::numeric_limits<double>::quiet_NaN());
    return pose;
  }
  // Stable: a quaternion of a length far from 1 must still give a rotation.
  pose.linear() =
      Eigen::Quaterniond(rotation.coeffs().stableNormalized().normalized()).toRotationMatrix();
  return pose;
}

void CheckPose(const fs::path& path, int line, const FilePose& pose) {
  if (IsPose(pose.pose)) return;
  throw MapError(ErrorCode::kBadRequest,
                 path.string() + ", line " + std::to_string(line) + ": " + kNoPose);
}

int FrameNumber(const CsvFile& file, const CsvFile::Row& row, size_t column) {
  constexpr double kMost = 1e9;
  const double number = file.Number(row, column);
  if (number != std::floor(number) || std::abs(number) > kMost) {
    file.Fail(row.line, "frame is " + row.cells[column] + "; it must be an integer");
  }
  return static_cast<int>(number);
}

// A frame number tells the image already: its time may be missing.
std::optional<double> TimeStamp(const CsvFile& file, const CsvFile::Row& row, size_t column,
                                bool has_frame) {
  if (!has_frame) return file.Number(row, column);
  const std::optional<double> time_s = ToNumber(row.cells[column]);
  return time_s && std::isfinite(*time_s) ? time_s : std::nullopt;
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
  if (!name && !frame && !time) {
    file.Fail(1,
              "the header has no column that tells which image a pose belongs to; add image, "
              "keyframe, id, frame or time_s");
  }
  std::vector<FilePose> poses;
  for (const CsvFile::Row& row : file.rows()) {
    const std::optional<TruePose> read = columns->Read(file, row);
    if (!read) continue;
    FilePose pose;
    if (name) pose.name = row.cells[*name];
    if (time && !name) pose.time_s = TimeStamp(file, row, *time, frame.has_value());
    pose.number = frame ? FrameNumber(file, row, *frame) : static_cast<int>(poses.size());
    pose.has_frame = frame.has_value();
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

// "timestamp [ns], p_x, p_y, p_z, q_w, q_x, q_y, q_z, ...": EuRoC's ground truth of the body.
bool IsEurocPoses(const fs::path& path) {
  std::ifstream in = OpenText(path, kWanted);
  std::string first;
  return std::getline(in, first) && first.starts_with("#timestamp");
}

std::vector<FilePose> ReadEurocPoses(const fs::path& path) {
  constexpr size_t kEurocNumbers = 8;
  constexpr double kNanosecond_s = 1e-9;
  std::ifstream in = OpenText(path, kWanted);
  std::vector<FilePose> poses;
  std::string text;
  for (int line = 1; std::getline(in, text); ++line) {
    const std::vector<std::string> fields = Words(text, " \t\r,");
    if (fields.empty() || fields[0].starts_with('#')) continue;
    const auto n = ParseNumbers(fields);
    if (!n || n->size() < kEurocNumbers) {
      throw MapError(ErrorCode::kBadRequest, path.string() + ", line " + std::to_string(line) +
                                                 ": not a pose of EuRoC's ground truth (time, "
                                                 "position, quaternion w x y z)");
    }
    FilePose pose;
    pose.time_s = (*n)[0] * kNanosecond_s;
    pose.number = static_cast<int>(poses.size());
    pose.pose = {PoseOf({(*n)[1], (*n)[2], (*n)[3]}, {(*n)[4], (*n)[5], (*n)[6], (*n)[7]}), true};
    CheckPose(path, line, pose);
    poses.push_back(std::move(pose));
  }
  return poses;
}

// The cells of a row, some of them perhaps empty; quotes are not expected in odometry.
std::vector<std::string> SplitCells(std::string line) {
  if (line.ends_with('\r')) line.pop_back();
  std::vector<std::string> cells(1);
  for (const char c : line) {
    if (c == ',') {
      cells.emplace_back();
    } else {
      cells.back() += c;
    }
  }
  return cells;
}

// Where nav_msgs/Odometry's fields are in a row: seconds, nanoseconds, position, quaternion x y z
// w.
struct OdometryColumns {
  std::optional<size_t> seconds;  // nothing where nanoseconds are those of the whole stamp
  size_t nanoseconds = 0;
  std::array<size_t, 7> pose{};

  size_t last() const { return std::ranges::max(pose); }
};

std::optional<size_t> FindEnding(const std::vector<std::string>& cells,
                                 std::initializer_list<std::string_view> endings) {
  for (size_t i = 0; i < cells.size(); ++i) {
    for (const std::string_view ending : endings) {
      if (cells[i].ends_with(ending)) return i;
    }
  }
  return std::nullopt;
}

// The columns that a header names, or those of `ros2 topic echo --csv`, which prints none: seconds,
// nanoseconds, two frames' names, position, quaternion. Nothing for what isn't odometry.
std::optional<OdometryColumns> FindOdometry(const std::vector<std::string>& first) {
  constexpr std::array kEndings{"pose.pose.position.x",    "pose.pose.position.y",
                                "pose.pose.position.z",    "pose.pose.orientation.x",
                                "pose.pose.orientation.y", "pose.pose.orientation.z",
                                "pose.pose.orientation.w"};
  OdometryColumns columns;
  if (FindEnding(first, {kEndings[0]})) {
    for (size_t i = 0; i < kEndings.size(); ++i) {
      const auto column = FindEnding(first, {kEndings[i]});
      if (!column) return std::nullopt;
      columns.pose[i] = *column;
    }
    columns.seconds = FindEnding(first, {"header.stamp.sec", "header.stamp.secs"});
    const auto nanoseconds = columns.seconds
                                 ? FindEnding(first, {"header.stamp.nanosec", "header.stamp.nsecs"})
                                 : FindEnding(first, {"header.stamp"});
    if (!nanoseconds) return std::nullopt;
    columns.nanoseconds = *nanoseconds;
    return columns;
  }
  columns = {.seconds = 0, .nanoseconds = 1, .pose = {4, 5, 6, 7, 8, 9, 10}};
  if (first.size() <= columns.last() || ToNumber(first[2]) || ToNumber(first[3])) {
    return std::nullopt;
  }
  const bool numbers =
      ToInteger(first[0]) && ToInteger(first[1]) &&
      std::ranges::all_of(columns.pose, [&](size_t i) { return ToNumber(first[i]).has_value(); });
  return numbers ? std::optional(columns) : std::nullopt;
}

std::optional<OdometryColumns> FindOdometry(const fs::path& path) {
  std::ifstream in = OpenText(path, kWanted);
  std::string first;
  std::getline(in, first);
  return FindOdometry(SplitCells(first));
}

std::vector<FilePose> ReadOdometry(const fs::path& path, const OdometryColumns& columns) {
  constexpr double kNanosecond_s = 1e-9;
  std::ifstream in = OpenText(path, kWanted);
  std::vector<FilePose> poses;
  std::string text;
  for (int line = 1; std::getline(in, text); ++line) {
    const std::vector<std::string> cells = SplitCells(text);
    const bool header =
        line == 1 && cells.size() > columns.last() && !ToNumber(cells[columns.pose.front()]);
    if (header || text.empty()) continue;
    std::vector<std::string> fields;
    if (cells.size() > std::max(columns.last(), columns.nanoseconds)) {
      for (const size_t column : columns.pose) fields.push_back(cells[column]);
      fields.push_back(cells[columns.nanoseconds]);
      fields.push_back(columns.seconds ? cells[*columns.seconds] : "0");
    }
    const auto n = ParseNumbers(fields);
    if (!n || n->size() != columns.pose.size() + 2) {
      throw MapError(ErrorCode::kBadRequest, path.string() + ", line " + std::to_string(line) +
                                                 ": not a row of nav_msgs/Odometry");
    }
    FilePose pose;
    pose.time_s = (*n)[8] + (*n)[7] * kNanosecond_s;
    pose.number = static_cast<int>(poses.size());
    pose.pose = {PoseOf({(*n)[0], (*n)[1], (*n)[2]}, {(*n)[6], (*n)[3], (*n)[4], (*n)[5]}), true};
    CheckPose(path, line, pose);
    poses.push_back(std::move(pose));
  }
  return poses;
}

// "VERTEX_SE3:QUAT ID X Y Z QX QY QZ QW"; `number` has the id.
std::optional<FilePose> G2oPose(const std::vector<std::string>& fields) {
  constexpr size_t kG2oFields = 9;
  if (fields.size() != kG2oFields || fields[0] != "VERTEX_SE3:QUAT") return std::nullopt;
  const auto n = ParseNumbers({fields.begin() + 1, fields.end()});
  const auto id = ToInteger(fields[1]);
  if (!n || !id || *id < 0 || *id > INT32_MAX) return std::nullopt;
  FilePose pose;
  pose.number = static_cast<int>(*id);
  pose.pose = {PoseOf({(*n)[1], (*n)[2], (*n)[3]}, {(*n)[7], (*n)[4], (*n)[5], (*n)[6]}), true};
  return pose;
}

FilePose KittiPose(const std::vector<double>& n) {
  FilePose pose;
  const Eigen::Map<const Eigen::Matrix<double, 3, 4, Eigen::RowMajor>> matrix(n.data());
  const Eigen::Matrix3d rotation = matrix.leftCols<3>();
  const bool is_rotation = rotation.determinant() > 0 && rotation.isUnitary(kMostSkew);
  pose.pose = {PoseOf(matrix.col(3),
                      is_rotation ? Eigen::Quaterniond(rotation) : Eigen::Quaterniond(0, 0, 0, 0)),
               true};
  return pose;
}

// "IMAGE_ID QW QX QY QZ TX TY TZ CAMERA_ID NAME", camera_from_world; a name may have blanks. A line
// of numbers alone is none.
std::optional<FilePose> ColmapPose(const std::vector<std::string>& fields) {
  if (fields.size() < kColmapFields || !ToInteger(fields[0]) || !ToInteger(fields[8])) {
    return std::nullopt;
  }
  if (ParseNumbers({fields.begin() + 9, fields.end()})) return std::nullopt;
  const auto n = ParseNumbers({fields.begin(), fields.begin() + 9});
  if (!n) return std::nullopt;
  FilePose pose;
  pose.pose = {PoseOf({(*n)[5], (*n)[6], (*n)[7]}, {(*n)[1], (*n)[2], (*n)[3], (*n)[4]}).inverse(),
               true};
  pose.name = fields[9];
  for (size_t i = kColmapFields; i < fields.size(); ++i) pose.name += " " + fields[i];
  return pose;
}

// "X Y POINT3D_ID" any number of times, also none: the line after each of COLMAP's poses.
bool IsColmapPoints(const std::vector<std::string>& fields) {
  constexpr size_t kPointFields = 3;
  return fields.size() % kPointFields == 0 && ParseNumbers(fields);
}

class TextPoses {
 public:
  explicit TextPoses(const fs::path& path) : path_(path), in_(OpenText(path, kWanted)) {}

  std::vector<FilePose> Read() {
    std::vector<FilePose> poses;
    std::string text;
    for (int line = 1; std::getline(in_, text); ++line) {
      const std::vector<std::string> fields = Words(text);
      if (std::exchange(expects_points_, false)) {
        CheckPoints(fields, line);
        continue;
      }
      if (fields.empty() || IsAside(fields[0])) continue;
      FilePose pose = Parse(text, fields, line);
      if (fields[0] != "VERTEX_SE3:QUAT") pose.number = static_cast<int>(poses.size());
      poses.push_back(std::move(pose));
    }
    return poses;
  }

 private:
  // Whether it is a comment, or something else than vertices in a g2o file.
  static bool IsAside(const std::string& word) {
    return word.starts_with('#') || word.starts_with("EDGE_") || word == "FIX";
  }

  std::optional<FilePose> AnyPose(const std::string& text, const std::vector<std::string>& fields) {
    if (const auto tum = ParseTumPose(text)) {
      return FilePose{{}, tum->time_s, 0, {PoseOf(tum->position, tum->rotation), true}};
    }
    const auto numbers = ParseNumbers(fields);
    if (numbers && numbers->size() == kKittiNumbers) return KittiPose(*numbers);
    if (auto vertex = G2oPose(fields)) return vertex;
    std::optional<FilePose> pose = ColmapPose(fields);
    expects_points_ = pose.has_value();
    return pose;
  }

  // Another pose instead would be lost.
  void CheckPoints(const std::vector<std::string>& fields, int line) const {
    if (IsColmapPoints(fields)) return;
    throw MapError(ErrorCode::kBadRequest,
                   path_.string() + ", line " + std::to_string(line) +
                       ": not the points of the image in the line before (X Y POINT3D_ID ...); in "
                       "COLMAP's images.txt, a line of points, which may be empty, follows each "
                       "image: add it");
  }

  FilePose Parse(const std::string& text, const std::vector<std::string>& fields, int line) {
    if (auto pose = AnyPose(text, fields)) {
      CheckPose(path_, line, *pose);
      return *pose;
    }
    throw MapError(ErrorCode::kBadRequest,
                   path_.string() + ", line " + std::to_string(line) +
                       ": not a pose; expected a line of a TUM trajectory (8 numbers), of KITTI "
                       "poses (12 numbers), of COLMAP's images.txt or of g2o's vertices");
  }

  fs::path path_;
  std::ifstream in_;
  bool expects_points_ = false;  // in this line: the one before was a pose of COLMAP's
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
  const TruePose pose{PoseOf({number(x), number(y), number(z)}, rotation), rotation_.has_value()};
  if (!IsPose(pose)) file.Fail(row.line, kNoPose);
  return pose;
}

namespace {

std::vector<FilePose> ReadAnyPoses(const fs::path& path) {
  if (path.extension() == ".bin") return ReadColmapImages(path);
  if (path.extension() != ".csv") return TextPoses(path).Read();
  if (const auto odometry = FindOdometry(path)) return ReadOdometry(path, *odometry);
  return IsEurocPoses(path) ? ReadEurocPoses(path) : ReadCsvPoses(path);
}

}  // namespace

bool IsPose(const TruePose& pose) {
  const Eigen::Isometry3d& at = pose.world_from_camera;
  return at.matrix().allFinite() && at.translation().cwiseAbs().maxCoeff() <= kMostPosition;
}

std::vector<FilePose> ReadPoseFile(const fs::path& path) {
  std::vector<FilePose> poses = ReadAnyPoses(path);
  if (!poses.empty()) return poses;
  throw MapError(ErrorCode::kBadRequest, path.string() + " has no poses; expected one a line");
}

}  // namespace waystone
