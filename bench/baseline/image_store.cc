// SPDX-License-Identifier: Apache-2.0
#include "bench/baseline/image_store.h"

#include <SQLiteCpp/Database.h>
#include <SQLiteCpp/Statement.h>
#include <SQLiteCpp/Transaction.h>

#include "core/base/error.h"
#include "schema/layers/layer_blobs.h"

namespace waystone::bench {
namespace {

constexpr char kTables[] = R"(
CREATE TABLE nodes (
  id INTEGER PRIMARY KEY,
  frame INTEGER NOT NULL,
  feature_type INTEGER NOT NULL,
  width INTEGER NOT NULL,
  height INTEGER NOT NULL,
  keypoints_crc32c INTEGER NOT NULL,
  descriptors_crc32c INTEGER NOT NULL,
  keypoints BLOB NOT NULL,
  descriptors BLOB NOT NULL
) STRICT;
CREATE TABLE edges (
  a INTEGER NOT NULL REFERENCES nodes,
  b INTEGER NOT NULL REFERENCES nodes,
  inliers INTEGER NOT NULL,
  homography_crc32c INTEGER NOT NULL,
  homography BLOB NOT NULL,
  PRIMARY KEY (a, b)
) STRICT, WITHOUT ROWID;
)";

void BindBlob(SQLite::Statement& statement, int index, BytesView bytes) {
  statement.bindNoCopy(index, bytes.empty() ? "" : static_cast<const void*>(bytes.data()),
                       static_cast<int>(bytes.size()));
}

void BindCrc(SQLite::Statement& statement, int index, BytesView bytes) {
  statement.bind(index, static_cast<int64_t>(Crc32c(bytes)));
}

Bytes KeypointBytes(const Features& features) {
  std::vector<PlaneFeature> rows;
  for (const Keypoint& keypoint : features.keypoints) rows.push_back({keypoint, 0, 0});
  return EncodeKeypoints(rows);
}

void WriteNodes(const ImageGraph& graph, SQLite::Database& database) {
  SQLite::Statement insert(database, "INSERT INTO nodes VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?)");
  for (const ImageNode& node : graph.nodes) {
    const Bytes keypoints = KeypointBytes(node.features);
    const Bytes& descriptors = node.features.descriptors.data();
    insert.bind(1, node.id.value);
    insert.bind(2, node.frame);
    insert.bind(3, static_cast<int>(node.features.type));
    insert.bind(4, node.features.width);
    insert.bind(5, node.features.height);
    BindCrc(insert, 6, keypoints);
    BindCrc(insert, 7, descriptors);
    BindBlob(insert, 8, keypoints);
    BindBlob(insert, 9, descriptors);
    insert.exec();
    insert.reset();
  }
}

void WriteEdges(const ImageGraph& graph, SQLite::Database& database) {
  SQLite::Statement insert(database, "INSERT INTO edges VALUES (?, ?, ?, ?, ?)");
  for (const ImageEdge& edge : graph.edges) {
    const Bytes homography = EncodeMatrix(edge.b_from_a);
    insert.bind(1, edge.a.value);
    insert.bind(2, edge.b.value);
    insert.bind(3, edge.inliers);
    BindCrc(insert, 4, homography);
    BindBlob(insert, 5, homography);
    insert.exec();
    insert.reset();
  }
}

// The blob in column `blob`, whose CRC is in column `crc`.
BytesView CheckedBlob(SQLite::Statement& row, int crc, int blob, size_t row_bytes) {
  const SQLite::Column column = row.getColumn(blob);
  const BytesView bytes{static_cast<const uint8_t*>(column.getBlob()),
                        static_cast<size_t>(column.getBytes())};
  if (Crc32c(bytes) != row.getColumn(crc).getUInt() || bytes.size() % row_bytes != 0) {
    throw MapError(ErrorCode::kMapDamaged, "image graph: a blob is damaged; write it again");
  }
  return bytes;
}

std::vector<Keypoint> DecodeKeypoints(BytesView bytes) {
  const size_t count = bytes.size() / kKeypointBytes;
  const Bytes votes(count * kVotesBytes);
  std::vector<Keypoint> keypoints;
  for (const PlaneFeature& row : DecodeFeatures(bytes, votes)) keypoints.push_back(row.reference);
  return keypoints;
}

ImageNode ReadNode(SQLite::Statement& row) {
  ImageNode node;
  node.id = KeyframeId{row.getColumn(0).getInt64()};
  node.frame = row.getColumn(1).getInt();
  Features& features = node.features;
  features.type = static_cast<FeatureType>(row.getColumn(2).getInt());
  features.width = row.getColumn(3).getInt();
  features.height = row.getColumn(4).getInt();
  features.keypoints = DecodeKeypoints(CheckedBlob(row, 5, 7, kKeypointBytes));
  const int bytes = DescriptorBytes(features.type);
  const BytesView descriptors = CheckedBlob(row, 6, 8, bytes);
  features.descriptors = Descriptors(bytes, {descriptors.begin(), descriptors.end()});
  return node;
}

}  // namespace

void WriteImageGraph(const ImageGraph& graph, const std::filesystem::path& path) {
  std::filesystem::remove(path);
  try {
    SQLite::Database database(path.string(), SQLite::OPEN_READWRITE | SQLite::OPEN_CREATE);
    database.exec("PRAGMA journal_mode = OFF");
    database.exec("PRAGMA synchronous = OFF");
    SQLite::Transaction transaction(database);
    database.exec(kTables);
    WriteNodes(graph, database);
    WriteEdges(graph, database);
    transaction.commit();
  } catch (const SQLite::Exception& error) {
    throw MapError(ErrorCode::kFileUnwritable, path.string() + ": " + error.what());
  }
}

ImageGraph ReadImageGraph(const std::filesystem::path& path) {
  ImageGraph graph;
  try {
    SQLite::Database database(path.string(), SQLite::OPEN_READONLY);
    SQLite::Statement nodes(database, "SELECT * FROM nodes ORDER BY id");
    while (nodes.executeStep()) graph.nodes.push_back(ReadNode(nodes));
    SQLite::Statement edges(database, "SELECT * FROM edges ORDER BY a, b");
    while (edges.executeStep()) {
      graph.edges.push_back({KeyframeId{edges.getColumn(0).getInt64()},
                             KeyframeId{edges.getColumn(1).getInt64()}, edges.getColumn(2).getInt(),
                             DecodeMatrix(CheckedBlob(edges, 3, 4, kMatrixBytes))});
    }
  } catch (const SQLite::Exception& error) {
    throw MapError(ErrorCode::kMapDamaged, path.string() + ": " + error.what());
  }
  return graph;
}

}  // namespace waystone::bench
