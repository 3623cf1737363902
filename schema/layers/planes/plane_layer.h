// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/base/ids.h"
#include "core/features/features.h"

// The plane layer of a map (the paper's planar region graph): keyframes, planes with their features
// and homographies, and the edges between planes. FORMAT.md says how each field is stored.
namespace waystone {

// The longest side that an image or a camera may be stored with, px.
inline constexpr int kMaxImageSide = 1'000'000;
// The one format of the table search_index that this program knows; frozen, see FORMAT.md.
inline constexpr int kInvertedFileFormat = 1;

// A position in an image, in 65536ths of its width and height; (0, 0) is the centre of the top left
// pixel.
struct ImagePosition {
  uint16_t x = 0;
  uint16_t y = 0;

  bool operator==(const ImagePosition&) const = default;
};
// The code of a position in px; one outside the image is moved to its border. Pure; thread-safe.
ImagePosition EncodePosition(const Eigen::Vector2d& x, int width, int height);
// The position in px. Pure; thread-safe.
Eigen::Vector2d DecodePosition(const ImagePosition& position, int width, int height);

// Features of a keyframe that lie on no plane of the map: first those that were found again in the
// keyframes before and after, then the strongest others.
struct Landmarks {
  std::vector<ImagePosition> positions;
  Descriptors codes;  // EncodeDescriptors of the map's type; row i belongs to positions[i]

  int size() const { return static_cast<int>(positions.size()); }
  bool operator==(const Landmarks&) const = default;
};

// A frame that was kept as one of the paper's key frames.
struct Keyframe {
  KeyframeId id;
  SequenceId sequence;
  int stretch = 0;     // grows at each break in the sequence (too few matches)
  int frame = 0;       // number of the frame in its sequence, from 0
  std::string source;  // name of the image, relative to the sequence
  std::optional<double> time_s;
  int width = 0;                 // px, of the working image: all pixels of the layer are these
  int height = 0;                // px
  std::vector<uint8_t> picture;  // a smaller copy for people; empty when images were left out
  Landmarks landmarks;

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
  std::vector<Eigen::Vector2d> outline;  // what the features support, px in the reference image
  std::vector<PlaneView> views;          // ordered by keyframe; the reference's own is identity

  bool operator==(const Plane&) const = default;
};

// An edge of the graph (eq. 5): two planes seen together with a valid homology, or two parts of one
// surface, whose homology is the identity (JoinsOneSurface).
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

// How likely a place is right, from the evidence for it: a logistic regression, log(p / (1 - p)) =
// intercept + log_inliers * log(1 + inliers) + inlier_share * share, where `inliers` are those of
// all planes of the place at distinct positions of the query and `share` is the share of the best
// plane's matches that are inliers. The defaults are for maps that were never calibrated: among
// 5,330 photos of places that were not in three maps, none had more than 6 inliers.
struct VerdictModel {
  double intercept = -18.2;
  double log_inliers = 8;  // above 0
  double inlier_share = 2;
  int positives = 0;  // samples that it was fitted to
  int negatives = 0;

  bool operator==(const VerdictModel&) const = default;
};

}  // namespace waystone
