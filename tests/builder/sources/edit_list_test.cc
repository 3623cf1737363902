// SPDX-License-Identifier: Apache-2.0
#include "builder/sources/edit_list.h"

#include <cstdint>
#include <string>

#include "tests/builder/sources/temporary_folder.h"

namespace waystone {
namespace {

std::string BigEndian(uint64_t number, int bytes) {
  std::string text;
  for (int i = bytes - 1; i >= 0; --i) text += static_cast<char>(number >> (8 * i) & 0xff);
  return text;
}

std::string MakeBox(const std::string& name, const std::string& content) {
  return BigEndian(content.size() + 8, 4) + name + content;
}

// mvhd and mdhd: version and flags, two times, units a second, duration.
std::string Times(const std::string& name, uint64_t units_per_s, uint64_t duration) {
  return MakeBox(name, std::string(12, '\0') + BigEndian(units_per_s, 4) + BigEndian(duration, 4));
}

std::string Handler(const std::string& kind) {
  return MakeBox("hdlr", std::string(8, '\0') + kind + std::string(12, '\0'));
}

std::string Edit(uint64_t duration, uint64_t from) {
  return BigEndian(duration, 4) + BigEndian(from, 4) + BigEndian(1 << 16, 4);
}

std::string Track(const std::string& kind, const std::string& edits, int count) {
  return MakeBox(
      "trak", MakeBox("edts", MakeBox("elst", std::string(4, '\0') + BigEndian(count, 4) + edits)) +
                  MakeBox("mdia", Times("mdhd", 90'000, 900'000) + Handler(kind)));
}

// Ten seconds of video; a thousand units a second in the movie.
std::string Movie(const std::string& tracks) {
  return MakeBox("ftyp", "isom") + MakeBox("mdat", std::string(100, 'x')) +
         MakeBox("moov", Times("mvhd", 1000, 10'000) + tracks);
}

class EditListTest : public TemporaryFolder {
 protected:
  double ShareOf(const std::string& bytes) { return PlayedShare(Write("walk.mp4", bytes)); }
};

TEST_F(EditListTest, TheShareThatTheVideoTrackPlays) {
  EXPECT_DOUBLE_EQ(ShareOf(Movie(Track("vide", Edit(10'000, 0), 1))), 1);
  EXPECT_DOUBLE_EQ(ShareOf(Movie(Track("vide", Edit(4000, 90'000), 1))), 0.4);
  EXPECT_DOUBLE_EQ(ShareOf(Movie(Track("vide", Edit(1000, 0) + Edit(2000, 450'000), 2))), 0.3);
  EXPECT_DOUBLE_EQ(
      ShareOf(Movie(Track("soun", Edit(1000, 0), 1) + Track("vide", Edit(5000, 0), 1))), 0.5);
}

TEST_F(EditListTest, PausesAndRepetitionsAddNothing) {
  const std::string pause = Edit(9000, 0xffffffff);
  EXPECT_DOUBLE_EQ(ShareOf(Movie(Track("vide", pause + Edit(2000, 0), 2))), 0.2);
  EXPECT_DOUBLE_EQ(ShareOf(Movie(Track("vide", Edit(9000, 0) + Edit(9000, 0), 2))), 1);
  EXPECT_DOUBLE_EQ(ShareOf(Movie(Track("vide", Edit(0, 0), 1))), 1);  // to the end
}

TEST_F(EditListTest, WhatMakesNoSenseIsAllPlayed) {
  EXPECT_DOUBLE_EQ(PlayedShare(folder_ / "nothing.mp4"), 1);
  EXPECT_DOUBLE_EQ(ShareOf(""), 1);
  EXPECT_DOUBLE_EQ(ShareOf("a letter about boxes"), 1);
  EXPECT_DOUBLE_EQ(ShareOf(Movie("")), 1);
  const std::string whole = Movie(Track("vide", Edit(4000, 0), 1));
  for (size_t size = 0; size < whole.size(); ++size) {
    EXPECT_DOUBLE_EQ(ShareOf(whole.substr(0, size)), 1) << size;
  }
  for (size_t at = 0; at < whole.size(); ++at) {
    std::string damaged = whole;
    damaged[at] = '\xff';
    const double share = ShareOf(damaged);
    EXPECT_GT(share, 0) << at;
    EXPECT_LE(share, 1) << at;
  }
}

}  // namespace
}  // namespace waystone
