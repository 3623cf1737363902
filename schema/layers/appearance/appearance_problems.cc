// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <unordered_set>
#include <utility>

#include "core/base/error.h"
#include "core/features/descriptor_codes.h"
#include "core/geometry/angle.h"
#include "schema/layers/layer_problems.h"

namespace waystone {
namespace {

// Pi as a 16-bit float.
constexpr float kPiAsHalf = 3.140625F;
constexpr int kStraightUp = 16384;  // in kBearingUnit_rad

bool IsFinite(const Pose2& pose) {
  return std::isfinite(pose.x) && std::isfinite(pose.y) && std::isfinite(pose.theta_rad);
}

bool IsWrapped(double angle_rad) { return std::abs(angle_rad) <= kPi; }

// Comparisons are false for NaN.
bool IsBetween(const HalfMatrix& matrix, float low, float high) {
  return std::all_of(matrix.data(), matrix.data() + matrix.size(), [&](Eigen::half value) {
    const auto number = static_cast<float>(value);
    return number >= low && number <= high;
  });
}

bool IsBearing(const Bearing& bearing) { return std::abs(bearing.elevation) <= kStraightUp; }

std::string SizeOf(const HalfMatrix& matrix) {
  return std::to_string(matrix.rows()) + "x" + std::to_string(matrix.cols());
}

class AppearanceProblemFinder {
 public:
  AppearanceProblemFinder(const MapData& map, std::vector<MapProblem>& problems)
      : map_(map), layer_(*map.appearance), problems_(problems) {}

  void Find() {
    CheckSettings();
    for (const AppearanceNode& node : layer_.nodes) CheckNode(node);
    CheckEdges();
    if (layer_.verdict) CheckVerdict(*layer_.verdict, "appearance_verdict 1");
    if (layer_.verified_verdict) CheckVerdict(*layer_.verified_verdict, "appearance_verdict 2");
  }

 private:
  void Require(bool holds, const std::string& where, const std::string& message) {
    if (!holds) problems_.push_back({where, message});
  }

  void CheckSettings() {
    const std::string where = "appearance_layer 1";
    try {
      layer_.described.Check();
    } catch (const MapError& error) {
      problems_.push_back({where, error.what()});
    }
    if (layer_.mirror) CheckMirror(*layer_.mirror);
    const double scale = layer_.metres_per_unit.value_or(1);
    Require(scale > 0 && std::isfinite(scale), where,
            "a unit is " + std::to_string(scale) + " metres");
    Require(layer_.dropped >= 0, where, std::to_string(layer_.dropped) + " nodes dropped");
  }

  void CheckMirror(const LayerMirror& mirror) {
    const std::string where = "appearance_mirror 1";
    Require(mirror.width > 0 && mirror.height > 0, where,
            "images of " + std::to_string(mirror.width) + "x" + std::to_string(mirror.height));
    PanoramaOptions options;
    options.columns = mirror.columns;
    options.mirror_band = mirror.band;
    options.mirror = mirror.ring;
    try {
      options.Check();
    } catch (const MapError& error) {
      problems_.push_back({where, error.what()});
    }
  }

  void CheckNode(const AppearanceNode& node) {
    const std::string where = "appearance_nodes " + std::to_string(node.id.value);
    Require(
        node.id > last_, where,
        "ids must be positive and increasing; the previous one is " + std::to_string(last_.value));
    last_ = node.id;
    nodes_.insert(node.id);
    Require(HasSequence(map_, node.sequence), where,
            "no such sequence: " + std::to_string(node.sequence.value));
    Require(node.frame >= 0, where, "frame " + std::to_string(node.frame) + " is below 0");
    Require(std::isfinite(node.time_s.value_or(0)), where, "its time is not finite");
    Require(IsFinite(node.pose) && IsWrapped(node.pose.theta_rad), where,
            "its pose is not finite or its angle isn't between -pi and pi");
    CheckSignature(node);
    CheckFeatures(node);
  }

