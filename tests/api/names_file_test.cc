// SPDX-License-Identifier: Apache-2.0
#include "api/names_file.h"

#include <gtest/gtest.h>

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "api/layer_json.h"
#include "api/pose_formats.h"
#include "core/base/error.h"
#include "localizer/index/named_places.h"

namespace waystone {
namespace {

const NamedPolygon kSquare{{0, 0}, {2, 0}, {2, 2}, {0, 2}};

Sequence MakeSequence(int64_t id, const std::string& name) {
  Sequence sequence;
  sequence.id = {id};
  sequence.name = name;
  return sequence;
}

// Ten keyframes of one sequence, every fifth frame, and four of another; poses along x.
MapData WalkedMap() {
  MapData map;
  map.info.name = "lab";
  map.info.version = "sha256:1";
  map.sequences = {MakeSequence(1, "kitchen"), MakeSequence(2, "hall")};
  for (int i = 0; i < 14; ++i) {
    Keyframe keyframe;
    keyframe.id = {i + 1};
    keyframe.sequence = {i < 10 ? 1 : 2};
    keyframe.frame = 5 * (i < 10 ? i : i - 10);
    keyframe.source = (i < 10 ? "k" : "h") + std::to_string(keyframe.frame) + ".jpg";
    map.keyframes.push_back(keyframe);
  }
  map.poses.emplace();
  map.poses->frame = "map";
  map.poses->unit = LengthUnit::kMetres;
  for (const Keyframe& keyframe : map.keyframes) {
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    pose.linear() << 0, 0, 1, -1, 0, 0, 0, -1, 0;  // looks along x, z is up
    pose.translation() = Eigen::Vector3d(static_cast<double>(keyframe.id.value), 0.5, 1);
    map.poses->keyframes.push_back(MakeKeyframePose(keyframe.id, pose));
  }
  Plane plane;
  plane.id = {3};
  plane.reference = {2};
  plane.outline = {{10, 10}, {90, 10}, {90, 90}, {10, 90}};
  plane.views = {{{2}, Eigen::Matrix3d::Identity(), 40}, {{3}, Eigen::Matrix3d::Identity(), 40}};
  map.planes = {plane};
  return map;
}

NamedRange Keyframes(int64_t first, int64_t last) { return {NamedKind::kKeyframes, first, last}; }

MapData NamedWalk() {
  MapData map = WalkedMap();
  map.names = Canonical({{"Kitchen", {Keyframes(1, 8)}, {}},
                         {"Window", {Keyframes(3, 4)}, {}},
                         {"Between", {Keyframes(9, 12)}, {}},
                         {"Poster", {{NamedKind::kPlanes, 3, 3}}, {}},
                         {"Carpet", {}, {kSquare}}});
  return map;
}

ErrorCode RefusalOf(const std::string& text, const MapData& map) {
  try {
    ReadNamesFile(text, map);
  } catch (const MapError& error) {
    return error.code();
  }
  return ErrorCode::kInternal;
}

TEST(NamesFile, IsReadToTheSame) {
  const MapData map = NamedWalk();
  const ReadNames read = ReadNamesFile(Dump(NamesFileJson("lab", map)), map);
  EXPECT_EQ(read.places, map.names);
  EXPECT_TRUE(read.misfits.empty());
}

// An L, and a ring that a cut joins to its hole: the corners' mean isn't in either.
TEST(NamesFile, NamesAPlaneByAPointInsideItsOutline) {
  const NamedPolygon l = {{0, 0}, {200, 0}, {200, 20}, {20, 20}, {20, 200}, {0, 200}};
  const NamedPolygon ring = {{0, 0},   {90, 0},  {90, 90}, {0, 90},  {0, 0},
                             {30, 30}, {30, 60}, {60, 60}, {60, 30}, {30, 30}};
  for (const NamedPolygon& outline : {l, ring}) {
    MapData map = NamedWalk();
    map.planes[0].outline = outline;
    const ReadNames read = ReadNamesFile(Dump(NamesFileJson("lab", map)), map);
    EXPECT_EQ(read.places, map.names);
    EXPECT_TRUE(read.misfits.empty());
  }
}

// The same sequences, other keyframes and ids: every third frame, the hall first.
TEST(NamesFile, OutlivesARebuild) {
  MapData rebuilt = WalkedMap();
  rebuilt.sequences = {MakeSequence(1, "hall"), MakeSequence(2, "kitchen")};
  rebuilt.keyframes.clear();
  for (int i = 0; i < 20; ++i) {
    Keyframe keyframe;
    keyframe.id = {i + 1};
    keyframe.sequence = {i < 5 ? 1 : 2};
    keyframe.frame = 3 * (i < 5 ? i : i - 5);
    keyframe.source = (i < 5 ? "h" : "k") + std::to_string(keyframe.frame) + ".jpg";
    rebuilt.keyframes.push_back(keyframe);
  }
  rebuilt.planes.clear();
  const ReadNames read = ReadNamesFile(Dump(NamesFileJson("lab", NamedWalk())), rebuilt);
  ASSERT_EQ(read.places.size(), 4u);
  const auto place = [&](const std::string& name) {
    for (const NamedPlace& one : read.places) {
      if (one.name == name) return one;
    }
    return NamedPlace{};
  };
  // Frames 0 to 35, of which the kitchen's keyframes from 6 on have 0, 3, ..., 33.
  EXPECT_EQ(place("Kitchen").ranges, std::vector<NamedRange>{Keyframes(6, 17)});
  EXPECT_EQ(place("Window").ranges, std::vector<NamedRange>{Keyframes(10, 11)});  // 12, 15
  EXPECT_EQ(place("Between").ranges, (std::vector<NamedRange>{Keyframes(1, 2), Keyframes(20, 20)}));
  EXPECT_EQ(place("Carpet").polygons, std::vector<NamedPolygon>{kSquare});
  ASSERT_EQ(read.misfits.size(), 1u);
  EXPECT_EQ(read.misfits[0].name, "Poster");
}

TEST(NamesFile, OfAnotherMapIsRefused) {
  MapData other = WalkedMap();
  other.sequences[0].name = "garage";
  other.sequences[1].name = "roof";
  const std::string file = Dump(NamesFileJson("lab", NamedWalk()));
  EXPECT_EQ(RefusalOf(file, other), ErrorCode::kNotAvailable);
}

TEST(NamesFile, SaysWhatDoesNotFit) {
  const std::string file = Dump(NamesFileJson("lab", NamedWalk()));
  MapData other = WalkedMap();
  other.sequences[1].name = "roof";
  other.poses->frame = "odom";
  other.planes.clear();
  for (Keyframe& keyframe : other.keyframes) {
    if (keyframe.id.value == 3) keyframe.source = "swapped.jpg";
  }
  const ReadNames read = ReadNamesFile(file, other);
  std::string causes;
  for (const NameMisfit& misfit : read.misfits) causes += misfit.name + ": " + misfit.cause + "\n";
  EXPECT_NE(causes.find("Between: the map has no sequence 'hall'"), std::string::npos) << causes;
  EXPECT_NE(causes.find("Carpet: a polygon is in the frame 'map', and the map in 'odom'"),
            std::string::npos)
      << causes;
  EXPECT_NE(causes.find("Poster: the map has no plane at (50.0, 50.0) of the image 'k5.jpg'"),
            std::string::npos)
      << causes;
  EXPECT_NE(causes.find("Window: frame 10 of the sequence is 'swapped.jpg' in this map, not "
                        "'k10.jpg'"),
            std::string::npos)
      << causes;
  EXPECT_EQ(read.misfits.size(), 4u);
  EXPECT_EQ(read.places.size(), 2u);  // Between's kitchen part, and Kitchen
}

TEST(NamesFile, IsRefusedWhereItIsBroken) {
  const MapData map = NamedWalk();
  const Json good = NamesFileJson("lab", map);
  const auto refused = [&](const std::function<void(Json&)>& change) {
    Json file = good;
    change(file);
    return RefusalOf(Dump(file), map);
  };
  EXPECT_EQ(RefusalOf("", map), ErrorCode::kBadRequest);
  EXPECT_EQ(RefusalOf("[1]", map), ErrorCode::kBadRequest);
  const std::vector<std::function<void(Json&)>> changes{
      [](Json& file) { file["format"] = "names"; },
      [](Json& file) { file["format_version"] = 2; },
      [](Json& file) { file["unknown"] = 1; },
      [](Json& file) { file.erase("map"); },
      [](Json& file) { file["places"] = 1; },
      [](Json& file) { file["places"][0]["name"] = "a\nb"; },
      [](Json& file) { file["places"][0]["name"] = 5; },
      [](Json& file) {
        file["places"][0]["keyframes"] = {{{"sequence", "kitchen"}}};
      },
      [](Json& file) {
        file["places"][1]["polygons"][0]["corners"] = {{0, 0}, {1, 1}};
      },
      [](Json& file) { file["places"][1]["polygons"][0]["right"] = "x"; },
  };
  for (size_t i = 0; i < changes.size(); ++i) {
    EXPECT_EQ(refused(changes[i]), ErrorCode::kBadRequest) << i;
  }
}

TEST(NamesFile, KeepsNamesakesApart) {
  MapData map = WalkedMap();
  map.sequences[1].name = "kitchen";
  map.names = {{"Second", {Keyframes(11, 12)}, {}}};
  const Json file = NamesFileJson("lab", map);
  EXPECT_EQ(file["places"][0]["keyframes"][0]["sequence_number"], 2);
  EXPECT_EQ(ReadNamesFile(Dump(file), map).places, map.names);
}

TEST(PlaceOfImages, FindsThemByNameAndNumber) {
  const MapData map = WalkedMap();
  EXPECT_EQ(PlaceOfImages(map, "a", {"", "k10.jpg", "k20.jpg"}).ranges,
            std::vector<NamedRange>{Keyframes(3, 5)});
  EXPECT_EQ(PlaceOfImages(map, "a", {"hall", "4", "11"}).ranges,
            std::vector<NamedRange>{Keyframes(12, 13)});
  const auto code_of = [&](const ImageRange& range) {
    try {
      PlaceOfImages(map, "a", range);
    } catch (const MapError& error) {
      return error.code();
    }
    return ErrorCode::kInternal;
  };
  EXPECT_EQ(code_of({"", "k11.jpg", "k20.jpg"}), ErrorCode::kNotFound);
  EXPECT_EQ(code_of({"", "k10.jpg", "h5.jpg"}), ErrorCode::kNotFound);
  EXPECT_EQ(code_of({"", "1", "9"}), ErrorCode::kUsage);      // of either sequence
  EXPECT_EQ(code_of({"hall", "1", "4"}), ErrorCode::kUsage);  // between two keyframes
  EXPECT_EQ(code_of({"", "k20.jpg", "k10.jpg"}), ErrorCode::kUsage);
}

// The narrowest counts.
TEST(NamedPlaces, FindsTheNarrowest) {
  const MapData map = NamedWalk();
  const NamedPlaces places(map);
  const auto name = [](const std::string* found) { return found ? *found : "-"; };
  EXPECT_EQ(name(places.OfKeyframe({1})), "Carpet");  // at (1, 0.5); keyframes 1 alone
  EXPECT_EQ(name(places.OfKeyframe({3})), "Window");
  EXPECT_EQ(name(places.OfKeyframe({6})), "Kitchen");
  EXPECT_EQ(name(places.OfKeyframe({12})), "Between");
  EXPECT_EQ(name(places.OfKeyframe({14})), "-");
  const auto at = [&](const Eigen::Vector2d& position) {
    return name(
        places.Find({.keyframe = KeyframeId{6}, .node = {}, .plane = {}, .position = position}));
  };
  EXPECT_EQ(at({1.5, 1.5}), "Carpet");
  EXPECT_EQ(at({1.5, -1.5}), "Kitchen");
  EXPECT_EQ(name(places.Find(
                {.keyframe = KeyframeId{6}, .node = {}, .plane = PlaneId{3}, .position = {}})),
            "Poster");
  EXPECT_EQ(NamedPlaces(WalkedMap()).OfKeyframe({1}), nullptr);
}

// Panoramas on a map without given poses, by id and by their own positions.
TEST(NamedPlaces, NameTheRowsOfPanoramas) {
  MapData map = WalkedMap();
  map.poses.reset();
  map.appearance.emplace();
  for (int64_t id = 1; id <= 3; ++id) {
    AppearanceNode& node = map.appearance->nodes.emplace_back();
    node.id = {id};
    node.sequence = {1};
    node.pose = {static_cast<double>(id), 0.5, 0};
  }
  map.names = Canonical({{"Carpet", {}, {kSquare}}, {"Door", {{NamedKind::kNodes, 2, 2}}, {}}});
  const NodeRows rows("lab", map);
  EXPECT_EQ(rows.Row(map.appearance->nodes[0])["place"], "Carpet");
  EXPECT_EQ(rows.Row(map.appearance->nodes[1])["place"], "Door");
  EXPECT_EQ(rows.Row(map.appearance->nodes[2])["place"], nullptr);
}

TEST(GeoJson, HasKeyframesNamesAndAreas) {
  const Json json = Json::parse(FormatPoses(NamedWalk(), "geojson")->text);
  EXPECT_EQ(json["frame"]["name"], "map");
  EXPECT_EQ(json["frame"]["unit"], "m");
  ASSERT_EQ(json["features"].size(), 15u);
  const Json& third = json["features"][2];
  EXPECT_EQ(third["id"], 3);
  EXPECT_EQ(third["geometry"]["coordinates"], (Json{3.0, 0.5}));
  EXPECT_EQ(third["properties"]["place"], "Window");
  EXPECT_EQ(third["properties"]["heading_rad"], 0.0);
  EXPECT_EQ(json["features"][13]["properties"]["place"], nullptr);
  const Json& area = json["features"][14];
  EXPECT_EQ(area["properties"]["place"], "Carpet");
  EXPECT_EQ(area["geometry"]["type"], "Polygon");
  const Json& ring = area["geometry"]["coordinates"][0];
  ASSERT_EQ(ring.size(), 5u);
  EXPECT_EQ(ring.front(), ring.back());
  const Json unnamed = Json::parse(FormatPoses(WalkedMap(), "geojson")->text);
  EXPECT_FALSE(unnamed["features"][0]["properties"].contains("place"));
}

}  // namespace
}  // namespace waystone
