// SPDX-License-Identifier: Apache-2.0
#include "tests/schema/map_summary.h"

#include <cstdio>
#include <type_traits>

#include "schema/layers/layer_blobs.h"

namespace waystone {
namespace {

std::string Shown(const std::string& text) {
  constexpr const char* kHex = "0123456789abcdef";
  std::string hex;
  for (const char c : text) {
    hex += kHex[static_cast<uint8_t>(c) >> 4];
    hex += kHex[c & 15];
  }
  return hex.empty() ? "''" : hex;
}

std::string Shown(double value) {
  char text[32];
  std::snprintf(text, sizeof(text), "%.17g", value);
  return text;
}

template <class Value>
requires std::is_integral_v<Value> std::string Shown(Value value) { return std::to_string(value); }

template <class Tag>
std::string Shown(Id<Tag> id) {
  return std::to_string(id.value);
}

std::string Shown(BytesView blob) { return std::to_string(Crc32c(blob)); }
std::string Shown(const Bytes& blob) { return Shown(BytesView(blob)); }

template <class Value>
std::string Shown(const std::optional<Value>& value) {
  return value ? Shown(*value) : "-";
}

class Summary {
 public:
  template <class... Values>
  void Line(const std::string& name, const Values&... values) {
    text_ += name;
    ((text_ += " " + Shown(values)), ...);
    text_ += "\n";
  }
  const std::string& text() const { return text_; }

 private:
  std::string text_;
};

void AddSequences(const MapData& map, Summary& summary) {
  for (const Sequence& s : map.sequences) {
    std::optional<int> model, width, height;
    std::optional<Bytes> params;
    if (s.camera) {
      model = static_cast<int>(s.camera->model);
      width = s.camera->width;
      height = s.camera->height;
      params = EncodeParameters(s.camera->params);
    }
    summary.Line("sequence", s.id, s.name, s.kind, s.frames, s.skipped, model, width, height,
                 params);
  }
}

void AddKeyframes(const MapData& map, Summary& summary) {
  for (const Keyframe& k : map.keyframes) {
    summary.Line("keyframe", k.id, k.sequence, k.stretch, k.frame, k.source, k.time_s, k.width,
                 k.height);
  }
  for (const Keyframe& k : map.keyframes) {
    if (!k.picture.empty()) summary.Line("picture", k.id, BytesView(k.picture));
  }
  for (const Keyframe& k : map.keyframes) {
    const Landmarks& landmarks = k.landmarks;
    if (landmarks.size() == 0) continue;
    summary.Line("landmarks", k.id, landmarks.size(), EncodePositions(landmarks.positions),
                 BytesView(landmarks.codes.data()));
  }
}

void AddPlanes(const MapData& map, Summary& summary) {
  for (const Plane& p : map.planes) {
    summary.Line("plane", p.id, p.reference, p.features.size(), p.outline.size(),
                 EncodeOutline(p.outline));
  }
  for (const Plane& p : map.planes) {
    summary.Line("features", p.id, EncodeKeypoints(p.features), EncodeVotes(p.features),
                 BytesView(p.descriptors.data()));
  }
  for (const Plane& p : map.planes) {
    for (const PlaneView& view : p.views) {
      summary.Line("view", p.id, view.keyframe, view.inliers,
                   EncodeMatrix(view.reference_from_keyframe));
    }
  }
  for (const Edge& edge : map.edges) {
    summary.Line("edge", edge.a, edge.b, edge.from, edge.to, edge.third_eigenvalue,
                 EncodeMatrix(edge.homology));
  }
  if (map.index) {
    summary.Line("index", map.index->centres.rows(), map.index->list_of_row.size(),
                 BytesView(map.index->centres.data()), EncodeLists(map.index->list_of_row));
  }
  if (map.verdict) {
    summary.Line("verdict", map.verdict->intercept, map.verdict->log_inliers,
                 map.verdict->inlier_share, map.verdict->positives, map.verdict->negatives);
  }
}

void AddModels(const AppearanceLayer& layer, Summary& summary) {
  const std::array models{&layer.verdict, &layer.verified_verdict};
  for (size_t i = 0; i < models.size(); ++i) {
    if (const auto& model = *models[i]) {
      summary.Line("model", i + 1, model->intercept, model->positives, model->negatives);
    }
  }
  for (size_t i = 0; i < models.size(); ++i) {
    if (!*models[i]) continue;
    for (const VerdictTerm& term : (*models[i])->terms) {
      summary.Line("term", i + 1, term.name, term.weight);
    }
  }
}

void AddAppearance(const AppearanceLayer& layer, Summary& summary) {
  const SignatureOptions& d = layer.described;
  summary.Line("appearance", d.rows, d.k1, d.k2, d.band.top_rad, d.band.bottom_rad,
               static_cast<int>(d.normalise), layer.metres_per_unit, layer.dropped);
  for (const AppearanceNode& n : layer.nodes) {
    summary.Line("node", n.id, n.sequence, n.frame, n.source, n.time_s, n.pose.x, n.pose.y,
                 n.pose.theta_rad);
  }
  for (const AppearanceNode& n : layer.nodes) {
    summary.Line("signature", n.id, EncodeHalves(n.signature.magnitudes),
                 EncodeHalves(n.signature.phases));
  }
  for (const AppearanceNode& n : layer.nodes) {
    if (n.features.bearings.empty()) continue;
    summary.Line("bearings", n.id, n.features.bearings.size(), EncodeBearings(n.features.bearings),
                 BytesView(n.features.codes.data()));
  }
  for (const AppearanceEdge& e : layer.edges) {
    summary.Line("relation", e.a, e.b, static_cast<int>(e.kind), e.distance, e.a_from_b.x,
                 e.a_from_b.y, e.a_from_b.theta_rad, e.sigma_rad);
  }
  AddModels(layer, summary);
}

void AddOrientation(const OrientationLayer& layer, Summary& summary) {
  summary.Line("orientation", layer.step);
  for (const OrientationFrame& f : layer.frames) {
    std::array<std::optional<double>, 4> q;
    std::optional<Bytes> covariance;
    if (f.rotation) {
      const Eigen::Quaterniond& rotation = f.rotation->building_from_rig;
      q = {rotation.w(), rotation.x(), rotation.y(), rotation.z()};
      covariance = EncodeMatrix(f.rotation->covariance);
    }
    summary.Line("frame", f.id, f.sequence, f.frame, f.source, f.time_s,
                 static_cast<int>(f.reliable), f.lines[0], f.lines[1], f.lines[2], q[0], q[1], q[2],
                 q[3], covariance);
  }
  for (const OrientationNode& n : layer.nodes) {
    const auto& [up, right, down, left] = n.directions;
    summary.Line("direction", n.frame, static_cast<int>(n.kind), up, right, down, left);
  }
  for (const OrientationEdge& e : layer.edges) {
    summary.Line("traversal", e.a, e.b, static_cast<int>(e.kind), e.matches);
  }
}

}  // namespace

std::string SummariseMap(const MapData& map) {
  Summary summary;
  summary.Line("map", map.info.name, map.info.program, static_cast<int>(map.info.feature_type),
               map.info.options_json.size());
  AddSequences(map, summary);
  AddKeyframes(map, summary);
  AddPlanes(map, summary);
  if (map.appearance) AddAppearance(*map.appearance, summary);
  if (map.orientation) AddOrientation(*map.orientation, summary);
  return summary.text();
}

}  // namespace waystone
