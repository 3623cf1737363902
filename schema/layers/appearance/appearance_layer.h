// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "core/base/ids.h"
#include "core/camera/panorama.h"
#include "core/features/features.h"
#include "core/geometry/pose2.h"
#include "core/panorama/fourier_signature.h"

// The appearance layer of a map (Fernandez et al. 2011): a graph of panoramas with their Fourier
// signatures and poses. FORMAT.md says how each field is stored.
namespace waystone {

// Where a panorama shows a feature: azimuth clockwise from the front (as FourierSignature has it),
// elevation above the horizon, both in kBearingUnit_rad.
struct Bearing {
  int16_t azimuth = 0;
  int16_t elevation = 0;  // -16384 (straight down) to 16384

  bool operator==(const Bearing&) const = default;
};
inline constexpr double kBearingUnit_rad = std::numbers::pi / 32768;

// The features by which answers at a node are verified; row i of the codes (EncodeDescriptors, of
// the map's feature_type) belongs to bearings[i].
struct NodeFeatures {
  std::vector<Bearing> bearings;
  Descriptors codes;

  // Codes without rows are the same, whatever their length.
  bool operator==(const NodeFeatures& other) const {
    return bearings == other.bearings && codes.data() == other.codes.data();
  }
};

// A node of the graph, the paper's l^j = {(l_x, l_y, l_theta), d^j, p^j, I^j}.
struct AppearanceNode {
  AppearanceNodeId id;
  SequenceId sequence;
  int frame = 0;       // number of the frame in its sequence, from 0
  std::string source;  // name of the image, relative to the sequence
  std::optional<double> time_s;
  // layer_from_node (eqs. 3 to 5, then optimised): x ahead of the camera, y to its left, in the
  // layer's units of length.
  Pose2 pose;
  FourierSignature signature;
  std::vector<uint8_t> picture;  // a smaller copy for people; empty when images were left out
  NodeFeatures features;         // empty when none were kept

  bool operator==(const AppearanceNode&) const = default;
};

// Stored: never change or reuse a value.
enum class AppearanceEdgeKind { kConsecutive = 0, kLoop = 1 };

// Two nodes whose relation was measured.
struct AppearanceEdge {
  AppearanceNodeId a;  // a < b
  AppearanceNodeId b;
  AppearanceEdgeKind kind = AppearanceEdgeKind::kConsecutive;
  double distance = 0;  // D^{a,b} of the signatures (eq. 2)
  // a_from_b as it was measured, before any optimisation, in the layer's units. Its angle is the
  // visual compass's.
  Pose2 a_from_b;
  double sigma_rad = 0;  // standard deviation of that angle

  bool operator==(const AppearanceEdge&) const = default;
};

// One kind of evidence and its weight.
struct VerdictTerm {
  std::string name;
  double weight = 0;

  bool operator==(const VerdictTerm&) const = default;
};

// How likely a place found by appearance is right: a logistic regression, log(p / (1 - p)) =
// intercept + sum of weight * evidence over the terms. A program that doesn't know one of the names
// must not use the model.
struct AppearanceVerdict {
  double intercept = 0;
  std::vector<VerdictTerm> terms;  // by name, ascending
  int positives = 0;               // samples that it was fitted to
  int negatives = 0;

  bool operator==(const AppearanceVerdict&) const = default;
};

// How the images of a catadioptric camera are unwrapped (core/camera/panorama.h).
struct LayerMirror {
  int width = 0;  // of the images, px
  int height = 0;
  int columns = 0;                 // of their panoramas
  ElevationBand band;              // that the mirror shows, from its outer to its inner radius
  bool clockwise = true;           // azimuth in the image
  std::optional<MirrorRing> ring;  // px; nothing where it is searched for in each image

  bool operator==(const LayerMirror&) const = default;
};

struct AppearanceLayer {
  SignatureOptions described;         // how every panorama of the layer was described
  std::optional<LayerMirror> mirror;  // nothing unless a mirror's images were mapped
  // The layer's unit of length in metres; nothing when the scale isn't known (the paper's distances
  // are only proportional to metres).
  std::optional<double> metres_per_unit;
  int dropped = 0;                    // redundant nodes that were left out
  std::vector<AppearanceNode> nodes;  // ordered by id
  std::vector<AppearanceEdge> edges;  // ordered by (a, b)
  // For answers by appearance only, and for those that were verified by features; nothing when it
  // was never calibrated.
  std::optional<AppearanceVerdict> verdict;
  std::optional<AppearanceVerdict> verified_verdict;

  bool operator==(const AppearanceLayer&) const = default;
};

}  // namespace waystone
