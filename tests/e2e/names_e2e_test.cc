// SPDX-License-Identifier: Apache-2.0
// `waystone name`: names in a map's file, in its answers, and in files of their own.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

#include "api/json.h"
#include "tests/e2e/calibrated_maps.h"
#include "tests/e2e/shared_map.h"

namespace waystone {
namespace {

namespace fs = std::filesystem;

class NameTest : public testing::Test {
 protected:
  NameTest() { fs::copy_file(TheMap().map, map_); }
  ~NameTest() override { fs::remove_all(folder_); }

  RunResult Name(std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), {"name", map_});
    return RunWaystone(arguments);
  }

  Json Places() const { return Json::parse(Name({"--json"}).out)["places"]; }

  // Refused in one line, with the map as it was.
  void ExpectRefusal(const std::vector<std::string>& arguments, int code,
                     const std::string& about) {
    const std::string before = ReadFile(map_);
    const RunResult result = Name(arguments);
    EXPECT_EQ(result.code, code) << result.err;
    EXPECT_EQ(result.out, "");
    EXPECT_EQ(std::ranges::count(result.err, '\n'), 1) << result.err;
    EXPECT_NE(result.err.find(about), std::string::npos) << result.err;
    EXPECT_TRUE(ReadFile(map_) == before) << about;
  }

  const fs::path folder_ = FreshFolder();
  const fs::path map_ = folder_ / "room.db";
};

TEST_F(NameTest, NamesAreGivenListedAndRemoved) {
  EXPECT_EQ(Name({}).out, map_.string() + ": 0 named places\n");
  ASSERT_EQ(Name({"--keyframes", "1:3", "Küche, Fenster"}).code, 0);
  ASSERT_EQ(Name({"Küche, Fenster", "--keyframes", "5", "--planes", "1,2"}).code, 0);
  const RunResult listed = Name({"--keyframes", "1:2", "Door"});
  EXPECT_EQ(listed.out, map_.string() +
                            ": 2 named places\n  Door: keyframes 1:2\n"
                            "  Küche, Fenster: keyframes 1:3,5, planes 1:2\n");
  EXPECT_EQ(Places()[1]["keyframes"], Json::parse("[[1,3],[5,5]]"));
  EXPECT_EQ(RunWaystone({"check", map_}).code, 0);
  EXPECT_NE(RunWaystone({"info", map_}).out.find("place     Door"), std::string::npos);
  ASSERT_EQ(Name({"--remove", "Door"}).code, 0);
  EXPECT_EQ(Places().size(), 1u);
}

TEST_F(NameTest, AnswersCarryThem) {
  const Json before = Json::parse(RunWaystone({"localize", map_, TheMap().inside, "--json"}).out);
  ASSERT_EQ(before["verdict"], "localized");
  EXPECT_EQ(before["place"]["name"], nullptr);
  const std::string id = std::to_string(before["place"]["id"].get<int>());
  ASSERT_EQ(Name({"--keyframes", id, "Window"}).code, 0);
  ASSERT_EQ(Name({"--keyframes", "1:" + id, "Room"}).code, 0);
  const Json answer = Json::parse(RunWaystone({"localize", map_, TheMap().inside, "--json"}).out);
  EXPECT_EQ(answer["place"]["name"], "Window");
  EXPECT_EQ(answer["place"]["id"], before["place"]["id"]);
  const RunResult line = RunWaystone({"localize", map_, TheMap().inside});
  EXPECT_NE(line.out.find("localized in Window near "), std::string::npos) << line.out;
}

TEST_F(NameTest, AreasOfAMapWithPosesCarryThem) {
  fs::copy_file(ThePosedHall().map, map_, fs::copy_options::overwrite_existing);
  const fs::path photo = ThePosedHall().walk / "queries" / "20.jpg";
  const Json before = Json::parse(RunWaystone({"localize", map_, photo, "--json"}).out);
  ASSERT_EQ(before["verdict"], "localized");
  ASSERT_TRUE(before["pose"].is_object()) << before;
  const double x = before["pose"]["position"][0], y = before["pose"]["position"][1];
  const auto square = [](double cx, double cy, double half) {
    const auto corner = [&](double dx, double dy) {
      return std::to_string(cx + dx * half) + "," + std::to_string(cy + dy * half) + " ";
    };
    return corner(-1, -1) + corner(1, -1) + corner(1, 1) + corner(-1, 1);
  };
  ASSERT_EQ(Name({"--polygon", square(x, y, 0.3), "Carpet"}).code, 0);
  ASSERT_EQ(Name({"--polygon", square(x + 1, y, 0.3), "Beside"}).code, 0);
  ASSERT_EQ(Name({"--polygon", square(x, y, 50), "Hall"}).code, 0);
  const Json answer = Json::parse(RunWaystone({"localize", map_, photo, "--json"}).out);
  EXPECT_EQ(answer["place"]["name"], "Carpet");
  const Json geo = Json::parse(RunWaystone({"export", map_, "--format", "geojson"}).out);
  EXPECT_EQ(std::ranges::count_if(
                geo["features"],
                [](const Json& feature) { return feature["geometry"]["type"] == "Polygon"; }),
            3);
  EXPECT_EQ(geo["features"][0]["properties"]["place"], "Hall");
}

