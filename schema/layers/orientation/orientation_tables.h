// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "schema/tables/table.h"

// The tables of the orientation layer; FORMAT.md says what each column means.
namespace waystone {

inline constexpr TableDescriptor kOrientationLayerTable{
    "orientation_layer", 1, std::array{IntegerColumn("id"), IntegerColumn("step")}};

inline constexpr TableDescriptor kOrientationFramesTable{
    "orientation_frames", 1,
    std::array{IntegerColumn("id"), IntegerColumn("sequence"), IntegerColumn("frame"),
               TextColumn("source"), OrNull(RealColumn("time_s")), IntegerColumn("reliable"),
               IntegerColumn("lines_x"), IntegerColumn("lines_y"), IntegerColumn("lines_z"),
               OrNull(RealColumn("qw")), OrNull(RealColumn("qx")), OrNull(RealColumn("qy")),
               OrNull(RealColumn("qz")), OrNull(BlobColumn("covariance"))}};

inline constexpr TableDescriptor kOrientationTurnsTable{
    "orientation_turns", 1,
    std::array{IntegerColumn("frame"), IntegerColumn("direction"), RealColumn("angle_rad"),
               IntegerColumn("confirmed"), IntegerColumn("axis_after")}};

inline constexpr TableDescriptor kOrientationNodesTable{
    "orientation_nodes", 1,
    std::array{IntegerColumn("frame"), IntegerColumn("kind"), IntegerColumn("up"),
               IntegerColumn("right"), IntegerColumn("down"), IntegerColumn("left")}};

inline constexpr TableDescriptor kOrientationImagesTable{
    "orientation_images", 1, std::array{IntegerColumn("frame"), BlobColumn("jpeg")}};

inline constexpr TableDescriptor kOrientationEdgesTable{
    "orientation_edges", 2,
    std::array{IntegerColumn("a"), IntegerColumn("b"), IntegerColumn("kind"),
               IntegerColumn("matches")}};

inline constexpr TableDescriptor kCorridorsTable{
    "corridors", 1,
    std::array{IntegerColumn("first_frame"), IntegerColumn("last_frame"), IntegerColumn("axis")}};

}  // namespace waystone
