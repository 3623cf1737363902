// SPDX-License-Identifier: Apache-2.0
#include "cli/files/trajectory_file.h"

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <fstream>
#include <optional>
#include <string>

#include "api/tum_pose.h"
#include "cli/files/csv_file.h"
#include "cli/files/map_file.h"
#include "core/base/error.h"

namespace waystone {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void Fail(const fs::path& path, int line, const std::string& cause) {
  throw MapError(ErrorCode::kBadRequest,
                 path.string() + ", line " + std::to_string(line) + ": " + cause);
}

double ComputeHeading(const Eigen::Quaterniond& rotation) {
  const Eigen::Vector3d gaze =
      Eigen::Quaterniond(rotation.coeffs().stableNormalized()) * Eigen::Vector3d::UnitZ();
  return std::atan2(gaze.y(), gaze.x());
}

void AddTime(const fs::path& path, int line, double time_s, Trajectory& trajectory) {
  if (!trajectory.times_s.empty() && time_s <= trajectory.times_s.back()) {
    Fail(path, line, "time stamps must increase; sort the file by time");
  }
  trajectory.times_s.push_back(time_s);
}

class CsvColumns {
 public:
  explicit CsvColumns(const CsvFile& file) : file_(file) {
    for (size_t i = 0; i < kNames.size(); ++i) columns_[i] = file.Column(kNames[i]);
    if (!columns_[0] || !columns_[1])
      file.Fail(1, "missing columns x and y; name them in the header");
  }

  bool HasTime() const { return columns_[2].has_value(); }
  bool HasTheta() const { return columns_[3].has_value(); }
  bool HasQuaternion() const { return columns_[4] && columns_[5] && columns_[6] && columns_[7]; }
  double Number(const CsvFile::Row& row, size_t i) const { return file_.Number(row, *columns_[i]); }

  double Heading(const CsvFile::Row& row) const {
    if (HasTheta()) return WrappedAngle(Number(row, 3));
    if (!HasQuaternion()) return 0;
    return ComputeHeading({Number(row, 7), Number(row, 4), Number(row, 5), Number(row, 6)});
  }

 private:
  static constexpr std::array<const char*, 8> kNames = {"x",  "y",  "time_s", "theta_rad",
                                                        "qx", "qy", "qz",     "qw"};
  const CsvFile& file_;
  std::array<std::optional<size_t>, 8> columns_;
};

Trajectory ReadCsv(const fs::path& path) {
  const CsvFile file(path);
  const CsvColumns columns(file);
  Trajectory trajectory;
  trajectory.has_headings = columns.HasTheta() || columns.HasQuaternion();
  for (const CsvFile::Row& row : file.rows()) {
    if (columns.HasTime()) AddTime(path, row.line, columns.Number(row, 2), trajectory);
    trajectory.poses.push_back(
        {columns.Number(row, 0), columns.Number(row, 1), columns.Heading(row)});
  }
  return trajectory;
}

Trajectory ReadTum(const fs::path& path) {
  std::ifstream in = OpenText(path, "a trajectory");
  Trajectory trajectory;
  trajectory.has_headings = true;
  std::string text;
  for (int line = 1; std::getline(in, text); ++line) {
    const size_t first = text.find_first_not_of(" \t\r");
    if (first == std::string::npos || text[first] == '#') continue;
    const std::optional<TumPose> pose = ParseTumPose(text);
    if (!pose) Fail(path, line, "expected eight numbers: time x y z qx qy qz qw");
    AddTime(path, line, pose->time_s, trajectory);
    trajectory.poses.push_back(
        {pose->position.x(), pose->position.y(), ComputeHeading(pose->rotation)});
  }
  return trajectory;
}

}  // namespace

Trajectory ReadTrajectory(const fs::path& path) {
  return path.extension() == ".csv" ? ReadCsv(path) : ReadTum(path);
}

}  // namespace waystone
