// SPDX-License-Identifier: Apache-2.0
#include "schema/file/map_reader.h"

#include <array>
#include <string>
#include <unordered_map>

#include "core/base/error.h"
#include "schema/layers/layer_rows.h"
#include "schema/tables/blob.h"
#include "schema/tables/table_rows.h"

namespace waystone {
namespace {

// The stored values of the enums: frozen, see FORMAT.md.
constexpr int kFeatureTypes = 3;
constexpr std::array kCameraModels{CameraModel::kSimplePinhole, CameraModel::kPinhole,
                                   CameraModel::kSimpleRadial,  CameraModel::kRadial,
                                   CameraModel::kOpenCv,        CameraModel::kOpenCvFisheye,
                                   CameraModel::kFullOpenCv,    CameraModel::kEquirectangular};
constexpr int kMaxSide = 1'000'000;  // px

CameraModel CameraModelOf(int stored) {
  for (const CameraModel model : kCameraModels) {
    if (static_cast<int>(model) == stored) return model;
  }
  throw MapError(ErrorCode::kMapDamaged,
                 "camera_model is " + std::to_string(stored) + ", which no model has");
}

class Reader {
 public:
  Reader(SQLite::Database& database, Reading& reading)
      : database_(database), reading_(reading), map_(reading.map) {}

  void ReadInfo();
  void ReadSequences();
  void ReadKeyframes();
  void ReadImages();
  void ReadPlanes();
  void ReadFeatures();
  void ReadViews();
  void ReadEdges();
  void ReadIndex();
  void ReadVerdictModel();

 private:
  template <class Read>
  void ForEachRow(const char* table, const std::string& columns, int key_columns, Read read) {
    waystone::ForEachRow(database_, reading_.problems, table, columns, key_columns, read);
  }

  Keyframe& KeyframeOf(int64_t id);
  Plane& PlaneOf(int64_t id);
  static Camera ReadCamera(Row& row);

