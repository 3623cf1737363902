// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "api/json.h"
#include "schema/map_data.h"

namespace waystone {

// The floor plans of a map, called `map_name`, as the HTTP API shows them: the frame of
// AreaFrameJson (api/names_file.h), and `plans`, ordered by name:
//   name, width, height  of the image, px
//   image                path of the image on a server
//   heights              {low, high} along the axis that is up, or null
//   plan_from_frame      two rows of three: px = plan_from_frame (x, y, 1) of a point x, y to the
//                        right and to the top
//   px_per_unit, residual  of the fit; the residual is the root mean square over the anchors, in
//   the
//                        unit of the frame
//   anchors              {px, at} of each
// Thread-safe.
Json FloorPlansJson(const std::string& map_name, const MapData& map);

}  // namespace waystone
