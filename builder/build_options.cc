// SPDX-License-Identifier: Apache-2.0
#include "builder/build_options.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <type_traits>

namespace waystone {

void BuildOptions::Check() const {
  CheckFields("", *this);
  features.Check();
  keyframes.Check();
  planes.Check();
  appearance.Check();
  orientation.Check();
  calibration.Check();
  appearance_calibration.Check();
}

std::string OptionsJson(const BuildOptions& options) {
  nlohmann::ordered_json json;
  // These don't list their fields.
  json["features"] = {{"type", NameOf(options.features.type)},
                      {"max_features", options.features.max_features},
                      {"contrast_threshold", options.features.contrast_threshold}};
  const auto& segmentation = options.planes.segmentation;
  json["planes"]["segmentation"] = {{"max_error_px", segmentation.ransac.max_error_px},
                                    {"min_inliers", segmentation.min_inliers}};
  const SignatureOptions& signature = options.appearance.describe.signature;
  json["appearance"]["describe"]["signature"] = {
      {"rows", signature.rows}, {"k1", signature.k1}, {"k2", signature.k2}};
  json["orientation"]["segments"] = {{"detector", NameOf(options.orientation.segments.detector)}};
  json["orientation"]["bearings"] = {{"max_kept", options.orientation.bearings.max_kept}};
  VisitFields("", options, [&](const std::string& path, const auto& field, const auto& value) {
    if (field.name == "threads") return;  // the map doesn't depend on it
    std::string pointer = "/" + path;
    std::ranges::replace(pointer, '.', '/');
    json[nlohmann::ordered_json::json_pointer(pointer)] = value;
  });
  return json.dump();
}

}  // namespace waystone
