// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "builder/build_map.h"
#include "schema/file/map_store.h"
#include "schema/map_data.h"

namespace waystone {

// What every report begins with, so that one is known as ours before it is replaced.
inline constexpr std::string_view kReportStart =
    "<!doctype html>\n<html lang=en><meta charset=utf-8><meta name=generator content=waystone>\n";

// The whole page. Pictures are looked for at ImageName() beside it.
std::string ReportHtml(const MapData& map, const BuildReport& report,
                       const std::vector<TableSize>& tables);

// "images/17.jpg": where the page looks for a keyframe's picture.
std::string ImageName(KeyframeId id);

}  // namespace waystone
