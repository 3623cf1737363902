// SPDX-License-Identifier: Apache-2.0
// Queries of more maps than can be asked: the coarse index proposes, the maps that can be had are
// asked, and what was asked is told.
#include "server/service/map_search.h"

#include <gtest/gtest.h>

#include <chrono>
#include <map>
#include <set>

#include "core/base/error.h"
#include "core/base/random.h"
#include "core/image/encode.h"
#include "tests/server/service/made_map.h"

namespace waystone {
namespace {

// A picture of random rectangles, which has features.
cv::Mat Picture(uint64_t seed) {
  Random random(seed);
  cv::Mat picture(240, 320, CV_8UC1, cv::Scalar(120));
  for (int i = 0; i < 120; ++i) {
    const cv::Rect rectangle(random.Below(300), random.Below(220), 5 + random.Below(30),
                             5 + random.Below(30));
    picture(rectangle & cv::Rect(0, 0, 320, 240)).setTo(random.Below(256));
  }
  return picture;
}

std::string Jpeg(uint64_t seed) {
  const std::vector<uint8_t> bytes = EncodeJpeg(Picture(seed));
  return {bytes.begin(), bytes.end()};
}

// The entry of a map with one place, which shows that picture.
std::shared_ptr<const CoarseEntry> EntryOfPicture(uint64_t seed) {
  auto entry = std::make_shared<CoarseEntry>();
  entry->map_version = "sha256:" + std::string(64, 'a');
  entry->working_pixels = 320 * 240;
  entry->keyframes = 1;
  const Features features = ExtractFeatures(Picture(seed), {});
  const int count = std::min(kMaxPlaceCodes, features.size());
  entry->codes_of = {static_cast<uint8_t>(count)};
  for (int i = 0; i < count; ++i) {
    const WordCode code = Vocabulary::Of(FeatureType::kSift).Encode(features.descriptors.row(i));
    entry->words.push_back(code.word);
    entry->signatures.push_back(code.signature);
  }
  return entry;
}

// Maps of which some can't be had.
class MadeSource : public MapSource {
 public:
  std::map<std::string, MapFinding> findings;  // of those that aren't found
  size_t lot = 2;                              // how many fit at once
  std::vector<std::vector<std::string>> lots;  // that were asked for

  std::vector<std::string> Names() const override { return {}; }
  void CheckName(const std::string&) const override {}
  MapPtr Find(const std::string& name, const Deadline&) override {
    MapData map = MadeMap(2);
    map.info.name = "built as another";
    return std::make_shared<const ServedMap>(name, MapIndex::Build(std::move(map)));
  }
  SearchScope ScopeOf(const MapHints&) const override { return {}; }
  std::vector<FoundMap> FindLot(std::span<const std::string> names,
                                const Deadline& deadline) override {
    std::vector<FoundMap> found;
    lots.emplace_back();
    for (const std::string& name : names.first(std::min(lot, names.size()))) {
      lots.back().push_back(name);
      const auto it = findings.find(name);
      if (it == findings.end()) {
        found.push_back({name, Find(name, deadline), MapFinding::kFound, ""});
      } else {
        found.push_back({name, nullptr, it->second, "it can't be had"});
      }
    }
    return found;
  }
  Json Summary(const std::string&) const override { return {}; }
  Holdings holdings() const override { return {}; }
};

class MapSearchTest : public testing::Test {
 protected:
  MapSearchTest() {
    std::vector<CoarseIndex::Map> maps;
    for (int i = 0; i < 5; ++i) {
      maps.push_back({Name(i), EntryOfPicture(static_cast<uint64_t>(i))});
      scope_.names.push_back(Name(i));
    }
    scope_.coarse = std::make_shared<const CoarseIndex>(std::move(maps));
    request_.images.push_back({"photo", Jpeg(3)});
    request_.received = Clock::now();
  }
  static std::string Name(int i) { return "map " + std::to_string(i); }
  SearchAnswer Ask() {
    return SearchMaps(request_, scope_, LocalizeOptions{}, source_, gate_, computing_);
  }
  static std::set<std::string> States(const SearchAnswer& answer) {
    std::set<std::string> states;
    for (const SearchedMap& one : answer.searched) states.insert(one.name + " " + one.state);
    return states;
  }

