// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "builder/build_map.h"
#include "schema/file/map_store.h"
#include "schema/map_data.h"

namespace waystone {

// The whole page. Pictures are looked for at ImageName() beside it.
std::string ReportHtml(const MapData& map, const BuildReport& report,
                       const std::vector<TableSize>& tables);

// "images/17.jpg": where the page looks for a keyframe's picture.
std::string ImageName(KeyframeId id);

}  // namespace waystone