TEST_F(NameTest, NamesFilesOutliveARebuild) {
  const fs::path file = folder_ / "names.json", rebuilt = folder_ / "rebuilt.db";
  ASSERT_EQ(Name({"--keyframes", "2:3", "Door"}).code, 0);
  ASSERT_EQ(Name({"--planes", "1", "Poster"}).code, 0);
  ASSERT_EQ(Name({"--export", file}).code, 0);
  ExpectRefusal({"--export", file}, 3, "names.json");
  ASSERT_EQ(RunWaystone({"build", TheMap().images, "-o", rebuilt, "--quiet"}).code, 0);
  ASSERT_EQ(RunWaystone({"name", rebuilt, "--from", file}).code, 0);
  EXPECT_EQ(Json::parse(RunWaystone({"name", rebuilt, "--json"}).out)["places"], Places());
}

TEST_F(NameTest, ABuildKeepsTheNamesOfTheMapItReplaces) {
  ASSERT_EQ(Name({"--keyframes", "2:3", "Door"}).code, 0);
  const Json before = Places();
  const fs::path apart = folder_ / "room.names.json";
  const RunResult same = RunWaystone({"build", TheMap().images, "-o", map_, "--force", "--quiet"});
  ASSERT_EQ(same.code, 0) << same.err;
  EXPECT_EQ(Places(), before);
  EXPECT_FALSE(fs::exists(apart));
  fs::copy(TheMap().images, folder_ / "other", fs::copy_options::recursive);
  const RunResult other =
      RunWaystone({"build", folder_ / "other", "-o", map_, "--to", "20", "--force", "--quiet"});
  ASSERT_EQ(other.code, 0) << other.err;
  EXPECT_NE(other.err.find("room.names.json"), std::string::npos) << other.err;
  EXPECT_TRUE(Places().empty());
  EXPECT_EQ(Json::parse(ReadFile(apart))["places"][0]["name"], "Door");
}

TEST_F(NameTest, ABuildSaysThatItCantReadTheNamesOfADamagedMap) {
  ASSERT_EQ(Name({"--keyframes", "2:3", "Door"}).code, 0);
  fs::resize_file(map_, fs::file_size(map_) / 2);
  const RunResult result =
      RunWaystone({"build", TheMap().images, "-o", map_, "--to", "20", "--force", "--quiet"});
  ASSERT_EQ(result.code, 0) << result.err;
  EXPECT_EQ(std::ranges::count(result.err, '\n'), 1) << result.err;
  for (const char* part : {"names and floor plans of the old one", "backup", "is damaged"}) {
    EXPECT_NE(result.err.find(part), std::string::npos) << result.err;
  }
  EXPECT_TRUE(Places().empty());
}

TEST_F(NameTest, NamesOfAnotherMapAreRefusedOrKeptApart) {
  const fs::path file = folder_ / "names.json";
  ASSERT_EQ(Name({"--keyframes", "1:2", "Door"}).code, 0);
  ASSERT_EQ(Name({"--export", file}).code, 0);
  Json names = Json::parse(ReadFile(file));
  Json elsewhere = names["places"][0];
  elsewhere["name"] = "Elsewhere";
  elsewhere["keyframes"][0]["sequence"] = "attic";
  names["places"].push_back(elsewhere);
  WriteFile(file, Dump(names));
  ExpectRefusal({"--from", file}, 3, "'Elsewhere': the map has no sequence 'attic'");
  const RunResult taken = Name({"--from", file, "--fitting"});
  EXPECT_EQ(taken.code, 0);
  EXPECT_NE(taken.err.find("left out: 'Elsewhere'"), std::string::npos) << taken.err;
  EXPECT_EQ(Places().size(), 1u);
  names["map"]["sequences"] = {"attic"};
  WriteFile(file, Dump(names));
  ExpectRefusal({"--from", file}, 3, "none of whose 1 sequences is in this map");
  WriteFile(file, "{\"format\": 1");
  ExpectRefusal({"--from", file}, 3, "invalid JSON");
  ExpectRefusal({"--from", folder_ / "missing.json"}, 3, "No such file");
}

TEST_F(NameTest, BadInputIsRefused) {
  ExpectRefusal({"Door"}, 2, "specify what has this name");
  ExpectRefusal({"--keyframes", "1"}, 2, "specify the name");
  ExpectRefusal({"--keyframes", "1:999999", "Door"}, 3, "no keyframe 999999; its ids are from 1");
  ExpectRefusal({"--keyframes", "3:1", "Door"}, 2, "ends before it begins");
  ExpectRefusal({"--keyframes", "first", "Door"}, 2, "'first' is not an id");
  ExpectRefusal({"--nodes", "1", "Door"}, 3, "it has no nodes");
  ExpectRefusal({"--polygon", "0,0 1,0 1,1", "Door"}, 3, "no positions");
  ExpectRefusal({"--images", "nothing.jpg:1.jpg", "Door"}, 3, "nothing.jpg");
  ExpectRefusal({"--keyframes", "1", std::string(201, 'x')}, 2, "201 bytes");
  ExpectRefusal({"--keyframes", "1", "red\x1b[31m"}, 2, "\\u001b");
  ExpectRefusal({"--keyframes", "1", "\xff"}, 2, "UTF-8");
  ExpectRefusal({"--remove", "Attic"}, 3, "no place named 'Attic'");
  ExpectRefusal({"--keyframes", "1", "Door", "--sequence", "walk"}, 2, "--images");
  ExpectRefusal({"--keyframes", "1", "Door", "--fitting"}, 2, "--from");
  ExpectRefusal({"--keyframes", "1", "Door", "--force"}, 2, "--export");
  ExpectRefusal({"--remove", "Attic", "Door", "--keyframes", "1"}, 2, "specify one of");
}

}  // namespace
}  // namespace waystone
