// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <vector>

#include "builder/build_map.h"
#include "schema/file/map_store.h"
#include "schema/map_data.h"

namespace waystone {

// Throws MapError: kFileExists for a path that isn't a folder, or for a folder whose index.html or
// images/ isn't that of an earlier report, since a report must not replace photos; kFileUnwritable
// for a folder that can't be made. Meant to be called before an hour of work. Thread-safe for
// different folders, as WriteReport.
void CheckReportFolder(const std::filesystem::path& dir);

// Writes a page about a map into `dir`, which is made if it isn't there: index.html, which needs
// nothing from elsewhere, and images/, one picture per keyframe with its planes drawn over it in
// their colours (the paper's figures 2 and 3), beside the graph of surfaces (figure 4), the list of
// planes, and what the build counted; of the other layers the trajectory of the panoramas and the
// pictures of orientation_svg.h. Files of an earlier report are replaced, and its other pictures
// removed. Throws MapError: kFileUnwritable, and what CheckReportFolder throws.
void WriteReport(const MapData& map, const BuildReport& report,
                 const std::vector<TableSize>& tables, const std::filesystem::path& dir);

}  // namespace waystone
