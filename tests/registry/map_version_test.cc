// SPDX-License-Identifier: Apache-2.0
#include "registry/map_version.h"

#include <gtest/gtest.h>

#include "api/map_json.h"
#include "core/base/error.h"
#include "tests/server/service/made_map.h"

namespace waystone {
namespace {

const std::string kHash = "sha256:" + std::string(64, 'a');

MapData PublishedMap() {
  MapData map = MadeMap(3);
  map.info.version = kHash;
  return map;
}

TEST(MapVersion, SaysWhatIsInTheMap) {
  MapData data = PublishedMap();
  AddMadePoses(data);
  data.names = {{"Kitchen", {{NamedKind::kKeyframes, 1, 1}}, {}},
                {"Hall", {{NamedKind::kKeyframes, 2, 2}}, {}}};
  const auto index = MapIndex::Build(data);
  const MapVersion version = MakeVersion("lab", *index, 1234, {"berlin", "floor 2"});
  EXPECT_EQ(version.number, 0);
  EXPECT_EQ(version.sha256, kHash);
  const Json details = Json::parse(version.details);
  EXPECT_EQ(details["places"], Json::parse(R"(["Hall","Kitchen"])"));
  EXPECT_EQ(details["tags"], Json::parse(R"(["berlin","floor 2"])"));
  EXPECT_EQ(details["layers"], Json::parse(R"(["planes","poses"])"));
  EXPECT_EQ(details["feature_type"], "sift");
  EXPECT_EQ(details["bounds"]["frame"], "hall");
  EXPECT_EQ(details["bounds"]["metres_per_unit"], 1.0);
  EXPECT_EQ(details["bounds"]["min"], Json::parse("[1.0,2.0,1.5]"));
  EXPECT_EQ(details["bounds"]["max"], Json::parse("[2.0,2.0,1.5]"));
  EXPECT_EQ(SummaryOf(version), MapJson("lab", *index));
  EXPECT_TRUE(HasLayer(version, "poses"));
  EXPECT_FALSE(HasLayer(version, "appearance"));
}

TEST(MapVersion, HasEachTagOnceAndSorted) {
  const auto index = MapIndex::Build(PublishedMap());
  const MapVersion version = MakeVersion("lab", *index, 1234, {"b", "a", "b"});
  EXPECT_EQ(Json::parse(version.details)["tags"], Json::parse(R"(["a","b"])"));
  EXPECT_EQ(TraitsOf(version), TraitsOf(MakeVersion("lab", *index, 1234, {"a", "b"})));
}

TEST(MapVersion, IsReadAsItWasWritten) {
  const auto index = MapIndex::Build(PublishedMap());
  MapVersion version = MakeVersion("a \"map\" of Köln", *index, 1234, {});
  version.number = 7;
  EXPECT_EQ(ReadManifest(ManifestOf(version), "here"), version);
}

TEST(MapVersion, WhatIsNoManifestIsRefused) {
  const auto index = MapIndex::Build(PublishedMap());
  MapVersion version = MakeVersion("lab", *index, 1234, {});
  version.number = 1;
  const Json good = Json::parse(ManifestOf(version));
  const auto refused = [](const std::string& text) {
    try {
      ReadManifest(text, "R/current/lab.json");
    } catch (const MapError& error) {
      return std::string(error.what()).starts_with("R/current/lab.json is not the manifest");
    }
    return false;
  };
  for (const auto& [field, value] :
       std::vector<std::pair<std::string, Json>>{{"name", "../lab"},
                                                 {"name", 3},
                                                 {"version", 0},
                                                 {"version", "1"},
                                                 {"sha256", "sha256:abc"},
                                                 {"sha256", "sha256:" + std::string(63, 'a') + "/"},
                                                 {"bytes", 0},
                                                 {"details", nullptr}}) {
    Json bad = good;
    bad[field] = value;
    EXPECT_TRUE(refused(Dump(bad))) << field << " " << Dump(value);
    bad.erase(field);
    EXPECT_TRUE(refused(Dump(bad))) << "without " << field;
  }
  EXPECT_TRUE(refused(""));
  EXPECT_TRUE(refused(Dump(good).substr(0, 100)));
}

TEST(MapVersion, NamesThatNoFileOrAddressCanHaveAreRefused) {
  const std::string right_to_left = "\u202E";
  for (const std::string& name :
       {std::string("lab"), std::string("Floor 2, east"), std::string("Köln"), std::string(".lab"),
        std::string(), std::string("a/b"), std::string("a\nb"), std::string("\xff"),
        std::string(".."), right_to_left + "bal"}) {
    const bool good = name == "lab" || name == "Floor 2, east" || name == "Köln";
    bool taken = true;
    try {
      CheckMapName(name);
    } catch (const MapError& error) {
      taken = false;
      EXPECT_EQ(error.code(), ErrorCode::kUsage);
    }
    EXPECT_EQ(taken, good) << name;
  }
  EXPECT_NO_THROW(CheckMapName(std::string(100, 'x')));
  EXPECT_THROW(CheckMapName(std::string(101, 'x')), MapError);
  const auto index = MapIndex::Build(PublishedMap());
  EXPECT_THROW(MakeVersion("lab", *index, 1, {""}), MapError);
  EXPECT_THROW(MakeVersion("lab", *index, 1, {"a\tb"}), MapError);
}

}  // namespace
}  // namespace waystone
