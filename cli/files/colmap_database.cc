// SPDX-License-Identifier: Apache-2.0
#include "cli/files/colmap_database.h"

#include <SQLiteCpp/SQLiteCpp.h>

#include <algorithm>
#include <cstdint>
#include <span>

#include "schema/file/file_replacer.h"
#include "schema/file/map_database.h"

namespace waystone {
namespace {

// https://colmap.github.io/database.html
constexpr const char* kSchema = R"sql(
CREATE TABLE cameras (
  camera_id INTEGER PRIMARY KEY AUTOINCREMENT NOT NULL, model INTEGER NOT NULL,
  width INTEGER NOT NULL, height INTEGER NOT NULL, params BLOB,
  prior_focal_length INTEGER NOT NULL);
CREATE TABLE images (
  image_id INTEGER PRIMARY KEY AUTOINCREMENT NOT NULL, name TEXT NOT NULL UNIQUE,
  camera_id INTEGER NOT NULL, prior_qw REAL, prior_qx REAL, prior_qy REAL, prior_qz REAL,
  prior_tx REAL, prior_ty REAL, prior_tz REAL,
  CONSTRAINT image_id_check CHECK(image_id >= 0 AND image_id < 2147483647),
  FOREIGN KEY(camera_id) REFERENCES cameras(camera_id));
CREATE UNIQUE INDEX index_name ON images(name);
CREATE TABLE keypoints (
  image_id INTEGER PRIMARY KEY NOT NULL, rows INTEGER NOT NULL, cols INTEGER NOT NULL, data BLOB,
  FOREIGN KEY(image_id) REFERENCES images(image_id) ON DELETE CASCADE);
CREATE TABLE descriptors (
  image_id INTEGER PRIMARY KEY NOT NULL, rows INTEGER NOT NULL, cols INTEGER NOT NULL, data BLOB,
  FOREIGN KEY(image_id) REFERENCES images(image_id) ON DELETE CASCADE);
CREATE TABLE matches (
  pair_id INTEGER PRIMARY KEY NOT NULL, rows INTEGER NOT NULL, cols INTEGER NOT NULL, data BLOB);
CREATE TABLE two_view_geometries (
  pair_id INTEGER PRIMARY KEY NOT NULL, rows INTEGER NOT NULL, cols INTEGER NOT NULL, data BLOB,
  config INTEGER NOT NULL, F BLOB, E BLOB, H BLOB, qvec BLOB, tvec BLOB);
)sql";

// COLMAP's TwoViewGeometry::ConfigurationType.
constexpr int kUncalibrated = 3;
constexpr int kPlanarOrPanoramic = 6;

template <class Value>
void BindBlob(SQLite::Statement& row, int column, std::span<const Value> values) {
  row.bind(column, values.data(), static_cast<int>(values.size_bytes()));
}

// Executes a statement for one row after the other.
class RowWriter {
 public:
  RowWriter(SQLite::Database& database, const std::string& sql) : row_(database, sql) {}

  SQLite::Statement& row() { return row_; }
  void Write() {
    row_.exec();
    row_.reset();
    row_.clearBindings();
  }