  SQLite::Database& database_;
  Reading& reading_;
  MapData& map_;
  std::unordered_map<int64_t, size_t> keyframes_;  // index by id
  std::unordered_map<int64_t, size_t> planes_;
  std::vector<int64_t> feature_counts_;  // claimed, by index of the plane
};

void Reader::ReadInfo() {
  bool found = false;
  ForEachRow("map", "id, name, program, feature_type, options", 1, [&](Row& row) {
    row.Int64(1, 1);
    map_.info.name = row.Text();
    map_.info.program = row.Text();
    map_.info.feature_type = static_cast<FeatureType>(row.Int(0, kFeatureTypes - 1));
    map_.info.options_json = row.Text();
    found = true;
  });
  if (!found && reading_.problems.empty()) reading_.problems.push_back({"map", "has no row"});
}

Camera Reader::ReadCamera(Row& row) {
  Camera camera;
  camera.model = CameraModelOf(row.Int());
  camera.width = row.Int(1, kMaxSide);
  camera.height = row.Int(1, kMaxSide);
  camera.params = DecodeParameters(
      row.Blob(static_cast<int64_t>(ParameterCount(camera.model)) * kParameterBytes));
  return camera;
}

void Reader::ReadSequences() {
  ForEachRow("sequences",
             "id, name, kind, frames, skipped, camera_model, camera_width, camera_height, "
             "camera_params_crc32c, camera_params",
             1, [&](Row& row) {
               Sequence sequence;
               sequence.id = {row.Int64(1)};
               sequence.name = row.Text();
               sequence.kind = row.Text();
               sequence.frames = row.Int();
               sequence.skipped = row.Int();
               if (!row.IsNull()) sequence.camera = ReadCamera(row);
               map_.sequences.push_back(std::move(sequence));
             });
}

void Reader::ReadKeyframes() {
  ForEachRow("keyframes", "id, sequence, stretch, frame, source, time_s, width, height", 1,
             [&](Row& row) {
               Keyframe keyframe;
               keyframe.id = {row.Int64(1)};
               keyframe.sequence = {row.Int64(1)};
               keyframe.stretch = row.Int();
               keyframe.frame = row.Int();
               keyframe.source = row.Text();
               keyframe.time_s = row.OptionalReal();
               keyframe.width = row.Int(1, kMaxSide);
               keyframe.height = row.Int(1, kMaxSide);
               keyframes_.emplace(keyframe.id.value, map_.keyframes.size());
               map_.keyframes.push_back(std::move(keyframe));
             });
}

Keyframe& Reader::KeyframeOf(int64_t id) {
  const auto found = keyframes_.find(id);
  if (found != keyframes_.end()) return map_.keyframes[found->second];
  throw MapError(ErrorCode::kMapDamaged, "there is no keyframe " + std::to_string(id));
}

Plane& Reader::PlaneOf(int64_t id) {
  const auto found = planes_.find(id);
  if (found != planes_.end()) return map_.planes[found->second];
  throw MapError(ErrorCode::kMapDamaged, "there is no plane " + std::to_string(id));
}

void Reader::ReadImages() {
  ForEachRow("keyframe_images", "keyframe, jpeg_crc32c, jpeg", 1, [&](Row& row) {
    Keyframe& keyframe = KeyframeOf(row.Int64(1));
    const BytesView jpeg = row.BlobOfRows(1);
    keyframe.jpeg.assign(jpeg.begin(), jpeg.end());
  });
}

void Reader::ReadPlanes() {
  ForEachRow(
      "planes", "id, reference_keyframe, feature_count, vertex_count, outline_crc32c, outline", 1,
      [&](Row& row) {
        Plane plane;
        plane.id = {row.Int64(1)};
        plane.reference = {row.Int64(1)};
        const int64_t features = row.Int();
        plane.outline = DecodeOutline(row.Blob(static_cast<int64_t>(row.Int()) * kVertexBytes));
        plane.descriptors = Descriptors(DescriptorBytes(map_.info.feature_type));
        planes_.emplace(plane.id.value, map_.planes.size());
        feature_counts_.push_back(features);
        map_.planes.push_back(std::move(plane));
      });
}

void Reader::ReadFeatures() {
  std::vector<bool> seen(map_.planes.size(), false);
  const int descriptor_bytes = DescriptorBytes(map_.info.feature_type);
  ForEachRow(
      "plane_features",
      "plane, keypoints_crc32c, keypoints, votes_crc32c, votes, descriptors_crc32c, "
      "descriptors",
      1, [&](Row& row) {
        Plane& plane = PlaneOf(row.Int64(1));
        const size_t index = planes_.at(plane.id.value);
        seen[index] = true;
        const int64_t count = feature_counts_[index];
        const BytesView keypoints = row.Blob(count * kKeypointBytes);
        const BytesView votes = row.Blob(count * kVotesBytes);
        const BytesView descriptors = row.Blob(count * descriptor_bytes);
        plane.features = DecodeFeatures(keypoints, votes);
        plane.descriptors = Descriptors(descriptor_bytes, {descriptors.begin(), descriptors.end()});
      });
  for (size_t i = 0; i < seen.size(); ++i) {
    if (seen[i]) continue;
    reading_.problems.push_back(
        {"planes " + std::to_string(map_.planes[i].id.value), "has no row in plane_features"});
  }
}

void Reader::ReadViews() {
  ForEachRow("plane_views", "plane, keyframe, inliers, homography_crc32c, homography", 2,
             [&](Row& row) {
               Plane& plane = PlaneOf(row.Int64(1));
               PlaneView view;
               view.keyframe = {row.Int64(1)};
               view.inliers = row.Int();
               view.reference_from_keyframe = DecodeMatrix(row.Blob(kMatrixBytes));
               plane.views.push_back(view);
             });
}

void Reader::ReadEdges() {
  ForEachRow("edges",
             "a, b, from_keyframe, to_keyframe, third_eigenvalue, homology_crc32c, homology", 2,
             [&](Row& row) {
               Edge edge;
               edge.a = {row.Int64(1)};
               edge.b = {row.Int64(1)};
               edge.from = {row.Int64(1)};
               edge.to = {row.Int64(1)};
               edge.third_eigenvalue = row.Real();
               edge.homology = DecodeMatrix(row.Blob(kMatrixBytes));
               map_.edges.push_back(edge);
             });
}

// An index of another format is somebody else's: only its blobs' CRCs can be checked.
void Reader::ReadIndex() {
  const int descriptor_bytes = DescriptorBytes(map_.info.feature_type);
  ForEachRow("search_index",
             "id, format, list_count, feature_count, centres_crc32c, centres, lists_crc32c, lists",
             1, [&](Row& row) {
               row.Int64(1, 1);
               const bool known = row.Int64(0) == kInvertedFileFormat;
               const int64_t lists = row.Int();
               const int64_t features = row.Int();
               if (!known) {
                 row.BlobOfRows(1);
                 row.BlobOfRows(1);
                 return;
               }
               InvertedFile file;
               const BytesView centres = row.Blob(lists * descriptor_bytes);
               file.centres = Descriptors(descriptor_bytes, {centres.begin(), centres.end()});
               file.list_of_row = DecodeLists(row.Blob(features * kListBytes));
               map_.index = std::move(file);
             });
}

void Reader::ReadVerdictModel() {
  ForEachRow("verdict_model", "id, intercept, log_inliers, inlier_share, positives, negatives", 1,
             [&](Row& row) {
               row.Int64(1, 1);
               VerdictModel model;
               model.intercept = row.Real();
               model.log_inliers = row.Real();
               model.inlier_share = row.Real();
               model.positives = row.Int();
               model.negatives = row.Int();
               map_.verdict = model;
             });
}

}  // namespace

Reading ReadDatabase(SQLite::Database& database, const ReadOptions& options) {
  Reading reading;
  Reader reader(database, reading);
  reader.ReadInfo();
  reader.ReadSequences();
  reader.ReadKeyframes();
  if (options.images) reader.ReadImages();
  reader.ReadPlanes();
  reader.ReadFeatures();
  reader.ReadViews();
  reader.ReadEdges();
  reader.ReadIndex();
  reader.ReadVerdictModel();
  MapData& map = reading.map;
  map.appearance = ReadAppearance(database, map.info.feature_type, options, reading.problems);
  map.orientation = ReadOrientation(database, options, reading.problems);
  return reading;
}

}  // namespace waystone
