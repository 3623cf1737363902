// SPDX-License-Identifier: Apache-2.0
#include "schema/layers/planes/index_features.h"

namespace waystone {

int64_t CountFeatures(const MapData& map) {
  int64_t count = 0;
  for (const Plane& plane : map.planes) count += plane.descriptors.rows();
  return count;
}

std::optional<InvertedFile> IndexFeatures(const MapData& map, const InvertedFileOptions& options) {
  const int64_t count = CountFeatures(map);
  if (ListCount(count, options) == 0) return std::nullopt;
  Descriptors all(DescriptorBytes(map.info.feature_type));
  all.Reserve(static_cast<int>(count));
  for (const Plane& plane : map.planes) {
    for (int row = 0; row < plane.descriptors.rows(); ++row) all.Append(plane.descriptors.row(row));
  }
  return BuildInvertedFile(all, map.info.feature_type, options);
}

}  // namespace waystone
