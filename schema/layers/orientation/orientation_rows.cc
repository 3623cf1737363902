// SPDX-License-Identifier: Apache-2.0
#include <string>
#include <unordered_map>

#include "schema/layers/layer_rows.h"
#include "schema/tables/blob.h"
#include "schema/tables/insert.h"
#include "schema/tables/table_rows.h"

namespace waystone {
namespace {

constexpr int kLastNodeKind = static_cast<int>(OrientationNodeKind::kTurn);
constexpr int kLastOrientationEdgeKind = static_cast<int>(OrientationEdgeKind::kLoop);

BuildingRotation ReadRotation(Row& row) {
  BuildingRotation rotation;
  Eigen::Quaterniond& q = rotation.building_from_rig;
  q.w() = row.Real();
  q.x() = row.Real();
  q.y() = row.Real();
  q.z() = row.Real();
  rotation.covariance = DecodeMatrix(row.Blob(kMatrixBytes));
  return rotation;
}

class OrientationReader {
 public:
  OrientationReader(SQLite::Database& database, std::vector<MapProblem>& problems)
      : database_(database), problems_(problems) {}

  std::optional<OrientationLayer> Read(bool images) {
    ForEach("orientation_layer", "id, step", 1, [&](Row& row) {
      row.Int64(1, 1);
      layer_.step = row.Int(1);
      found_ = true;
    });
    ReadFrames();
    ReadTurns();
    ReadNodes();
    if (images) ReadImages();
    ReadEdges();
    ReadCorridors();
    if (!found_) return {};
    return std::move(layer_);
  }

 private:
  // Rows of a layer that isn't there belong to nothing.
  template <class Each>
  void ForEach(const char* table, const std::string& columns, int key_columns, Each each) {
    ForEachRow(database_, problems_, table, columns, key_columns, [&](Row& row) {
      if (!found_ && std::string_view(table) != "orientation_layer") {
        throw MapError(ErrorCode::kMapDamaged, "orientation_layer has no row");
      }
      each(row);
    });
  }

  void ReadFrames() {
    ForEach("orientation_frames",
            "id, sequence, frame, source, time_s, reliable, lines_x, lines_y, lines_z, qw, qx, qy, "
            "qz, covariance_crc32c, covariance",
            1, [&](Row& row) {
              OrientationFrame frame;
              frame.id = {row.Int64(1)};
              frame.sequence = {row.Int64(1)};
              frame.frame = row.Int();
              frame.source = row.Text();
              frame.time_s = row.OptionalReal();
              frame.reliable = row.Int(0, 1) == 1;
              for (int& lines : frame.lines) lines = row.Int();
              if (!row.IsNull()) frame.rotation = ReadRotation(row);
              layer_.frames.push_back(std::move(frame));
            });
  }

  void ReadTurns() {
    ForEach("orientation_turns", "frame, direction, angle_rad, confirmed, axis_after", 1,
            [&](Row& row) {
              OrientationTurn turn;
              turn.frame = {row.Int64(1)};
              turn.direction = row.Int(-1, 1);
              turn.angle_rad = row.Real();
              turn.confirmed = row.Int(0, 1) == 1;
              turn.axis_after = row.Int(0, 1);
              layer_.turns.push_back(turn);
            });
  }

  void ReadNodes() {
    ForEach("orientation_nodes", "frame, kind, up, right, down, left", 1, [&](Row& row) {
      OrientationNode node;
      node.frame = {row.Int64(1)};
      node.kind = static_cast<OrientationNodeKind>(row.Int(0, kLastNodeKind));
      for (int& lines : node.directions) lines = row.Int();
      nodes_.emplace(node.frame.value, layer_.nodes.size());
      layer_.nodes.push_back(std::move(node));
    });
  }

