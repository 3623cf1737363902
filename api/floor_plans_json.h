// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "api/json.h"
#include "schema/map_data.h"

namespace waystone {

// The floor plans of a map, called `map_name`: the schema FloorPlans of clients/openapi.yaml, with
// the frame of AreaFrameJson (api/names_file.h) and the plans by name. px = plan_from_frame (x, y,
// 1) for a point with x to the right and y to the top. The residual of the fit is the root mean
// square over the anchors, in the unit of the frame. Thread-safe.
Json FloorPlansJson(const std::string& map_name, const MapData& map);

}  // namespace waystone
