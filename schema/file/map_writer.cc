// SPDX-License-Identifier: Apache-2.0
#include "schema/file/map_writer.h"

#include <SQLiteCpp/Exception.h>

#include <string>

#include "schema/file/map_database.h"
#include "schema/file/map_tables.h"
#include "schema/layers/layers.h"
#include "schema/tables/memory.h"
#include "schema/tables/table_writer.h"

namespace waystone {
namespace {

void WriteInfo(const MapInfo& info, RowSink& sink) {
  TableWriter<kMapTable>(sink).Row(1, info.name, info.program, info.feature_type,
                                   info.options_json);
}

void WriteSequences(const MapData& map, RowSink& sink) {
  TableWriter<kSequencesTable> writer(sink);
  for (const Sequence& sequence : map.sequences) {
    const auto write = [&](const auto&... camera) {
      writer.Row(sequence.id, sequence.name, sequence.kind, sequence.frames, sequence.skipped,
                 camera...);
    };
    if (sequence.camera) {
      const Camera& camera = *sequence.camera;
      write(camera.model, camera.width, camera.height, EncodeParameters(camera.params));
    } else {
      write(nullptr, nullptr, nullptr, nullptr);
    }
  }
}

void WriteTables(const MapData& map, RowSink& sink) {
  WriteInfo(map.info, sink);
  WriteSequences(map, sink);
  for (const StoredLayer& layer : StoredLayers()) layer.write(map, sink);
}

}  // namespace

void WriteDatabase(const MapData& map, const std::filesystem::path& path) {
  SQLite::Database database = OpenForWriting(path);
  try {
    database.exec("BEGIN");  // after an error the file is thrown away
    database.exec("PRAGMA application_id = " + std::to_string(kApplicationId));
    ApplyMigrations(database, Migrations(), 0);
    RowSink sink(database);
    WriteTables(map, sink);
    WriteContents(database, ExpectedObjects(Migrations()));
    database.exec("COMMIT");
  } catch (const SQLite::Exception& error) {
    CheckMemory(error);
    throw SQLite::Exception(DescribeError(database, error));
  }
}

int64_t EstimateBytes(const MapData& map) {
  constexpr int64_t kEmptyFile = 60'000;
  RowSink counter;
  WriteTables(map, counter);
  return kEmptyFile + counter.bytes();
}

}  // namespace waystone
