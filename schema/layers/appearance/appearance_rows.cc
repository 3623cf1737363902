// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <string>
#include <unordered_map>

#include "core/features/descriptor_codes.h"
#include "schema/layers/layer_rows.h"
#include "schema/tables/blob.h"
#include "schema/tables/insert.h"
#include "schema/tables/table_rows.h"

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
  void ForEach(const char* table, const std::string& columns, int key_columns, Each each) {
    ForEachRow(database_, problems_, table, columns, key_columns, each);
  }

  AppearanceNode& NodeOf(int64_t id) {
    const auto found = nodes_.find(id);
    if (found != nodes_.end()) return layer_.nodes[found->second];
    throw MapError(ErrorCode::kMapDamaged, "there is no appearance node " + std::to_string(id));
  }

  // A row of a layer that isn't there belongs to nothing.
  void RequireLayer() const {
    if (found_) return;
    throw MapError(ErrorCode::kMapDamaged, "appearance_layer has no row");
  }

  void ReadSettings() {
    ForEach("appearance_layer",
            "id, signature_rows, k1, k2, top_rad, bottom_rad, normalised, metres_per_unit, dropped",
            1, [&](Row& row) {
              row.Int64(1, 1);
              SignatureOptions& described = layer_.described;
              described.rows = row.Int(1, kMaxSignatureSide);
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

  void ReadNodes() {
    ForEach("appearance_nodes", "id, sequence, frame, source, time_s, x, y, theta_rad", 1,
            [&](Row& row) {
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
    ForEach("appearance_signatures", "node, magnitudes_crc32c, magnitudes, phases_crc32c, phases",
            1, [&](Row& row) {
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
    ForEach("appearance_features",
            "node, feature_count, bearings_crc32c, bearings, codes_crc32c, codes", 1,
            [&](Row& row) {
              NodeFeatures& features = NodeOf(row.Int64(1)).features;
              const int64_t count = row.Int(1);
              features.bearings = DecodeBearings(row.Blob(count * kBearingBytes));
              const BytesView codes = row.Blob(count * code_bytes_);
              features.codes = Descriptors(code_bytes_, {codes.begin(), codes.end()});
            });
  }

  void ReadImages() {
    ForEach("appearance_images", "node, jpeg_crc32c, jpeg", 1, [&](Row& row) {
      AppearanceNode& node = NodeOf(row.Int64(1));
      const BytesView jpeg = row.BlobOfRows(1);
      node.jpeg.assign(jpeg.begin(), jpeg.end());
    });
  }

  void ReadEdges() {
    ForEach("appearance_edges", "a, b, kind, distance, x, y, heading_rad, deviation_rad", 2,
            [&](Row& row) {
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

  // 1 is by appearance alone, 2 verified.
  std::optional<AppearanceVerdict>& VerdictOf(int64_t id) {
    return id == kAloneVerdict ? layer_.verdict : layer_.verified_verdict;
  }

  void ReadVerdicts() {
    ForEach("appearance_verdict", "id, intercept, positives, negatives", 1, [&](Row& row) {
      RequireLayer();
      std::optional<AppearanceVerdict>& verdict =
          VerdictOf(row.Int64(kAloneVerdict, kVerifiedVerdict));
      verdict.emplace();
      verdict->intercept = row.Real();
      verdict->positives = row.Int();
      verdict->negatives = row.Int();
    });
    ForEach("appearance_verdict_terms", "id, verdict, name, weight", 1, [&](Row& row) {
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

void WriteNodes(const AppearanceLayer& layer, SQLite::Database& database) {
  Insert nodes(database, "appearance_nodes", 8);
  Insert signatures(database,
                    "appearance_signatures (node, magnitudes_crc32c, magnitudes, phases_crc32c,"
                    " phases)",
                    5);
  Insert images(database, "appearance_images", 3);
  for (const AppearanceNode& node : layer.nodes) {
    nodes.Row(node.id.value, node.sequence.value, node.frame, node.source, node.time_s, node.pose.x,
              node.pose.y, node.pose.theta_rad);
    const Bytes magnitudes = EncodeHalves(node.signature.magnitudes);
    const Bytes phases = EncodeHalves(node.signature.phases);
    signatures.Row(node.id.value, CheckedBlob{magnitudes}, CheckedBlob{phases});
    if (!node.jpeg.empty()) images.Row(node.id.value, CheckedBlob{node.jpeg});
  }
}

void WriteFeatures(const AppearanceLayer& layer, SQLite::Database& database) {
  Insert insert(database,
                "appearance_features (node, feature_count, bearings_crc32c, bearings,"
                " codes_crc32c, codes)",
                6);
  for (const AppearanceNode& node : layer.nodes) {
    const NodeFeatures& features = node.features;
    if (features.bearings.empty()) continue;
    const Bytes bearings = EncodeBearings(features.bearings);
    insert.Row(node.id.value, std::ssize(features.bearings), CheckedBlob{bearings},
               CheckedBlob{features.codes.data()});
  }
}

void WriteEdges(const AppearanceLayer& layer, SQLite::Database& database) {
  Insert insert(database, "appearance_edges", 8);
  for (const AppearanceEdge& edge : layer.edges) {
    insert.Row(edge.a.value, edge.b.value, static_cast<int>(edge.kind), edge.distance,
               edge.a_from_b.x, edge.a_from_b.y, edge.a_from_b.theta_rad, edge.sigma_rad);
  }
}

void WriteVerdicts(const AppearanceLayer& layer, SQLite::Database& database) {
  Insert models(database, "appearance_verdict", 4);
  Insert terms(database, "appearance_verdict_terms", 4);
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
                                              const ReadOptions& options,
                                              std::vector<MapProblem>& problems) {
  return AppearanceReader(database, type, problems).Read(options.images);
}

void WriteAppearance(const AppearanceLayer& layer, SQLite::Database& database) {
  const SignatureOptions& d = layer.described;
  Insert(database, "appearance_layer", 9)
      .Row(1, d.rows, d.k1, d.k2, d.band.top_rad, d.band.bottom_rad, d.normalise ? 1 : 0,
           layer.metres_per_unit, layer.dropped);
  WriteNodes(layer, database);
  WriteFeatures(layer, database);
  WriteEdges(layer, database);
  WriteVerdicts(layer, database);
}

}  // namespace waystone
