// SPDX-License-Identifier: Apache-2.0
#include "localizer/coarse/coarse_query.h"

#include "core/camera/panorama.h"
#include "localizer/appearance/panorama_features.h"

namespace waystone {
namespace {

void Append(const Descriptors& rows, Descriptors& all) {
  for (int i = 0; i < rows.rows(); ++i) all.Append(rows.row(i));
}

}  // namespace

std::vector<CoarseDescriptors> DescribeForCoarse(const cv::Mat& grey,
                                                 const std::vector<CoarseNeed>& needs,
                                                 const PlaneQueryOptions& planes,
                                                 const PanoramaQueryOptions& panorama,
                                                 ImageFeatures& features) {
  std::vector<CoarseDescriptors> described;
  for (const CoarseNeed& need : needs) {
    CoarseDescriptors one{need.type, Descriptors(DescriptorBytes(need.type))};
    const bool faces = need.panoramas && HasPanoramaShape(grey.size());
    if (faces) {
      PanoramaFeatureOptions options = panorama.features;
      options.bearings.features.type = need.type;
      Append(ExtractScaledPanorama(grey, options).descriptors, one.rows);
    }
    if (!faces || need.working_pixels > 0) {
      const FeatureOptions how = QueryFeatureOptions(need.type, need.working_pixels, planes);
      Append(features.Extract(grey, how).features.descriptors, one.rows);
    }
    described.push_back(std::move(one));
  }
  return described;
}

}  // namespace waystone
