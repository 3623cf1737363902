// SPDX-License-Identifier: Apache-2.0
#include "schema/layers/planes/index_features.h"

#include "core/features/descriptor_codes.h"

namespace waystone {
namespace {

void AppendRows(const Descriptors& rows, Descriptors& all) {
  for (int row = 0; row < rows.rows(); ++row) all.Append(rows.row(row));
}

}  // namespace

int64_t CountFeatures(const MapData& map) {
  int64_t count = 0;
  for (const Plane& plane : map.planes) count += plane.descriptors.rows();
  for (const Keyframe& keyframe : map.keyframes) count += keyframe.landmarks.size();
  return count;
}

std::optional<InvertedFile> IndexFeatures(const MapData& map, const InvertedFileOptions& options) {
  const FeatureType type = map.info.feature_type;
  const int64_t count = CountFeatures(map);
  if (ListCount(count, options) == 0) return std::nullopt;
  Descriptors all(DescriptorBytes(type));
  all.Reserve(static_cast<int>(count));
  for (const Plane& plane : map.planes) AppendRows(plane.descriptors, all);
  for (const Keyframe& keyframe : map.keyframes) {
    AppendRows(DecodeDescriptors(keyframe.landmarks.codes, type), all);
  }
  return BuildInvertedFile(all, type, options);
}

}  // namespace waystone
