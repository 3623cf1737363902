// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/base/ids.h"
#include "core/camera/camera.h"
#include "core/features/features.h"
#include "core/search/inverted_file.h"
#include "schema/layers/appearance/appearance_layer.h"
#include "schema/layers/orientation/orientation_layer.h"

// A map as values: what the builder hands to MapStore and what the localizer gets from it.
// FORMAT.md says how each field is stored.
namespace waystone {

// One image sequence that the map was built from.
struct Sequence {
  SequenceId id;
  std::string name;  // of the folder or file, without its path
  std::string kind;  // "folder", "video", "tum", "kitti", "euroc"
  int frames = 0;    // read from the source
  int skipped = 0;   // of them, could not be decoded
  std::optional<Camera> camera;

  bool operator==(const Sequence&) const = default;
};

// A frame that was kept as one of the paper's key frames.
struct Keyframe {
  KeyframeId id;
  SequenceId sequence;
  int stretch = 0;     // grows at each break in the sequence (no matches at all)
  int frame = 0;       // number of the frame in its sequence, from 0
  std::string source;  // name of the image, relative to the sequence
  std::optional<double> time_s;
  int width = 0;              // px, of the original image
  int height = 0;             // px
  std::vector<uint8_t> jpeg;  // a smaller copy for people; empty when images were left out

  bool operator==(const Keyframe&) const = default;
};

// A feature of a plane, expressed in the plane's reference image.
struct PlaneFeature {
  Keypoint reference;  // position, scale and angle in the reference image; may lie outside it
  int votes = 0;       // keyframes that supported it (the paper's feature votes)
  int visible = 0;     // keyframes of the plane that should have seen it

  bool operator==(const PlaneFeature&) const = default;
};

// One keyframe that saw a plane. x_reference = reference_from_keyframe * x_keyframe (homogeneous
// pixels; the matrix has h33 = 1 or, where that is impossible, unit norm).
struct PlaneView {
  KeyframeId keyframe;
  Eigen::Matrix3d reference_from_keyframe = Eigen::Matrix3d::Identity();
  int inliers = 0;  // features that support it

  bool operator==(const PlaneView&) const = default;
};

// A node of the graph: the paper's planar region pi^m.
struct Plane {
  PlaneId id;
  KeyframeId reference;  // the first keyframe that saw it (the paper's I_r)
  std::vector<PlaneFeature> features;
  Descriptors descriptors;               // row i belongs to features[i]
  std::vector<Eigen::Vector2d> outline;  // convex hull of the features, px in the reference image
  std::vector<PlaneView> views;          // ordered by keyframe; the reference's own is identity

  bool operator==(const Plane&) const = default;
};

// An edge of the graph (eq. 5): two planes seen together with a valid homology.
struct Edge {
  PlaneId a;  // a < b
  PlaneId b;
  KeyframeId from;  // the two consecutive keyframes, the paper's I_{i-1} ...
  KeyframeId to;    // ... and I_i
  // H^{ab} = (H^a_{from,to})^-1 H^b_{from,to}: maps pixels of `to` to pixels of `to`; scaled so
  // that its double eigenvalue is 1 (sec. II-B).
  Eigen::Matrix3d homology = Eigen::Matrix3d::Identity();
  double third_eigenvalue = 1;  // 1 + v^T p of eqs. (2) and (3)

  bool operator==(const Edge&) const = default;
};

struct MapInfo {
  std::string name;     // for people; the file's name without extension by default
  std::string program;  // "waystone 0.1.0": what wrote it
  FeatureType feature_type = FeatureType::kSift;
  std::string options_json;  // the builder's options, for people and to build the same again
  std::string version;       // "sha256:..." of the file; filled on reading, ignored on writing

  bool operator==(const MapInfo&) const = default;
};

// How likely a place is right, from the evidence for it: a logistic regression,
// log(p / (1 - p)) = intercept + log_inliers * log(1 + inliers) + inlier_share * share, where
// `inliers` are those of all planes of the place at distinct positions of the query and `share` is
// the share of the best plane's matches that are inliers. The defaults hold for maps that were
// never calibrated: among 5,330 photos that three maps didn't show, none had more than 6 inliers.
struct VerdictModel {
  double intercept = -18.2;
  double log_inliers = 8;  // above 0
  double inlier_share = 2;
  int positives = 0;  // samples that it was fitted to
  int negatives = 0;

  bool operator==(const VerdictModel&) const = default;
};

struct MapData {
  MapInfo info;
  std::vector<Sequence> sequences;  // each list is ordered by id
  std::vector<Keyframe> keyframes;
  std::vector<Plane> planes;
  std::vector<Edge> edges;  // ordered by (a, b)
  // The descriptors of all planes, plane after plane, sorted for searching (IndexFeatures). Nothing
  // for a map that is small or whose index has a format that this program doesn't know.
  std::optional<InvertedFile> index;
  std::optional<VerdictModel> verdict;          // nothing for a map that was never calibrated
  std::optional<AppearanceLayer> appearance;    // nothing for a map without panoramas
  std::optional<OrientationLayer> orientation;  // nothing for a map without a calibrated camera

  bool operator==(const MapData&) const = default;
};

}  // namespace waystone
