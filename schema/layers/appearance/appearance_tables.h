// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "schema/tables/table.h"

// The tables of the appearance layer; FORMAT.md says what each column means.
namespace waystone {

inline constexpr TableDescriptor kAppearanceLayerTable{
    "appearance_layer", 1,
    std::array{IntegerColumn("id"), IntegerColumn("signature_rows"), IntegerColumn("k1"),
               IntegerColumn("k2"), RealColumn("top_rad"), RealColumn("bottom_rad"),
               IntegerColumn("normalised"), OrNull(RealColumn("metres_per_unit")),
               IntegerColumn("dropped")}};

inline constexpr TableDescriptor kAppearanceMirrorTable{
    "appearance_mirror", 1,
    std::array{IntegerColumn("id"), IntegerColumn("width"), IntegerColumn("height"),
               IntegerColumn("columns"), RealColumn("top_rad"), RealColumn("bottom_rad"),
               IntegerColumn("clockwise"), OrNull(RealColumn("centre_x")),
               OrNull(RealColumn("centre_y")), OrNull(RealColumn("inner_px")),
               OrNull(RealColumn("outer_px"))}};

inline constexpr TableDescriptor kAppearanceNodesTable{
    "appearance_nodes", 1,
    std::array{IntegerColumn("id"), IntegerColumn("sequence"), IntegerColumn("frame"),
               TextColumn("source"), OrNull(RealColumn("time_s")), RealColumn("x"), RealColumn("y"),
               RealColumn("theta_rad")}};

inline constexpr TableDescriptor kAppearanceSignaturesTable{
    "appearance_signatures", 1,
    std::array{IntegerColumn("node"), BlobColumn("magnitudes"), BlobColumn("phases")}};

inline constexpr TableDescriptor kAppearanceFeaturesTable{
    "appearance_features", 1,
    std::array{IntegerColumn("node"), IntegerColumn("feature_count"), BlobColumn("bearings"),
               BlobColumn("codes")}};

inline constexpr TableDescriptor kAppearanceImagesTable{
    "appearance_images", 1, std::array{IntegerColumn("node"), BlobColumn("jpeg")}};

inline constexpr TableDescriptor kAppearanceEdgesTable{
    "appearance_edges", 2,
    std::array{IntegerColumn("a"), IntegerColumn("b"), IntegerColumn("kind"),
               RealColumn("distance"), RealColumn("x"), RealColumn("y"), RealColumn("heading_rad"),
               RealColumn("deviation_rad")}};

inline constexpr TableDescriptor kAppearanceVerdictTable{
    "appearance_verdict", 1,
    std::array{IntegerColumn("id"), RealColumn("intercept"), IntegerColumn("positives"),
               IntegerColumn("negatives")}};

inline constexpr TableDescriptor kAppearanceVerdictTermsTable{
    "appearance_verdict_terms", 1,
    std::array{IntegerColumn("id"), IntegerColumn("verdict"), TextColumn("name"),
               RealColumn("weight")}};

}  // namespace waystone
