// SPDX-License-Identifier: Apache-2.0
#include "builder/sources/edit_list.h"

#include <string>

#include "tests/builder/sources/made_movie.h"
#include "tests/builder/sources/temporary_folder.h"

namespace waystone {
namespace {

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
