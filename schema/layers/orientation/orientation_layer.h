// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/base/ids.h"

// The orientation layer of a map (Puig et al. 2012): the camera's rotation in a building of
// orthogonal walls for every frame, and the topological map that follows from it. FORMAT.md says
// how each field is stored.
namespace waystone {

// The rig's rotation in the building. The building's axes x and y are horizontal, z is up; which
// wall's direction is x is settled by the first frame of a sequence, and sequences that no edge
// joins may differ by multiples of 90 degrees. The rig's frame is its front camera's: x right,
// y down, z forward.
struct BuildingRotation {
  Eigen::Quaterniond building_from_rig = Eigen::Quaterniond::Identity();  // unit, w >= 0
  // Of a small rotation on the left, exp(delta) building_from_rig: about the building's axes,
  // rad^2.
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();

  bool operator==(const BuildingRotation& other) const {
    return building_from_rig.coeffs() == other.building_from_rig.coeffs() &&
           covariance == other.covariance;
  }
};

struct OrientationFrame {
  OrientationFrameId id;
  SequenceId sequence;
  int frame = 0;       // number of the frame in its sequence, from 0
  std::string source;  // name of the image, relative to the sequence
  std::optional<double> time_s;
  bool reliable = false;  // whether the rotation can be relied on; false without one
  std::optional<BuildingRotation> rotation;  // nothing when no axes were found
  std::array<int, 3> lines{};                // that support the building's x, y, z

  bool operator==(const OrientationFrame&) const = default;
};

// A jump of the heading of about 90 degrees between a frame and the one before it (sec. II-B.1).
struct OrientationTurn {
  OrientationFrameId frame;
  int direction = 1;       // +1 left, -1 right, by the motion of the features
  double angle_rad = 0;    // by which the rig's heading changed, above 0 to the left
  bool confirmed = false;  // false: only the camera turned, not the motion (the paper's frame 1645)
  int axis_after = 0;      // the building's axis that the motion follows after it: 0 x, 1 y

  bool operator==(const OrientationTurn&) const = default;
};

// Stored: never changed, never used again.
enum class OrientationNodeKind { kTraversable = 0, kTurn = 1 };

// A node of the topological map: a confirmed turn, or a frame where the view along the trajectory
// breaks.
struct OrientationNode {
  OrientationFrameId frame;
  OrientationNodeKind kind = OrientationNodeKind::kTraversable;
  // Numbers of lines perpendicular to the motion in the cells up, right, down and left (sec.
  // III-C.3): a direction with many is traversable.
  std::array<int, 4> directions{};
  std::vector<uint8_t> picture;  // a smaller copy for people; empty when images were left out

  bool operator==(const OrientationNode&) const = default;
};

// Stored: never changed, never used again.
enum class OrientationEdgeKind { kTraversable = 0, kLoop = 1 };

struct OrientationEdge {
  OrientationFrameId a;  // a < b; both are nodes
  OrientationFrameId b;
  OrientationEdgeKind kind = OrientationEdgeKind::kTraversable;
  int matches = 0;  // verified by the essential matrix

  bool operator==(const OrientationEdge&) const = default;
};

// A stretch without turns along one axis (sec. III-C.1); both ends belong to it.
struct Corridor {
  OrientationFrameId first;
  OrientationFrameId last;  // of the same sequence
  int axis = 0;             // 0 x, 1 y

  bool operator==(const Corridor&) const = default;
};

struct OrientationLayer {
  int step = 1;                          // the paper's n: frames from one test to the next
  std::vector<OrientationFrame> frames;  // ordered by id; those of a sequence by frame
  std::vector<OrientationTurn> turns;    // ordered by frame, as the following
  std::vector<OrientationNode> nodes;
  std::vector<OrientationEdge> edges;  // ordered by (a, b)
  std::vector<Corridor> corridors;     // ordered by first; they don't overlap

  bool operator==(const OrientationLayer&) const = default;
};

}  // namespace waystone
