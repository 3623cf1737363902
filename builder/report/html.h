// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "builder/build_map.h"
#include "schema/file/map_store.h"
#include "schema/map_data.h"

namespace waystone {

// The beginning of every report, by which one is recognised as ours before it is replaced.
inline constexpr std::string_view kReportStart =
    "<!doctype html>\n<html lang=en><meta charset=utf-8><meta name=generator content=waystone>\n";

// The whole page. It refers to pictures at ImageName() beside it. Pure; thread-safe, as is
// ImageName.
std::string ReportHtml(const MapData& map, const BuildReport& report,
                       const std::vector<TableSize>& tables);

// "images/17.jpg": where the page looks for a keyframe's picture.
std::string ImageName(KeyframeId id);

}  // namespace waystone