  SearchScope scope_;
  QueryRequest request_;
  MadeSource source_;
  QueryGate gate_{1, 4};
  TimedQueries computing_;
};

TEST_F(MapSearchTest, TheLikeliestMapIsAskedFirst) {
  const SearchAnswer answer = Ask();
  ASSERT_FALSE(answer.searched.empty());
  EXPECT_EQ(answer.searched.front().name, "map 3");
  EXPECT_EQ(source_.lots.front().front(), "map 3");
  EXPECT_FALSE(answer.IsPartial());
  size_t asked = 0;
  for (const SearchedMap& one : answer.searched) asked += one.state == "asked";
  EXPECT_EQ(asked, answer.searched.size());
  ASSERT_EQ(answer.answer.images.size(), 1U);
  EXPECT_EQ(answer.answer.images[0].size(), asked);
  for (const Answer& one : answer.answer.images[0]) {
    EXPECT_EQ(one.verdict, Verdict::kNotInMap);
    EXPECT_TRUE(one.map.starts_with("map ")) << "by the name that it is asked by";
  }
}

TEST_F(MapSearchTest, WhatCantBeHadIsToldAndTheOthersAreAsked) {
  scope_.names = {"map 1", "map 2", "map 3"};
  request_.hints = MapHints{{}, {}, "map 1"};
  source_.findings = {{"map 3", MapFinding::kTooLarge}};
  const SearchAnswer answer = Ask();
  EXPECT_TRUE(answer.IsPartial());
  EXPECT_TRUE(States(answer).contains("map 3 too_large"));
  EXPECT_TRUE(States(answer).contains("map 1 asked")) << "the previous map in any case";
  EXPECT_FALSE(States(answer).contains("map 4 asked")) << "what the hints leave out isn't asked";
  source_.findings = {{"map 3", MapFinding::kLate}};
  EXPECT_TRUE(States(Ask()).contains("map 3 late"));
  source_.findings = {{"map 3", MapFinding::kFailed}};
  EXPECT_TRUE(States(Ask()).contains("map 3 failed"));
}

TEST_F(MapSearchTest, WithoutAnyMapThereIsNoAnswer) {
  scope_.names = {"map 3"};
  source_.findings = {{"map 3", MapFinding::kFailed}};
  try {
    Ask();
    ADD_FAILURE() << "an answer of no map";
  } catch (const MapError& error) {
    EXPECT_EQ(error.code(), ErrorCode::kNotReady);
    EXPECT_NE(std::string(error.what()).find("map 3: it can't be had"), std::string::npos);
  }
  request_.deadline_ms = 30'000;
  const SearchAnswer answer = Ask();
  EXPECT_EQ(answer.answer.images.at(0).at(0).verdict, Verdict::kUndecided);
  EXPECT_TRUE(answer.IsPartial());
}

TEST_F(MapSearchTest, ADeadlineThatHasPassedIsUndecided) {
  request_.received = Clock::now() - std::chrono::seconds(10);
  request_.deadline_ms = 1;
  const SearchAnswer answer = Ask();
  EXPECT_EQ(answer.answer.images.at(0).at(0).verdict, Verdict::kUndecided);
  EXPECT_TRUE(answer.IsPartial());
}

TEST_F(MapSearchTest, WhatIsNoImageIsRefused) {
  request_.images[0].bytes = "no image";
  const SearchAnswer answer = Ask();
  EXPECT_EQ(answer.answer.images.at(0).at(0).verdict, Verdict::kBadImage);
  request_.images[0].bytes = Jpeg(3).substr(0, 200);
  EXPECT_EQ(Ask().answer.images.at(0).at(0).verdict, Verdict::kBadImage);
}

TEST_F(MapSearchTest, AnImageLikeNothingIsNotInAnyMap) {
  const std::vector<uint8_t> plain = EncodeJpeg(cv::Mat(240, 320, CV_8UC1, cv::Scalar(90)));
  request_.images[0].bytes.assign(plain.begin(), plain.end());
  const SearchAnswer answer = Ask();
  const Answer& first = answer.answer.images.at(0).at(0);
  EXPECT_EQ(first.verdict, Verdict::kNotInMap);
  EXPECT_NE(first.message.find("no map in the coarse index"), std::string::npos);
  EXPECT_TRUE(answer.searched.empty());
  EXPECT_TRUE(source_.lots.empty());
}

TEST_F(MapSearchTest, AllMapsThatCanBeHadAreFoundLotByLot) {
  source_.findings = {{"map 1", MapFinding::kFailed}};
  const FoundMaps found = FindMaps(scope_, std::nullopt, source_);
  EXPECT_EQ(source_.lots.size(), 3U) << "of two each";
  ASSERT_EQ(found.queried.size(), 4U);
  EXPECT_EQ(found.queried[1].name, "map 2");
  ASSERT_EQ(found.searched.size(), 5U);
  EXPECT_EQ(found.searched[1].state, "failed");
  EXPECT_EQ(found.searched[1].message, "it can't be had");
  EXPECT_EQ(found.searched[2].state, "asked");
  EXPECT_TRUE(IsPartial(found.searched));
  for (const std::string& name : scope_.names) source_.findings[name] = MapFinding::kLate;
  EXPECT_THROW(FindMaps(scope_, std::nullopt, source_), MapError);
}

// Lots of one map each answer as one lot of all.
TEST_F(MapSearchTest, LotsDontChangeTheAnswer) {
  source_.lot = 1;
  const RequestAnswer one_by_one = Ask().answer;
  source_.lot = 10;
  const RequestAnswer together = Ask().answer;
  ASSERT_EQ(one_by_one.images.at(0).size(), together.images.at(0).size());
  for (size_t i = 0; i < together.images[0].size(); ++i) {
    EXPECT_EQ(one_by_one.images[0][i].map, together.images[0][i].map);
    EXPECT_EQ(one_by_one.images[0][i].verdict, together.images[0][i].verdict);
    EXPECT_EQ(one_by_one.images[0][i].probability, together.images[0][i].probability);
  }
  EXPECT_EQ(OverallAnswer(one_by_one).verdict, OverallAnswer(together).verdict);
}

}  // namespace
}  // namespace waystone
