// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "api/json.h"
#include "schema/map_data.h"

// Named places in a separate file, by image names instead of ids: such a file outlives the map from
// which it was written (docs/names.md describes it). All functions are thread-safe.
namespace waystone {

// A range of images of one sequence, both included: names of images of keyframes or panoramas, or
// numbers of frames.
struct ImageRange {
  std::string sequence;  // its name; empty for the one that has the images
  std::string first;
  std::string last;
};

// A part of a place that isn't in a map, and why.
struct NameMisfit {
  std::string name;
  std::string cause;  // one line
};

// The places of a file that a map has, and what it lacks.
struct ReadNames {
  std::vector<NamedPlace> places;  // canonical
  std::vector<NameMisfit> misfits;
};

// The keyframes and panoramas of a range of images, for a place called `name`. Throws
// MapError(kNotFound) for images that the map doesn't have, and MapError(kUsage) for images of
// several sequences, a range that ends before it begins, and one that holds no keyframe.
NamedPlace PlaceOfImages(const MapData& map, const std::string& name, const ImageRange& range);

// The names of a map, called `map_name`, as such a file.
Json NamesFileJson(const std::string& map_name, const MapData& map);

// Reads such a file for a map, possibly another one: whatever of it the map has, part by part.
// Throws MapError(kBadRequest) for an invalid file, with the field at fault, and
// MapError(kNotAvailable) where the map has none of the sequences of the file's map.
ReadNames ReadNamesFile(std::string_view text, const MapData& map);

// The frame of polygons of named places and anchors of floor plans: {"frame", "unit", "right",
// "top"}, the last two as unit vectors; {"frame": "layer"} for a map without poses.
Json AreaFrameJson(const MapData& map);

// Why coordinates in such a frame aren't valid in the map: "in the unit 'metres', and the map in
// 'unknown'"; nothing where they are. Throws MapError(kBadRequest) for an invalid frame; `what`
// names it.
std::optional<std::string> FindFrameMisfit(const Json& frame, const std::string& what,
                                           const MapData& map);

// The names of a map by ids: [{"name", "keyframes": [[first, last], ...], "nodes", "planes",
// "polygons": [[[x, y], ...], ...]}].
Json NamedPlacesJson(const std::vector<NamedPlace>& places);

}  // namespace waystone
