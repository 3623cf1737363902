// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <string>
#include <unordered_map>

#include "core/features/descriptor_codes.h"
#include "schema/layers/appearance/appearance_tables.h"
#include "schema/layers/layer_blobs.h"
#include "schema/layers/layer_rows.h"
#include "schema/tables/blob.h"
#include "schema/tables/table_rows.h"
#include "schema/tables/table_writer.h"

namespace waystone {
namespace {

constexpr int kMaxSignatureSide = 4096;  // what SignatureOptions allow at most
// Ids of the verdicts: stored, never changed.
constexpr int64_t kAloneVerdict = 1;
constexpr int64_t kVerifiedVerdict = 2;
constexpr int kLastAppearanceEdgeKind = static_cast<int>(AppearanceEdgeKind::kLoop);

Pose2 ReadPose(Row& row) {
  const double x = row.Real();
  const double y = row.Real();
  return {x, y, row.Real()};
}

class AppearanceReader {
 public:
  AppearanceReader(SQLite::Database& database, FeatureType type, std::vector<MapProblem>& problems)
      : database_(database), code_bytes_(CodeBytes(type)), problems_(problems) {}

  std::optional<AppearanceLayer> Read(bool images) {
    ReadSettings();
    ReadMirror();
    ReadNodes();
    ReadSignatures();
    ReadFeatures();
    if (images) ReadImages();
    ReadEdges();
    ReadVerdicts();
    if (!found_) return {};
    return std::move(layer_);
  }

 private:
  template <class Each>
  void ForEach(const TableView& table, Each each) {
    ForEachRow(database_, problems_, table, each);
  }

  AppearanceNode& NodeOf(int64_t id) {
    const auto found = nodes_.find(id);
    if (found != nodes_.end()) return layer_.nodes[found->second];
    throw MapError(ErrorCode::kMapDamaged, "there is no appearance node " + std::to_string(id));
  }

  // Refuses rows of a layer that isn't there.
  void RequireLayer() const {
    if (found_) return;
    throw MapError(ErrorCode::kMapDamaged, "appearance_layer has no row");
  }

  void ReadSettings() {
    ForEach(kAppearanceLayerTable, [&](Row& row) {
      row.Int64(1, 1);
      SignatureOptions& described = layer_.described;
      described.rows = row.Int(2, kMaxSignatureSide);
      described.k1 = row.Int(1, kMaxSignatureSide);
      described.k2 = row.Int(1, kMaxSignatureSide);
      described.band.top_rad = row.Real();
      described.band.bottom_rad = row.Real();
      described.normalise = row.Int(0, 1) == 1;
      layer_.metres_per_unit = row.OptionalReal();
      layer_.dropped = row.Int();
      found_ = true;
    });
  }

  void ReadMirror() {
    ForEach(kAppearanceMirrorTable, [&](Row& row) {
      RequireLayer();
      row.Int64(1, 1);
      LayerMirror& mirror = layer_.mirror.emplace();
      mirror.width = row.Int(1);
      mirror.height = row.Int(1);
      mirror.columns = row.Int(1);
      mirror.band.top_rad = row.Real();
      mirror.band.bottom_rad = row.Real();
      mirror.clockwise = row.Int(0, 1) == 1;
      const auto x = row.OptionalReal();
      const auto y = row.OptionalReal();
      const auto inner = row.OptionalReal();
      const auto outer = row.OptionalReal();
      if (x && y && inner && outer) mirror.ring = {{*x, *y}, *inner, *outer};
    });
  }

  void ReadNodes() {
    ForEach(kAppearanceNodesTable, [&](Row& row) {
      RequireLayer();
      AppearanceNode node;
      node.id = {row.Int64(1)};
      node.sequence = {row.Int64(1)};
      node.frame = row.Int();
      node.source = row.Text();
      node.time_s = row.OptionalReal();
      node.pose = ReadPose(row);
      nodes_.emplace(node.id.value, layer_.nodes.size());
      layer_.nodes.push_back(std::move(node));
    });
  }

  void ReadSignatures() {
    const SignatureOptions& d = layer_.described;
    ForEach(kAppearanceSignaturesTable, [&](Row& row) {
      AppearanceNode& node = NodeOf(row.Int64(1));
      const auto matrix = [&](int columns) {
        const int64_t bytes = int64_t{d.rows} * columns * kHalfBytes;
        return DecodeHalves(row.Blob(bytes), d.rows, columns);
      };
      node.signature.magnitudes = matrix(d.k1);
      node.signature.phases = matrix(d.k2);
    });
  }

  void ReadFeatures() {
    ForEach(kAppearanceFeaturesTable, [&](Row& row) {
      NodeFeatures& features = NodeOf(row.Int64(1)).features;
      const int64_t count = row.Int(1);
      features.bearings = DecodeBearings(row.Blob(count * kBearingBytes));
      const BytesView codes = row.Blob(count * code_bytes_);
      features.codes = Descriptors(code_bytes_, {codes.begin(), codes.end()});
    });
  }

  void ReadImages() {
    ForEach(kAppearanceImagesTable, [&](Row& row) {
      AppearanceNode& node = NodeOf(row.Int64(1));
      const BytesView picture = row.BlobOfRows(1);
      node.picture.assign(picture.begin(), picture.end());
    });
  }