 private:
  SQLite::Statement row_;
};

Camera GuessCamera(const Features& features) {
  constexpr double kFocalOfSide = 1.2;
  const cv::Size size = ImageSize(features);
  return {CameraModel::kSimpleRadial,
          size.width,
          size.height,
          {kFocalOfSide * std::max(size.width, size.height), (size.width - 1) / 2.0,
           (size.height - 1) / 2.0, 0}};
}

// Pixels of the keyframe's image, as COLMAP counts them, from those of the features.
Eigen::Matrix3d ColmapFromWorking(const Features& features) {
  Eigen::Matrix3d colmap_from_working = ImageFromWorking(features);
  colmap_from_working.topRightCorner<2, 1>().array() += kColmapOffset_px;
  return colmap_from_working;
}

void WriteCameras(const ColmapProject& project, SQLite::Database& database) {
  const MapData& map = *project.map;
  RowWriter writer(database, "INSERT INTO cameras VALUES (?, ?, ?, ?, ?, ?)");
  for (const Sequence& sequence : map.sequences) {
    const auto first = std::ranges::find(map.keyframes, sequence.id, &Keyframe::sequence);
    if (first == map.keyframes.end()) continue;
    const auto keyframe = static_cast<size_t>(first - map.keyframes.begin());
    Camera camera =
        sequence.camera ? *sequence.camera : GuessCamera(project.features[keyframe].features);
    MovePrincipalPoint(camera, kColmapOffset_px);
    writer.row().bind(1, sequence.id.value);
    writer.row().bind(2, static_cast<int>(camera.model));
    writer.row().bind(3, camera.width);
    writer.row().bind(4, camera.height);
    BindBlob<double>(writer.row(), 5, camera.params);
    writer.row().bind(6, sequence.camera ? 1 : 0);
    writer.Write();
  }
}

void WriteImages(const MapData& map, SQLite::Database& database) {
  RowWriter writer(database, "INSERT INTO images (image_id, name, camera_id) VALUES (?, ?, ?)");
  for (const Keyframe& keyframe : map.keyframes) {
    writer.row().bind(1, keyframe.id.value);
    writer.row().bind(2, ColmapImageName(map, keyframe));
    writer.row().bind(3, keyframe.sequence.value);
    writer.Write();
  }
}

void WriteKeypoints(const std::vector<SampledKeyframe>& keyframes, SQLite::Database& database) {
  RowWriter writer(database, "INSERT INTO keypoints VALUES (?, ?, 2, ?)");
  for (const SampledKeyframe& keyframe : keyframes) {
    std::vector<float> positions;
    const Eigen::Matrix3d colmap_from_working = ColmapFromWorking(keyframe.features);
    for (const Keypoint& keypoint : keyframe.features.keypoints) {
      const Eigen::Vector3d x = colmap_from_working * PositionOf(keypoint).homogeneous();
      positions.push_back(static_cast<float>(x.x()));
      positions.push_back(static_cast<float>(x.y()));
    }
    writer.row().bind(1, keyframe.keyframe.value);
    writer.row().bind(2, keyframe.features.size());
    BindBlob<float>(writer.row(), 3, positions);
    writer.Write();
  }
}

// COLMAP's descriptors are RootSIFT times 512, ours times 256.
void WriteDescriptors(const std::vector<SampledKeyframe>& keyframes, SQLite::Database& database) {
  RowWriter writer(database, "INSERT INTO descriptors VALUES (?, ?, ?, ?)");
  for (const SampledKeyframe& keyframe : keyframes) {
    if (keyframe.features.type != FeatureType::kSift) return;
    std::vector<uint8_t> values = keyframe.features.descriptors.data();
    for (uint8_t& value : values) value = static_cast<uint8_t>(2 * value);  // at most 127
    writer.row().bind(1, keyframe.keyframe.value);
    writer.row().bind(2, keyframe.features.size());
    writer.row().bind(3, DescriptorBytes(FeatureType::kSift));
    BindBlob<uint8_t>(writer.row(), 4, values);
    writer.Write();
  }
}

// In COLMAP's pixels, row by row: x_b^T F x_a = 0.
std::vector<double> MovedFundamental(const Eigen::Matrix3d& fundamental, const Features& a,
                                     const Features& b) {
  const Eigen::Matrix<double, 3, 3, Eigen::RowMajor> moved =
      ColmapFromWorking(b).inverse().transpose() * fundamental * ColmapFromWorking(a).inverse();
  return {moved.data(), moved.data() + moved.size()};
}

void WriteMatches(const ColmapProject& project, SQLite::Database& database) {
  constexpr int64_t kMaxImages = 2147483647;
  RowWriter matches(database, "INSERT INTO matches VALUES (?, ?, 2, ?)");
  RowWriter geometries(
      database,
      "INSERT INTO two_view_geometries (pair_id, rows, cols, data, config, F) VALUES (?, ?, 2, ?, "
      "?, ?)");
  for (const MatchedKeyframes& pair : project.matches) {
    const int64_t a = project.features[pair.a].keyframe.value;
    const int64_t b = project.features[pair.b].keyframe.value;
    std::vector<uint32_t> rows;
    for (const auto& [in_a, in_b] : pair.matches.features) {
      rows.push_back(static_cast<uint32_t>(in_a));
      rows.push_back(static_cast<uint32_t>(in_b));
    }
    const EpipolarFit& fit = pair.matches.fit;
    for (RowWriter* writer : {&matches, &geometries}) {
      writer->row().bind(1, kMaxImages * a + b);
      writer->row().bind(2, static_cast<int64_t>(pair.matches.features.size()));
      BindBlob<uint32_t>(writer->row(), 3, rows);
    }
    geometries.row().bind(4, fit.planar ? kPlanarOrPanoramic : kUncalibrated);
    if (!fit.planar) {
      BindBlob<double>(geometries.row(), 5,
                       MovedFundamental(fit.fundamental, project.features[pair.a].features,
                                        project.features[pair.b].features));
    }
    matches.Write();
    geometries.Write();
  }
}

void WriteAll(const ColmapProject& project, const std::filesystem::path& path) {
  SQLite::Database database = OpenForWriting(path);
  try {
    database.exec("BEGIN");
    database.exec(kSchema);
    WriteCameras(project, database);
    WriteImages(*project.map, database);
    WriteKeypoints(project.features, database);
    WriteDescriptors(project.features, database);
    WriteMatches(project, database);
    database.exec("COMMIT");
  } catch (const SQLite::Exception& error) {
    throw SQLite::Exception(DescribeError(database, error));
  }
}

}  // namespace

std::string ColmapImageName(const MapData& map, const Keyframe& keyframe) {
  const Sequence& sequence =
      *std::ranges::lower_bound(map.sequences, keyframe.sequence, {}, &Sequence::id);
  std::string name = keyframe.source;
  if (sequence.kind == kVideoKind) name += ".jpg";
  return map.sequences.size() > 1 ? sequence.name + "/" + name : name;
}

void WriteColmapDatabase(const ColmapProject& project, const std::filesystem::path& path,
                         bool overwrite) {
  FileReplacer file(path, overwrite);
  try {
    WriteAll(project, file.temporary());
  } catch (const SQLite::Exception& error) {
    throw UnwritableError(path, error.what(), 0);
  }
  file.Commit();
}

}  // namespace waystone
