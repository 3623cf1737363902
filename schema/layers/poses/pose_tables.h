// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "schema/tables/table.h"

// The tables of the pose layer; FORMAT.md says what each column means.
namespace waystone {

inline constexpr TableDescriptor kPoseLayerTable{
    "pose_layer", 1,
    std::array{IntegerColumn("id"), TextColumn("frame"), IntegerColumn("unit"),
               RealColumn("position_sigma"), RealColumn("rotation_sigma_rad")}};

inline constexpr TableDescriptor kKeyframePosesTable{
    "keyframe_poses", 1,
    std::array{IntegerColumn("keyframe"), RealColumn("qw"), RealColumn("qx"), RealColumn("qy"),
               RealColumn("qz"), RealColumn("x"), RealColumn("y"), RealColumn("z")}};

inline constexpr TableDescriptor kPlanePosesTable{
    "plane_poses", 1,
    std::array{IntegerColumn("plane"), RealColumn("nx"), RealColumn("ny"), RealColumn("nz"),
               RealColumn("distance"), BlobColumn("covariance")}};

inline constexpr TableDescriptor kPlaneDepthsTable{
    "plane_depths", 1,
    std::array{IntegerColumn("plane"), IntegerColumn("feature_count"), BlobColumn("depths")}};

inline constexpr TableDescriptor kLandmarkDepthsTable{
    "landmark_depths", 1,
    std::array{IntegerColumn("keyframe"), IntegerColumn("landmark_count"), BlobColumn("depths")}};

// Plain, and only in maps that have panoramas with poses, as the next.
inline constexpr TableDescriptor kNodePosesTable{
    "node_poses", 1,
    std::array{IntegerColumn("node"), RealColumn("qw"), RealColumn("qx"), RealColumn("qy"),
               RealColumn("qz"), RealColumn("x"), RealColumn("y"), RealColumn("z")}};

inline constexpr const char* kNodePosesSql =
    "CREATE TABLE node_poses (\n"
    "  node INTEGER PRIMARY KEY,\n"
    "  qw REAL NOT NULL,\n"
    "  qx REAL NOT NULL,\n"
    "  qy REAL NOT NULL,\n"
    "  qz REAL NOT NULL,\n"
    "  x REAL NOT NULL,\n"
    "  y REAL NOT NULL,\n"
    "  z REAL NOT NULL\n"
    ") STRICT";

inline constexpr TableDescriptor kNodePoseErrorsTable{
    "node_pose_errors", 1,
    std::array{IntegerColumn("id"), RealColumn("position_factor"), RealColumn("height_sigma"),
               RealColumn("heading_sigma_rad"), RealColumn("tilt_sigma_rad")}};

inline constexpr const char* kNodePoseErrorsSql =
    "CREATE TABLE node_pose_errors (\n"
    "  id INTEGER PRIMARY KEY,\n"
    "  position_factor REAL NOT NULL,\n"
    "  height_sigma REAL NOT NULL,\n"
    "  heading_sigma_rad REAL NOT NULL,\n"
    "  tilt_sigma_rad REAL NOT NULL\n"
    ") STRICT";

}  // namespace waystone