  void ReadEdges() {
    ForEach(kAppearanceEdgesTable, [&](Row& row) {
      RequireLayer();
      AppearanceEdge edge;
      edge.a = {row.Int64(1)};
      edge.b = {row.Int64(1)};
      edge.kind = static_cast<AppearanceEdgeKind>(row.Int(0, kLastAppearanceEdgeKind));
      edge.distance = row.Real();
      edge.a_from_b = ReadPose(row);
      edge.sigma_rad = row.Real();
      layer_.edges.push_back(edge);
    });
  }

  // 1 is by appearance only, 2 verified.
  std::optional<AppearanceVerdict>& VerdictOf(int64_t id) {
    return id == kAloneVerdict ? layer_.verdict : layer_.verified_verdict;
  }

  void ReadVerdicts() {
    ForEach(kAppearanceVerdictTable, [&](Row& row) {
      RequireLayer();
      std::optional<AppearanceVerdict>& verdict =
          VerdictOf(row.Int64(kAloneVerdict, kVerifiedVerdict));
      verdict.emplace();
      verdict->intercept = row.Real();
      verdict->positives = row.Int();
      verdict->negatives = row.Int();
    });
    ForEach(kAppearanceVerdictTermsTable, [&](Row& row) {
      row.Int64(1);
      const int64_t id = row.Int64(kAloneVerdict, kVerifiedVerdict);
      std::optional<AppearanceVerdict>& verdict = VerdictOf(id);
      if (!verdict) {
        throw MapError(ErrorCode::kMapDamaged,
                       "appearance_verdict has no row " + std::to_string(id));
      }
      const std::string name = row.Text();
      verdict->terms.push_back({name, row.Real()});
    });
  }

  SQLite::Database& database_;
  int code_bytes_;
  std::vector<MapProblem>& problems_;
  AppearanceLayer layer_;
  bool found_ = false;
  std::unordered_map<int64_t, size_t> nodes_;  // index by id
};

void WriteMirror(const AppearanceLayer& layer, RowSink& sink) {
  TableWriter<kAppearanceMirrorTable> writer(sink);
  if (!layer.mirror) return;
  const LayerMirror& mirror = *layer.mirror;
  const auto of_ring = [&](double value) {
    return mirror.ring ? std::optional(value) : std::nullopt;
  };
  const MirrorRing ring = mirror.ring.value_or(MirrorRing{});
  writer.Row(1, mirror.width, mirror.height, mirror.columns, mirror.band.top_rad,
             mirror.band.bottom_rad, mirror.clockwise, of_ring(ring.centre_px.x),
             of_ring(ring.centre_px.y), of_ring(ring.inner_px), of_ring(ring.outer_px));
}

void WriteNodes(const AppearanceLayer& layer, RowSink& sink) {
  TableWriter<kAppearanceNodesTable> nodes(sink);
  TableWriter<kAppearanceSignaturesTable> signatures(sink);
  TableWriter<kAppearanceImagesTable> images(sink);
  for (const AppearanceNode& node : layer.nodes) {
    nodes.Row(node.id, node.sequence, node.frame, node.source, node.time_s, node.pose.x,
              node.pose.y, node.pose.theta_rad);
    signatures.Row(node.id, EncodeHalves(node.signature.magnitudes),
                   EncodeHalves(node.signature.phases));
    if (!node.picture.empty()) images.Row(node.id, node.picture);
  }
}

void WriteFeatures(const AppearanceLayer& layer, RowSink& sink) {
  TableWriter<kAppearanceFeaturesTable> writer(sink);
  for (const AppearanceNode& node : layer.nodes) {
    const NodeFeatures& features = node.features;
    if (features.bearings.empty()) continue;
    writer.Row(node.id, features.bearings.size(), EncodeBearings(features.bearings),
               features.codes.data());
  }
}

void WriteEdges(const AppearanceLayer& layer, RowSink& sink) {
  TableWriter<kAppearanceEdgesTable> writer(sink);
  for (const AppearanceEdge& edge : layer.edges) {
    writer.Row(edge.a, edge.b, edge.kind, edge.distance, edge.a_from_b.x, edge.a_from_b.y,
               edge.a_from_b.theta_rad, edge.sigma_rad);
  }
}

void WriteVerdicts(const AppearanceLayer& layer, RowSink& sink) {
  TableWriter<kAppearanceVerdictTable> models(sink);
  TableWriter<kAppearanceVerdictTermsTable> terms(sink);
  int term_id = 0;
  const auto write = [&](int64_t id, const std::optional<AppearanceVerdict>& verdict) {
    if (!verdict) return;
    models.Row(id, verdict->intercept, verdict->positives, verdict->negatives);
    for (const VerdictTerm& term : verdict->terms) terms.Row(++term_id, id, term.name, term.weight);
  };
  write(kAloneVerdict, layer.verdict);
  write(kVerifiedVerdict, layer.verified_verdict);
}

}  // namespace

std::optional<AppearanceLayer> ReadAppearance(SQLite::Database& database, FeatureType type,
                                              bool images, std::vector<MapProblem>& problems) {
  return AppearanceReader(database, type, problems).Read(images);
}

void WriteAppearance(const AppearanceLayer& layer, RowSink& sink) {
  const SignatureOptions& d = layer.described;
  TableWriter<kAppearanceLayerTable>(sink).Row(1, d.rows, d.k1, d.k2, d.band.top_rad,
                                               d.band.bottom_rad, d.normalise,
                                               layer.metres_per_unit, layer.dropped);
  WriteMirror(layer, sink);
  WriteNodes(layer, sink);
  WriteFeatures(layer, sink);
  WriteEdges(layer, sink);
  WriteVerdicts(layer, sink);
}

}  // namespace waystone
