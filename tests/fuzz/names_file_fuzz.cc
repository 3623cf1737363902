// SPDX-License-Identifier: Apache-2.0
#include "api/names_file.h"

#include <string>

#include "tests/fuzz/fuzz_targets.h"

namespace waystone {
namespace {

// Of the sequence that the corpus names, twice, with keyframes, panoramas, a plane and poses.
MapData MakeNamedMap() {
  MapData map;
  for (const int64_t id : {1, 2}) {
    Sequence& sequence = map.sequences.emplace_back();
    sequence.id = {id};
    sequence.name = "kitchen";
  }
  map.appearance.emplace();
  for (int i = 0; i < 8; ++i) {
    Keyframe keyframe;
    keyframe.id = {i + 1};
    keyframe.sequence = {i < 5 ? 1 : 2};
    keyframe.frame = 2 * i;
    keyframe.source = std::to_string(2 * i) + ".jpg";
    map.keyframes.push_back(keyframe);
    AppearanceNode node;
    node.id = {i + 1};
    node.sequence = keyframe.sequence;
    node.frame = keyframe.frame;
    node.source = keyframe.source;
    map.appearance->nodes.push_back(node);
  }
  Plane& plane = map.planes.emplace_back();
  plane.id = {4};
  plane.reference = {2};
  plane.outline = {{0, 0}, {9, 0}, {9, 9}};
  plane.views = {{{2}, Eigen::Matrix3d::Identity(), 9}};
  map.poses.emplace();
  map.poses->frame = "map";
  return map;
}

}  // namespace

// What is read fits the map, and is written and read to the same.
bool FuzzNamesFile(FuzzInput input) {
  static const MapData kMap = MakeNamedMap();
  const auto read = ReadOrRefuse([&] { return ReadNamesFile(TextOf(input), kMap); });
  if (!read || FindBoundProblem(read->places)) return false;
  MapData named = kMap;
  named.names = read->places;
  Require(Canonical(named.names) == named.names, "places have one form");
  const std::string text = Dump(NamesFileJson("map", named));
  const ReadNames again = ReadBack([&] { return ReadNamesFile(text, named); }, text);
  Require(again.misfits.empty(), "what is read fits the map: " + text);
  Require(again.places == named.names, "names are written and read to the same: " + text);
  return true;
}

}  // namespace waystone