  void CheckSignature(const AppearanceNode& node) {
    const std::string where = "appearance_signatures " + std::to_string(node.id.value);
    const SignatureOptions& d = layer_.described;
    const FourierSignature& signature = node.signature;
    const auto has_size = [&](const HalfMatrix& matrix, int columns) {
      return matrix.rows() == d.rows && matrix.cols() == columns;
    };
    Require(has_size(signature.magnitudes, d.k1) && has_size(signature.phases, d.k2), where,
            "magnitudes of " + SizeOf(signature.magnitudes) + " and phases of " +
                SizeOf(signature.phases) + " values; the layer has " + std::to_string(d.rows) +
                "x" + std::to_string(d.k1) + " and " + std::to_string(d.rows) + "x" +
                std::to_string(d.k2));
    Require(IsBetween(signature.magnitudes, 0, std::numeric_limits<float>::max()), where,
            "a magnitude is below 0 or is not finite");
    Require(IsBetween(signature.phases, -kPiAsHalf, kPiAsHalf), where,
            "a phase isn't between -pi and pi");
  }

  void CheckFeatures(const AppearanceNode& node) {
    const std::string where = "appearance_features " + std::to_string(node.id.value);
    const NodeFeatures& features = node.features;
    const int count = static_cast<int>(features.bearings.size());
    Require(features.codes.rows() == count, where,
            std::to_string(features.codes.rows()) + " codes for " + std::to_string(count) +
                " bearings");
    Require(count == 0 || features.codes.bytes() == CodeBytes(map_.info.feature_type), where,
            "its codes aren't of " + std::string(NameOf(map_.info.feature_type)));
    Require(std::all_of(features.bearings.begin(), features.bearings.end(), IsBearing), where,
            "a bearing is out of range");
  }

  void CheckEdges() {
    std::pair<AppearanceNodeId, AppearanceNodeId> last;
    for (const AppearanceEdge& edge : layer_.edges) {
      const std::string where =
          "appearance_edges " + std::to_string(edge.a.value) + "/" + std::to_string(edge.b.value);
      Require(edge.a < edge.b, where, "a must be below b");
      Require(std::pair(edge.a, edge.b) > last, where, "edges must be unique and sorted by (a, b)");
      last = {edge.a, edge.b};
      for (const AppearanceNodeId node : {edge.a, edge.b}) {
        Require(nodes_.contains(node), where,
                "there is no appearance node " + std::to_string(node.value));
      }
      Require(edge.distance >= 0 && std::isfinite(edge.distance), where,
              "its distance is " + std::to_string(edge.distance));
      Require(IsFinite(edge.a_from_b) && IsWrapped(edge.a_from_b.theta_rad), where,
              "its relative pose is not finite or its heading isn't between -pi and pi");
      Require(edge.sigma_rad >= 0 && std::isfinite(edge.sigma_rad), where,
              "its sigma is " + std::to_string(edge.sigma_rad));
    }
  }

  void CheckVerdict(const AppearanceVerdict& verdict, const std::string& where) {
    Require(std::isfinite(verdict.intercept), where, "its intercept is not finite");
    Require(verdict.positives >= 0 && verdict.negatives >= 0, where,
            "its sample counts are negative");
    std::string last;
    for (const VerdictTerm& term : verdict.terms) {
      Require(term.name > last, where, "terms must have names, be unique and sorted by name");
      Require(std::isfinite(term.weight), where, "the weight of a term is not finite");
      last = term.name;
    }
  }

  const MapData& map_;
  const AppearanceLayer& layer_;
  std::vector<MapProblem>& problems_;
  AppearanceNodeId last_;
  std::unordered_set<AppearanceNodeId> nodes_;
};

}  // namespace

void FindAppearanceProblems(const MapData& map, std::vector<MapProblem>& problems) {
  AppearanceProblemFinder(map, problems).Find();
}

}  // namespace waystone
