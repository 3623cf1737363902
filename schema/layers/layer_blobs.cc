// SPDX-License-Identifier: Apache-2.0
#include "schema/layers/layer_blobs.h"

#include <cstdint>
#include <string>

#include "core/base/check.h"

namespace waystone {

Bytes EncodeKeypoints(const std::vector<PlaneFeature>& features) {
  std::vector<float> values;
  values.reserve(4 * features.size());
  for (const PlaneFeature& feature : features) {
    const Keypoint& at = feature.reference;
    values.insert(values.end(), {at.x_px, at.y_px, at.scale_px, at.angle_rad});
  }
  return EncodeFloats(values);
}

Bytes EncodeVotes(const std::vector<PlaneFeature>& features) {
  std::vector<uint16_t> values;
  values.reserve(2 * features.size());
  for (const PlaneFeature& feature : features) {
    for (const int count : {feature.votes, feature.visible}) {
      WS_CHECK(count >= 0 && count <= kMaxVotes, std::to_string(count) + " votes");
      values.push_back(static_cast<uint16_t>(count));
    }
  }
  return EncodeLists(values);
}

Bytes EncodeBearings(const std::vector<Bearing>& bearings) {
  std::vector<uint16_t> values;
  values.reserve(2 * bearings.size());
  for (const Bearing& bearing : bearings) {
    values.push_back(static_cast<uint16_t>(bearing.azimuth));
    values.push_back(static_cast<uint16_t>(bearing.elevation));
  }
  return EncodeLists(values);
}

Bytes EncodePositions(const std::vector<ImagePosition>& positions) {
  std::vector<uint16_t> values;
  values.reserve(2 * positions.size());
  for (const ImagePosition& position : positions) {
    values.push_back(position.x);
    values.push_back(position.y);
  }
  return EncodeLists(values);
}

std::vector<PlaneFeature> DecodeFeatures(BytesView keypoints, BytesView votes) {
  WS_CHECK(keypoints.size() % kKeypointBytes == 0, "whole keypoints");
  const std::vector<float> values = DecodeFloats(keypoints);
  const std::vector<uint16_t> counts = DecodeLists(votes);
  std::vector<PlaneFeature> features(values.size() / 4);
  WS_CHECK(counts.size() == 2 * features.size(), "as many votes as keypoints");
  for (size_t i = 0; i < features.size(); ++i) {
    const float* at = values.data() + 4 * i;
    features[i].reference = {at[0], at[1], at[2], at[3]};
    features[i].votes = counts[2 * i];
    features[i].visible = counts[2 * i + 1];
  }
  return features;
}

std::vector<Bearing> DecodeBearings(BytesView blob) {
  const std::vector<uint16_t> values = DecodeLists(blob);
  WS_CHECK(values.size() % 2 == 0, "whole bearings");
  std::vector<Bearing> bearings(values.size() / 2);
  for (size_t i = 0; i < bearings.size(); ++i) {
    bearings[i] = {static_cast<int16_t>(values[2 * i]), static_cast<int16_t>(values[2 * i + 1])};
  }
  return bearings;
}

std::vector<ImagePosition> DecodePositions(BytesView blob) {
  const std::vector<uint16_t> values = DecodeLists(blob);
  WS_CHECK(values.size() % 2 == 0, "whole positions");
  std::vector<ImagePosition> positions(values.size() / 2);
  for (size_t i = 0; i < positions.size(); ++i) {
    positions[i] = {values[2 * i], values[2 * i + 1]};
  }
  return positions;
}

}  // namespace waystone
