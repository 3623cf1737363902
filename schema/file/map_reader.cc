// SPDX-License-Identifier: Apache-2.0
#include "schema/file/map_reader.h"

#include <array>
#include <string>

#include "core/base/error.h"
#include "schema/file/map_tables.h"
#include "schema/layers/layers.h"
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

CameraModel CameraModelOf(int stored) {
  for (const CameraModel model : kCameraModels) {
    if (static_cast<int>(model) == stored) return model;
  }
  throw MapError(ErrorCode::kMapDamaged,
                 "camera_model is " + std::to_string(stored) + ", which no model has");
}

void ReadInfo(SQLite::Database& database, Reading& reading) {
  MapInfo& info = reading.map.info;
  bool found = false;
  ForEachRow(database, reading.problems, kMapTable, [&](Row& row) {
    row.Int64(1, 1);
    info.name = row.Text();
    info.program = row.Text();
    info.feature_type = static_cast<FeatureType>(row.Int(0, kFeatureTypes - 1));
    info.options_json = row.Text();
    found = true;
  });
  if (!found && reading.problems.empty()) reading.problems.push_back({"map", "has no row"});
}

Camera ReadCamera(Row& row) {
  Camera camera;
  camera.model = CameraModelOf(row.Int());
  camera.width = row.Int(1, kMaxImageSide);
  camera.height = row.Int(1, kMaxImageSide);
  camera.params = DecodeParameters(
      row.Blob(static_cast<int64_t>(ParameterCount(camera.model)) * kParameterBytes));
  return camera;
}

void ReadSequences(SQLite::Database& database, Reading& reading) {
  ForEachRow(database, reading.problems, kSequencesTable, [&](Row& row) {
    Sequence sequence;
    sequence.id = {row.Int64(1)};
    sequence.name = row.Text();
    sequence.kind = row.Text();
    sequence.frames = row.Int();
    sequence.skipped = row.Int();
    if (row.IsNull()) {
      row.SkipRest();
    } else {
      sequence.camera = ReadCamera(row);
    }
    reading.map.sequences.push_back(std::move(sequence));
  });
}

}  // namespace

Reading ReadDatabase(SQLite::Database& database, const ReadOptions& options) {
  Reading reading;
  ReadInfo(database, reading);
  ReadSequences(database, reading);
  for (const StoredLayer& layer : StoredLayers()) {
    layer.read(database, options.images, reading.map, reading.problems);
  }
  return reading;
}

}  // namespace waystone
