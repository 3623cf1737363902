// SPDX-License-Identifier: Apache-2.0
#include "schema/file/map_writer.h"

#include <SQLiteCpp/Exception.h>
#include <SQLiteCpp/Transaction.h>

#include <string>

#include "schema/file/map_database.h"
#include "schema/layers/layer_rows.h"
#include "schema/tables/blob.h"
#include "schema/tables/insert.h"

namespace waystone {
namespace {

void WriteInfo(const MapInfo& info, SQLite::Database& database) {
  Insert(database, "map", 5)
      .Row(1, info.name, info.program, static_cast<int>(info.feature_type), info.options_json);
}

void WriteSequences(const MapData& map, SQLite::Database& database) {
  Insert insert(database, "sequences", 10);
  for (const Sequence& sequence : map.sequences) {
    const auto write = [&](const auto&... camera) {
      insert.Row(sequence.id.value, sequence.name, sequence.kind, sequence.frames, sequence.skipped,
                 camera...);
    };
    if (sequence.camera) {
      const Camera& camera = *sequence.camera;
      const Bytes parameters = EncodeParameters(camera.params);
      write(static_cast<int>(camera.model), camera.width, camera.height, CheckedBlob{parameters});
    } else {
      write(nullptr, nullptr, nullptr, nullptr, nullptr);
    }
  }
}

void WriteKeyframes(const MapData& map, SQLite::Database& database) {
  Insert insert(database, "keyframes", 8);
  for (const Keyframe& keyframe : map.keyframes) {
    insert.Row(keyframe.id.value, keyframe.sequence.value, keyframe.stretch, keyframe.frame,
               keyframe.source, keyframe.time_s, keyframe.width, keyframe.height);
  }
}

void WriteImages(const MapData& map, SQLite::Database& database) {
  Insert insert(database, "keyframe_images", 3);
  for (const Keyframe& keyframe : map.keyframes) {
    if (!keyframe.jpeg.empty()) insert.Row(keyframe.id.value, CheckedBlob{keyframe.jpeg});
  }
}

void WritePlanes(const MapData& map, SQLite::Database& database) {
  Insert insert(database, "planes", 6);
  for (const Plane& plane : map.planes) {
    const Bytes outline = EncodeOutline(plane.outline);
    insert.Row(plane.id.value, plane.reference.value, static_cast<int64_t>(plane.features.size()),
               static_cast<int64_t>(plane.outline.size()), CheckedBlob{outline});
  }
}

void WriteFeatures(const MapData& map, SQLite::Database& database) {
  Insert insert(database,
                "plane_features (plane, keypoints_crc32c, keypoints, votes_crc32c, votes,"
                " descriptors_crc32c, descriptors)",
                7);
  for (const Plane& plane : map.planes) {
    const Bytes keypoints = EncodeKeypoints(plane.features);
    const Bytes votes = EncodeVotes(plane.features);
    insert.Row(plane.id.value, CheckedBlob{keypoints}, CheckedBlob{votes},
               CheckedBlob{plane.descriptors.data()});
  }
}

void WriteViews(const MapData& map, SQLite::Database& database) {
  Insert insert(database, "plane_views", 5);
  for (const Plane& plane : map.planes) {
    for (const PlaneView& view : plane.views) {
      const Bytes homography = EncodeMatrix(view.reference_from_keyframe);
      insert.Row(plane.id.value, view.keyframe.value, view.inliers, CheckedBlob{homography});
    }
  }
}

void WriteEdges(const MapData& map, SQLite::Database& database) {
  Insert insert(database, "edges", 7);
  for (const Edge& edge : map.edges) {
    const Bytes homology = EncodeMatrix(edge.homology);
    insert.Row(edge.a.value, edge.b.value, edge.from.value, edge.to.value, edge.third_eigenvalue,
               CheckedBlob{homology});
  }
}

void WriteIndex(const MapData& map, SQLite::Database& database) {
  if (!map.index) return;
  const Bytes lists = EncodeLists(map.index->list_of_row);
  Insert insert(database,
                "search_index (id, format, list_count, feature_count, centres_crc32c, centres,"
                " lists_crc32c, lists)",
                8);
  insert.Row(1, kInvertedFileFormat, map.index->centres.rows(),
             static_cast<int64_t>(map.index->list_of_row.size()),
             CheckedBlob{map.index->centres.data()}, CheckedBlob{lists});
}

void WriteVerdictModel(const MapData& map, SQLite::Database& database) {
  if (!map.verdict) return;
  Insert insert(database, "verdict_model", 6);
  insert.Row(1, map.verdict->intercept, map.verdict->log_inliers, map.verdict->inlier_share,
             map.verdict->positives, map.verdict->negatives);
}

void WriteTables(const MapData& map, SQLite::Database& database) {
  WriteInfo(map.info, database);
  WriteSequences(map, database);
  WriteKeyframes(map, database);
  WriteImages(map, database);
  WritePlanes(map, database);
  WriteFeatures(map, database);
  WriteViews(map, database);
  WriteEdges(map, database);
  WriteIndex(map, database);
  WriteVerdictModel(map, database);
  if (map.appearance) WriteAppearance(*map.appearance, database);
  if (map.orientation) WriteOrientation(*map.orientation, database);
}

constexpr int64_t kRow = 100;  // bytes of a row besides its blobs

int64_t BytesOf(const AppearanceLayer& layer) {
  int64_t bytes = std::ssize(layer.edges) * kRow;
  for (const AppearanceNode& node : layer.nodes) {
    const int64_t values = node.signature.magnitudes.size() + node.signature.phases.size();
    bytes += 2 * kRow + values * kHalfBytes + std::ssize(node.jpeg) +
             std::ssize(node.features.bearings) * kBearingBytes +
             std::ssize(node.features.codes.data());
  }
  return bytes;
}

int64_t BytesOf(const OrientationLayer& layer) {
  int64_t bytes = std::ssize(layer.edges) * kRow;
  for (const OrientationNode& node : layer.nodes) bytes += kRow + std::ssize(node.jpeg);
  return bytes + std::ssize(layer.frames) * (kRow + kMatrixBytes);
}

}  // namespace

void WriteDatabase(const MapData& map, const std::filesystem::path& path) {
  SQLite::Database database = OpenForWriting(path);
  try {
    SQLite::Transaction transaction(database);
    database.exec("PRAGMA application_id = " + std::to_string(kApplicationId));
    ApplyMigrations(database, Migrations(), 0);
    WriteTables(map, database);
    WriteContents(database, ExpectedObjects(Migrations()));
    transaction.commit();
  } catch (const SQLite::Exception& error) {
    throw SQLite::Exception(DescribeError(database, error));
  }
}

int64_t EstimatedBytes(const MapData& map) {
  constexpr int64_t kEmptyFile = 60'000;
  int64_t bytes = kEmptyFile;
  for (const Keyframe& keyframe : map.keyframes) bytes += kRow + std::ssize(keyframe.jpeg);
  for (const Plane& plane : map.planes) {
    bytes += kRow + std::ssize(plane.features) * (kKeypointBytes + kVotesBytes) +
             std::ssize(plane.descriptors.data()) + std::ssize(plane.views) * kRow;
  }
  if (map.index) {
    bytes +=
        std::ssize(map.index->centres.data()) + std::ssize(map.index->list_of_row) * kListBytes;
  }
  if (map.appearance) bytes += BytesOf(*map.appearance);
  if (map.orientation) bytes += BytesOf(*map.orientation);
  return bytes + std::ssize(map.edges) * kRow;
}

}  // namespace waystone
