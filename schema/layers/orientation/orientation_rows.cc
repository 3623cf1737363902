// SPDX-License-Identifier: Apache-2.0
#include <string>
#include <unordered_map>

#include "schema/layers/layer_rows.h"
#include "schema/layers/orientation/orientation_tables.h"
#include "schema/tables/blob.h"
#include "schema/tables/table_rows.h"
#include "schema/tables/table_writer.h"

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
    ForEach(kOrientationLayerTable, [&](Row& row) {
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
  template <class Each>
  void ForEach(const TableView& table, Each each) {
    ForEachRowOfLayer(database_, problems_, table, kOrientationLayerTable, found_, each);
  }

  void ReadFrames() {
    ForEach(kOrientationFramesTable, [&](Row& row) {
      OrientationFrame frame;
      frame.id = {row.Int64(1)};
      frame.sequence = {row.Int64(1)};
      frame.frame = row.Int();
      frame.source = row.Text();
      frame.time_s = row.OptionalReal();
      frame.reliable = row.Int(0, 1) == 1;
      for (int& lines : frame.lines) lines = row.Int();
      if (row.IsNull()) {
        row.SkipRest();
      } else {
        frame.rotation = ReadRotation(row);
      }
      layer_.frames.push_back(std::move(frame));
    });
  }

  void ReadTurns() {
    ForEach(kOrientationTurnsTable, [&](Row& row) {
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
    ForEach(kOrientationNodesTable, [&](Row& row) {
      OrientationNode node;
      node.frame = {row.Int64(1)};
      node.kind = static_cast<OrientationNodeKind>(row.Int(0, kLastNodeKind));
      for (int& lines : node.directions) lines = row.Int();
      nodes_.emplace(node.frame.value, layer_.nodes.size());
      layer_.nodes.push_back(std::move(node));
    });
  }

  void ReadImages() {
    ForEach(kOrientationImagesTable, [&](Row& row) {
      const int64_t id = row.Int64(1);
      const auto found = nodes_.find(id);
      if (found == nodes_.end()) {
        throw MapError(ErrorCode::kMapDamaged,
                       "there is no orientation node " + std::to_string(id));
      }
      const BytesView picture = row.BlobOfRows(1);
      layer_.nodes[found->second].picture.assign(picture.begin(), picture.end());
    });
  }

  void ReadEdges() {
    ForEach(kOrientationEdgesTable, [&](Row& row) {
      OrientationEdge edge;
      edge.a = {row.Int64(1)};
      edge.b = {row.Int64(1)};
      edge.kind = static_cast<OrientationEdgeKind>(row.Int(0, kLastOrientationEdgeKind));
      edge.matches = row.Int();
      layer_.edges.push_back(edge);
    });
  }

  void ReadCorridors() {
    ForEach(kCorridorsTable, [&](Row& row) {
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

void WriteFrames(const OrientationLayer& layer, RowSink& sink) {
  TableWriter<kOrientationFramesTable> writer(sink);
  for (const OrientationFrame& frame : layer.frames) {
    const auto write = [&](const auto&... rotation) {
      writer.Row(frame.id, frame.sequence, frame.frame, frame.source, frame.time_s, frame.reliable,
                 frame.lines[0], frame.lines[1], frame.lines[2], rotation...);
    };
    if (frame.rotation) {
      const Eigen::Quaterniond& q = frame.rotation->building_from_rig;
      write(q.w(), q.x(), q.y(), q.z(), EncodeMatrix(frame.rotation->covariance));
    } else {
      write(nullptr, nullptr, nullptr, nullptr, nullptr);
    }
  }
}

void WriteTurns(const OrientationLayer& layer, RowSink& sink) {
  TableWriter<kOrientationTurnsTable> writer(sink);
  for (const OrientationTurn& turn : layer.turns) {
    writer.Row(turn.frame, turn.direction, turn.angle_rad, turn.confirmed, turn.axis_after);
  }
}

void WriteNodes(const OrientationLayer& layer, RowSink& sink) {
  TableWriter<kOrientationNodesTable> nodes(sink);
  TableWriter<kOrientationImagesTable> images(sink);
  for (const OrientationNode& node : layer.nodes) {
    const auto& [up, right, down, left] = node.directions;
    nodes.Row(node.frame, node.kind, up, right, down, left);
    if (!node.picture.empty()) images.Row(node.frame, node.picture);
  }
}

}  // namespace

std::optional<OrientationLayer> ReadOrientation(SQLite::Database& database, bool images,
                                                std::vector<MapProblem>& problems) {
  return OrientationReader(database, problems).Read(images);
}

void WriteOrientation(const OrientationLayer& layer, RowSink& sink) {
  TableWriter<kOrientationLayerTable>(sink).Row(1, layer.step);
  WriteFrames(layer, sink);
  WriteTurns(layer, sink);
  WriteNodes(layer, sink);
  TableWriter<kOrientationEdgesTable> edges(sink);
  for (const OrientationEdge& edge : layer.edges) {
    edges.Row(edge.a, edge.b, edge.kind, edge.matches);
  }
  TableWriter<kCorridorsTable> corridors(sink);
  for (const Corridor& corridor : layer.corridors) {
    corridors.Row(corridor.first, corridor.last, corridor.axis);
  }
}

}  // namespace waystone
