// SPDX-License-Identifier: Apache-2.0
// The real program finds the right one of more maps than fit into its memory.
#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <vector>

#include "api/json.h"
#include "core/base/random.h"
#include "schema/file/map_store.h"
#include "tests/e2e/registry_server.h"
#include "tests/e2e/shared_map.h"

namespace waystone {
namespace {

namespace fs = std::filesystem;

// A map like the room's of another room: as many features, but other ones.
fs::path OtherRoom(const fs::path& folder, int number) {
  MapData map = ReadMap(TheMap().map);
  Random random(static_cast<uint64_t>(number));
  const auto other = [&random](const Descriptors& rows, int largest) {
    std::vector<uint8_t> data(rows.data().size());
    for (uint8_t& byte : data) byte = static_cast<uint8_t>(random.Below(largest));
    return Descriptors(rows.bytes(), std::move(data));
  };
  for (Plane& plane : map.planes) plane.descriptors = other(plane.descriptors, 45);
  for (Keyframe& keyframe : map.keyframes) {
    if (keyframe.landmarks.size() == 0) continue;
    keyframe.landmarks.codes = other(keyframe.landmarks.codes, 256);
  }
  map.index.reset();
  map.info.name = "other";
  fs::path file = folder / ("other" + std::to_string(number) + ".db");
  WriteMap(map, file, {.overwrite = true});
  return file;
}

class SearchE2e : public testing::Test {
 protected:
  ~SearchE2e() override { fs::remove_all(folder_); }

  void Publish(const std::string& name, const fs::path& map,
               const std::vector<std::string>& flags = {}) const {
    std::vector<std::string> arguments = {"publish", map, "--to", registry_, "--name", name};
    arguments.insert(arguments.end(), flags.begin(), flags.end());
    const RunResult result = RunWaystone(arguments);
    EXPECT_EQ(result.code, 0) << result.err;
  }
  static Json Ask(const RegistryServer& served, const Json& request = Json::object()) {
    httplib::MultipartFormDataItems parts = {
        {"image", ReadFile(TheMap().inside), "photo.jpg", "image/jpeg"},
        {"request", Dump(request), "", "application/json"}};
    const auto result = served.NewClient().Post("/v1/localize", parts);
    EXPECT_TRUE(result);
    return Json::parse(result->body);
  }
  static std::string StateOf(const Json& answer, const std::string& map) {
    for (const Json& one : answer["searched"]) {
      if (one["map"] == map) return one["state"];
    }
    return "";
  }
  // As many bytes as some maps of the room's size take, beside the largest one's file.
  static std::string MemoryOf(int maps) {
    const auto bytes = static_cast<int64_t>(fs::file_size(TheMap().map));
    return std::to_string((2 * maps + 2) * bytes);
  }

  const fs::path folder_ = FreshFolder();
  const std::string registry_ = (folder_ / "registry").string();
};

TEST_F(SearchE2e, TheRightMapIsFoundInMoreThanFitIntoMemory) {
  for (int i = 0; i < 5; ++i) {
    Publish("other" + std::to_string(i), OtherRoom(folder_, i), {"--tag", "others"});
  }
  Publish("room", TheMap().map, {"--tag", "rooms"});
  const RegistryServer served(registry_, folder_ / "cache", {"--memory", MemoryOf(2)});
  EXPECT_TRUE(Until([&] { return served.Get("/readyz")["registry"]["coarse"]["maps"] == 6; }));
  EXPECT_EQ(served.Metric("waystone_coarse_maps"), 6);
  EXPECT_GT(served.Metric("waystone_coarse_places"), 0);
  EXPECT_EQ(served.Get("/readyz")["open"], 0) << "nothing is opened for the index";

  const Json answer = Ask(served);
  EXPECT_EQ(answer["verdict"], "localized") << Dump(answer);
  EXPECT_EQ(answer["map"], "room");
  EXPECT_EQ(answer["searched"][0]["map"], "room");
  EXPECT_EQ(StateOf(answer, "room"), "asked");
  EXPECT_EQ(answer["partial"], false);
  EXPECT_FALSE(answer.contains("unindexed"));
  Json alone = served.Localize("room");
  for (const char* field : {"verdict", "probability", "place", "planes"}) {
    EXPECT_EQ(answer[field], alone[field]) << field;
  }

  // Hints.
  EXPECT_EQ(Ask(served, {{"hints", {{"tags", {"rooms"}}}}})["map"], "room");
  const Json elsewhere = Ask(served, {{"hints", {{"tags", {"others"}}}}});
  EXPECT_NE(elsewhere["verdict"], "localized");
  EXPECT_EQ(StateOf(elsewhere, "room"), "");
  const Json before = Ask(served, {{"hints", {{"tags", {"others"}}, {"previous_map", "room"}}}});
  EXPECT_EQ(before["map"], "room");
  EXPECT_EQ(Ask(served, {{"hints", {{"tags", {"castles"}}}}})["code"], "not_found");
  EXPECT_EQ(Ask(served, {{"hints", {{"colour", "red"}}}})["code"], "bad_request");
  const RunResult told =
      RunWaystone({"localize", "-", TheMap().inside, "--server", "http://" + served.address(),
                   "--tag", "rooms", "--previous-map", "room", "--json"});
  EXPECT_EQ(told.code, 0) << told.err;
  EXPECT_EQ(Json::parse(told.out)["map"], "room");
  EXPECT_EQ(RunWaystone({"localize", TheMap().map, TheMap().inside, "--tag", "rooms"}).code, 2);

  // Two maps of one place stay ambiguous.
  Publish("twin", TheMap().map);
  EXPECT_TRUE(Until([&] { return served.Get("/readyz")["registry"]["coarse"]["maps"] == 7; }));
  const Json twins = Ask(served);
  EXPECT_EQ(twins["verdict"], "ambiguous") << Dump(twins);
  EXPECT_EQ(twins["decided_by"], "ambiguous_maps");
}

TEST_F(SearchE2e, WhatCouldNotBeAskedIsSaid) {
  Publish("room", TheMap().map);
  Publish("other", OtherRoom(folder_, 1));
  Publish("more", OtherRoom(folder_, 2));
  {
    const RegistryServer served(registry_, folder_ / "cache", {"--memory", MemoryOf(1)});
    EXPECT_TRUE(Until([&] { return served.Get("/readyz")["registry"]["coarse"]["maps"] == 3; }));
    // The store is gone, and so is what nobody has fetched yet.
    fs::rename(folder_ / "registry" / "files", folder_ / "gone");
    const Json failed = Ask(served);
    EXPECT_EQ(failed["code"], "not_ready") << Dump(failed);
    fs::rename(folder_ / "gone", folder_ / "registry" / "files");
    EXPECT_TRUE(Until([&] { return Ask(served).value("map", "") == "room"; }));
  }
  // A memory in which no map can be opened.
  const auto bytes = static_cast<int64_t>(fs::file_size(TheMap().map));
  const RegistryServer small(registry_, folder_ / "cache", {"--memory", std::to_string(2 * bytes)});
  EXPECT_TRUE(Until([&] { return small.Get("/readyz")["registry"]["coarse"]["maps"] == 3; }));
  const Json none = Ask(small, {{"deadline_ms", 20'000}});
  EXPECT_EQ(none["verdict"], "undecided") << Dump(none);
  EXPECT_EQ(none["partial"], true);
  EXPECT_EQ(StateOf(none, "room"), "too_large");
}

}  // namespace
}  // namespace waystone