  void ReadImages() {
    ForEach("orientation_images", "frame, jpeg_crc32c, jpeg", 1, [&](Row& row) {
      const int64_t id = row.Int64(1);
      const auto found = nodes_.find(id);
      if (found == nodes_.end()) {
        throw MapError(ErrorCode::kMapDamaged,
                       "there is no orientation node " + std::to_string(id));
      }
      const BytesView jpeg = row.BlobOfRows(1);
      layer_.nodes[found->second].jpeg.assign(jpeg.begin(), jpeg.end());
    });
  }

  void ReadEdges() {
    ForEach("orientation_edges", "a, b, kind, matches", 2, [&](Row& row) {
      OrientationEdge edge;
      edge.a = {row.Int64(1)};
      edge.b = {row.Int64(1)};
      edge.kind = static_cast<OrientationEdgeKind>(row.Int(0, kLastOrientationEdgeKind));
      edge.matches = row.Int();
      layer_.edges.push_back(edge);
    });
  }

  void ReadCorridors() {
    ForEach("corridors", "first_frame, last_frame, axis", 1, [&](Row& row) {
      Corridor corridor;
      corridor.first = {row.Int64(1)};
      corridor.last = {row.Int64(1)};
      corridor.axis = row.Int(0, 1);
      layer_.corridors.push_back(corridor);
    });
  }

  SQLite::Database& database_;
  std::vector<MapProblem>& problems_;
  OrientationLayer layer_;
  bool found_ = false;
  std::unordered_map<int64_t, size_t> nodes_;  // index by frame
};

void WriteFrames(const OrientationLayer& layer, SQLite::Database& database) {
  Insert insert(database, "orientation_frames", 15);
  for (const OrientationFrame& frame : layer.frames) {
    const auto write = [&](const auto&... rotation) {
      insert.Row(frame.id.value, frame.sequence.value, frame.frame, frame.source, frame.time_s,
                 frame.reliable ? 1 : 0, frame.lines[0], frame.lines[1], frame.lines[2],
                 rotation...);
    };
    if (frame.rotation) {
      const Eigen::Quaterniond& q = frame.rotation->building_from_rig;
      const Bytes covariance = EncodeMatrix(frame.rotation->covariance);
      write(q.w(), q.x(), q.y(), q.z(), CheckedBlob{covariance});
    } else {
      write(nullptr, nullptr, nullptr, nullptr, nullptr, nullptr);
    }
  }
}

void WriteTurns(const OrientationLayer& layer, SQLite::Database& database) {
  Insert insert(database, "orientation_turns", 5);
  for (const OrientationTurn& turn : layer.turns) {
    insert.Row(turn.frame.value, turn.direction, turn.angle_rad, turn.confirmed ? 1 : 0,
               turn.axis_after);
  }
}

void WriteNodes(const OrientationLayer& layer, SQLite::Database& database) {
  Insert nodes(database, "orientation_nodes", 6);
  Insert images(database, "orientation_images", 3);
  for (const OrientationNode& node : layer.nodes) {
    const auto& [up, right, down, left] = node.directions;
    nodes.Row(node.frame.value, static_cast<int>(node.kind), up, right, down, left);
    if (!node.jpeg.empty()) images.Row(node.frame.value, CheckedBlob{node.jpeg});
  }
}

}  // namespace

std::optional<OrientationLayer> ReadOrientation(SQLite::Database& database,
                                                const ReadOptions& options,
                                                std::vector<MapProblem>& problems) {
  return OrientationReader(database, problems).Read(options.images);
}

void WriteOrientation(const OrientationLayer& layer, SQLite::Database& database) {
  Insert(database, "orientation_layer", 2).Row(1, layer.step);
  WriteFrames(layer, database);
  WriteTurns(layer, database);
  WriteNodes(layer, database);
  Insert edges(database, "orientation_edges", 4);
  for (const OrientationEdge& edge : layer.edges) {
    edges.Row(edge.a.value, edge.b.value, static_cast<int>(edge.kind), edge.matches);
  }
  Insert corridors(database, "corridors", 3);
  for (const Corridor& corridor : layer.corridors) {
    corridors.Row(corridor.first.value, corridor.last.value, corridor.axis);
  }
}

}  // namespace waystone
