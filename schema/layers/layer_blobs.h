// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "schema/layers/appearance/appearance_layer.h"
#include "schema/layers/planes/plane_layer.h"
#include "schema/tables/blob.h"

// Blobs of the layers' own types (schema/tables/blob.h). All functions are pure; thread-safe.
namespace waystone {

// Bytes of one row of each kind of blob.
inline constexpr int kKeypointBytes = 4 * kFloatBytes;  // x, y, scale, angle
inline constexpr int kVotesBytes = 2 * kListBytes;      // votes, visible
inline constexpr int kBearingBytes = 2 * kListBytes;    // int16 azimuth, elevation
inline constexpr int kPositionBytes = 2 * kListBytes;   // uint16 x, y
// The largest number of votes that can be stored.
inline constexpr int kMaxVotes = 0xffff;

Bytes EncodeKeypoints(const std::vector<PlaneFeature>& features);
// Throws CheckFailure for votes that are negative or above kMaxVotes.
Bytes EncodeVotes(const std::vector<PlaneFeature>& features);
Bytes EncodeBearings(const std::vector<Bearing>& bearings);
Bytes EncodePositions(const std::vector<ImagePosition>& positions);

// As many votes as keypoints (CheckFailure).
std::vector<PlaneFeature> DecodeFeatures(BytesView keypoints, BytesView votes);
std::vector<Bearing> DecodeBearings(BytesView blob);
std::vector<ImagePosition> DecodePositions(BytesView blob);

}  // namespace waystone
