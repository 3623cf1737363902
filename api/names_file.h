// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "api/json.h"
#include "schema/map_data.h"

// Named places in a file of their own, by the images that they were made of instead of ids: such a
// file outlives the map that it was written from (docs/names.md describes it).
namespace waystone {

// A range of images of one sequence, both included: names of images of keyframes or panoramas, or
// numbers of frames.
struct ImageRange {
  std::string sequence;  // its name; empty for the one that has the images
  std::string first;
  std::string last;
};

// What of a place isn't in a map, and why.
struct NameMisfit {
  std::string name;
  std::string cause;  // one line
};

// Places as a map has them, and what it hasn't got.
struct ReadNames {
  std::vector<NamedPlace> places;  // canonical
  std::vector<NameMisfit> misfits;
};

// The keyframes and panoramas of a range of images, for a place called `name`. Throws
// MapError(kNotFound) for images that the map hasn't got, and MapError(kUsage) for images of
// several sequences, a range that ends before it begins, and one that holds no keyframe.
NamedPlace PlaceOfImages(const MapData& map, const std::string& name, const ImageRange& range);

// The names of a map, called `map_name`, as such a file.
Json NamesFileJson(const std::string& map_name, const MapData& map);

// Such a file for a map, perhaps another one: what of it the map has, part by part. Throws
// MapError(kBadRequest) for what is no such file, with the field at fault, and
// MapError(kNotAvailable) where the map has none of the sequences that the file's map was made of.
ReadNames ReadNamesFile(std::string_view text, const MapData& map);

// The frame that polygons of named places and anchors of floor plans are in: {"frame", "unit",
// "right", "top"}, the last two as unit vectors; {"frame": "layer"} for a map without poses.
Json AreaFrameJson(const MapData& map);

// Why coordinates in such a frame don't hold in the map: "in the unit 'metres', and the map in
// 'unknown'"; nothing where they do. Throws MapError(kBadRequest) for what is no such frame;
// `what` names it.
std::optional<std::string> FindFrameMisfit(const Json& frame, const std::string& what,
                                           const MapData& map);

// The names of a map by ids: [{"name", "keyframes": [[first, last], ...], "nodes", "planes",
// "polygons": [[[x, y], ...], ...]}].
Json NamedPlacesJson(const std::vector<NamedPlace>& places);

}  // namespace waystone
