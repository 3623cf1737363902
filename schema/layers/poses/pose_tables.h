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

}  // namespace waystone
