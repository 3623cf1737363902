// SPDX-License-Identifier: Apache-2.0
#include <string>
#include <unordered_map>

#include "core/base/error.h"
#include "core/features/descriptor_codes.h"
#include "schema/layers/layer_blobs.h"
#include "schema/layers/layer_rows.h"
#include "schema/layers/planes/plane_tables.h"
#include "schema/tables/blob.h"
#include "schema/tables/table_rows.h"
#include "schema/tables/table_writer.h"

namespace waystone {
namespace {

class PlaneReader {
 public:
  PlaneReader(SQLite::Database& database, MapData& map, std::vector<MapProblem>& problems)
      : database_(database), map_(map), problems_(problems) {}

  void Read(bool images) {
    ReadKeyframes();
    if (images) ReadImages();
    ReadLandmarks();
    ReadPlanes();
    ReadFeatures();
    ReadViews();
    ReadEdges();
    ReadIndex();
    ReadVerdictModel();
  }

 private:
  template <class Each>
  void ForEachRow(const TableView& table, Each each) {
    waystone::ForEachRow(database_, problems_, table, each);
  }

  void ReadKeyframes();
  void ReadImages();
  void ReadLandmarks();
  void ReadPlanes();
  void ReadFeatures();
  void ReadViews();
  void ReadEdges();
  void ReadIndex();
  void ReadVerdictModel();
  Keyframe& KeyframeOf(int64_t id);
  Plane& PlaneOf(int64_t id);

