// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "schema/tables/table.h"

// The tables of the plane layer; FORMAT.md says what each column means.
namespace waystone {

inline constexpr TableDescriptor kKeyframesTable{
    "keyframes", 1,
    std::array{IntegerColumn("id"), IntegerColumn("sequence"), IntegerColumn("stretch"),
               IntegerColumn("frame"), TextColumn("source"), OrNull(RealColumn("time_s")),
               IntegerColumn("width"), IntegerColumn("height")}};

inline constexpr TableDescriptor kKeyframeImagesTable{
    "keyframe_images", 1, std::array{IntegerColumn("keyframe"), BlobColumn("jpeg")}};

inline constexpr TableDescriptor kPlanesTable{
    "planes", 1,
    std::array{IntegerColumn("id"), IntegerColumn("reference_keyframe"),
               IntegerColumn("feature_count"), IntegerColumn("vertex_count"),
               BlobColumn("outline")}};

inline constexpr TableDescriptor kPlaneFeaturesTable{
    "plane_features", 1,
    std::array{IntegerColumn("plane"), BlobColumn("keypoints"), BlobColumn("votes"),
               BlobColumn("descriptors")}};

inline constexpr TableDescriptor kPlaneViewsTable{
    "plane_views", 2,
    std::array{IntegerColumn("plane"), IntegerColumn("keyframe"), IntegerColumn("inliers"),
               BlobColumn("homography")}};

inline constexpr TableDescriptor kEdgesTable{
    "edges", 2,
    std::array{IntegerColumn("a"), IntegerColumn("b"), IntegerColumn("from_keyframe"),
               IntegerColumn("to_keyframe"), RealColumn("third_eigenvalue"),
               BlobColumn("homology")}};

inline constexpr TableDescriptor kSearchIndexTable{
    "search_index", 1,
    std::array{IntegerColumn("id"), IntegerColumn("format"), IntegerColumn("list_count"),
               IntegerColumn("feature_count"), BlobColumn("centres"), BlobColumn("lists")}};

inline constexpr TableDescriptor kVerdictModelTable{
    "verdict_model", 1,
    std::array{IntegerColumn("id"), RealColumn("intercept"), RealColumn("log_inliers"),
               RealColumn("inlier_share"), IntegerColumn("positives"), IntegerColumn("negatives")}};

}  // namespace waystone