  SQLite::Database& database_;
  MapData& map_;
  std::vector<MapProblem>& problems_;
  std::unordered_map<int64_t, size_t> keyframes_;  // index by id
  std::unordered_map<int64_t, size_t> planes_;
  std::vector<int64_t> feature_counts_;  // claimed, by index of the plane
};

void PlaneReader::ReadKeyframes() {
  ForEachRow(kKeyframesTable, [&](Row& row) {
    Keyframe keyframe;
    keyframe.id = {row.Int64(1)};
    keyframe.sequence = {row.Int64(1)};
    keyframe.stretch = row.Int();
    keyframe.frame = row.Int();
    keyframe.source = row.Text();
    keyframe.time_s = row.OptionalReal();
    keyframe.width = row.Int(1, kMaxImageSide);
    keyframe.height = row.Int(1, kMaxImageSide);
    keyframes_.emplace(keyframe.id.value, map_.keyframes.size());
    map_.keyframes.push_back(std::move(keyframe));
  });
}

Keyframe& PlaneReader::KeyframeOf(int64_t id) {
  const auto found = keyframes_.find(id);
  if (found != keyframes_.end()) return map_.keyframes[found->second];
  throw MapError(ErrorCode::kMapDamaged, "there is no keyframe " + std::to_string(id));
}

Plane& PlaneReader::PlaneOf(int64_t id) {
  const auto found = planes_.find(id);
  if (found != planes_.end()) return map_.planes[found->second];
  throw MapError(ErrorCode::kMapDamaged, "no such plane: " + std::to_string(id));
}

void PlaneReader::ReadImages() {
  ForEachRow(kKeyframeImagesTable, [&](Row& row) {
    Keyframe& keyframe = KeyframeOf(row.Int64(1));
    const BytesView picture = row.BlobOfRows(1);
    keyframe.picture.assign(picture.begin(), picture.end());
  });
}

void PlaneReader::ReadLandmarks() {
  const int code_bytes = CodeBytes(map_.info.feature_type);
  ForEachRow(kKeyframeLandmarksTable, [&](Row& row) {
    Landmarks& landmarks = KeyframeOf(row.Int64(1)).landmarks;
    const int64_t count = row.Int(1);
    landmarks.positions = DecodePositions(row.Blob(count * kPositionBytes));
    const BytesView codes = row.Blob(count * code_bytes);
    landmarks.codes = Descriptors(code_bytes, {codes.begin(), codes.end()});
  });
}

void PlaneReader::ReadPlanes() {
  ForEachRow(kPlanesTable, [&](Row& row) {
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

void PlaneReader::ReadFeatures() {
  std::vector<bool> seen(map_.planes.size(), false);
  const int descriptor_bytes = DescriptorBytes(map_.info.feature_type);
  ForEachRow(kPlaneFeaturesTable, [&](Row& row) {
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
    problems_.push_back(
        {"planes " + std::to_string(map_.planes[i].id.value), "has no row in plane_features"});
  }
}

void PlaneReader::ReadViews() {
  ForEachRow(kPlaneViewsTable, [&](Row& row) {
    Plane& plane = PlaneOf(row.Int64(1));
    PlaneView view;
    view.keyframe = {row.Int64(1)};
    view.inliers = row.Int();
    view.reference_from_keyframe = DecodeMatrix(row.Blob(kMatrixBytes));
    plane.views.push_back(view);
  });
}

void PlaneReader::ReadEdges() {
  ForEachRow(kEdgesTable, [&](Row& row) {
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

// An index of another format is unknown: only its blobs' CRCs can be checked.
void PlaneReader::ReadIndex() {
  const int descriptor_bytes = DescriptorBytes(map_.info.feature_type);
  ForEachRow(kSearchIndexTable, [&](Row& row) {
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

void PlaneReader::ReadVerdictModel() {
  ForEachRow(kVerdictModelTable, [&](Row& row) {
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

void WriteKeyframes(const MapData& map, RowSink& sink) {
  TableWriter<kKeyframesTable> keyframes(sink);
  TableWriter<kKeyframeImagesTable> images(sink);
  for (const Keyframe& keyframe : map.keyframes) {
    keyframes.Row(keyframe.id, keyframe.sequence, keyframe.stretch, keyframe.frame, keyframe.source,
                  keyframe.time_s, keyframe.width, keyframe.height);
  }
  for (const Keyframe& keyframe : map.keyframes) {
    if (!keyframe.picture.empty()) images.Row(keyframe.id, keyframe.picture);
  }
}

void WriteLandmarks(const MapData& map, RowSink& sink) {
  TableWriter<kKeyframeLandmarksTable> writer(sink);
  for (const Keyframe& keyframe : map.keyframes) {
    const Landmarks& landmarks = keyframe.landmarks;
    if (landmarks.size() == 0) continue;
    writer.Row(keyframe.id, landmarks.size(), EncodePositions(landmarks.positions),
               landmarks.codes.data());
  }
}

void WritePlanes(const MapData& map, RowSink& sink) {
  TableWriter<kPlanesTable> planes(sink);
  TableWriter<kPlaneFeaturesTable> features(sink);
  TableWriter<kPlaneViewsTable> views(sink);
  for (const Plane& plane : map.planes) {
    planes.Row(plane.id, plane.reference, plane.features.size(), plane.outline.size(),
               EncodeOutline(plane.outline));
  }
  for (const Plane& plane : map.planes) {
    features.Row(plane.id, EncodeKeypoints(plane.features), EncodeVotes(plane.features),
                 plane.descriptors.data());
  }
  for (const Plane& plane : map.planes) {
    for (const PlaneView& view : plane.views) {
      views.Row(plane.id, view.keyframe, view.inliers, EncodeMatrix(view.reference_from_keyframe));
    }
  }
}

void WriteEdges(const MapData& map, RowSink& sink) {
  TableWriter<kEdgesTable> writer(sink);
  for (const Edge& edge : map.edges) {
    writer.Row(edge.a, edge.b, edge.from, edge.to, edge.third_eigenvalue,
               EncodeMatrix(edge.homology));
  }
}

void WriteIndex(const InvertedFile& index, RowSink& sink) {
  TableWriter<kSearchIndexTable>(sink).Row(1, kInvertedFileFormat, index.centres.rows(),
                                           index.list_of_row.size(), index.centres.data(),
                                           EncodeLists(index.list_of_row));
}

void WriteVerdictModel(const VerdictModel& model, RowSink& sink) {
  TableWriter<kVerdictModelTable>(sink).Row(1, model.intercept, model.log_inliers,
                                            model.inlier_share, model.positives, model.negatives);
}

}  // namespace

void ReadPlaneLayer(SQLite::Database& database, bool images, MapData& map,
                    std::vector<MapProblem>& problems) {
  PlaneReader(database, map, problems).Read(images);
}

void WritePlaneLayer(const MapData& map, RowSink& sink) {
  WriteKeyframes(map, sink);
  WriteLandmarks(map, sink);
  WritePlanes(map, sink);
  WriteEdges(map, sink);
  if (map.index) WriteIndex(*map.index, sink);
  if (map.verdict) WriteVerdictModel(*map.verdict, sink);
}

}  // namespace waystone
