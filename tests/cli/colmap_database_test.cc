// SPDX-License-Identifier: Apache-2.0
// The database that COLMAP gets: what it must contain is COLMAP's documentation of its tables.
#include "cli/files/colmap_database.h"

#include <SQLiteCpp/SQLiteCpp.h>
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cstring>
#include <filesystem>

#include "builder/sources/source.h"
#include "core/base/error.h"

namespace waystone {
namespace {

namespace fs = std::filesystem;

class ColmapDatabaseTest : public testing::Test {
 protected:
  ColmapDatabaseTest() {
    fs::create_directories(folder_);
    map_.sequences = {{SequenceId{1}, "walk.mp4", kVideoKind, 9, 0, {}}};
    for (int i = 0; i < 2; ++i) {
      Keyframe keyframe;
      keyframe.id = KeyframeId{10 + i};
      keyframe.sequence = SequenceId{1};
      keyframe.frame = i;
      keyframe.source = "frame " + std::to_string(i);
      keyframe.width = 640;
      keyframe.height = 480;
      map_.keyframes.push_back(keyframe);
      Features features;
      features.width = 640;
      features.height = 480;
      features.keypoints = {{10, 20, 4, 0}, {30.0F + static_cast<float>(i), 40, 4, 0}};
      features.descriptors = Descriptors(128, std::vector<uint8_t>(2 * 128, 127));
      project_.features.push_back({keyframe.id, features});
    }
    VerifiedMatches matches;
    matches.features = {{0, 0}, {1, 1}};
    // Points move along their rows: y_a = y_b.
    matches.fit.fundamental << 0, 0, 0, 0, 0, -1, 0, 1, 0;
    project_.matches.push_back({0, 1, matches});
    project_.map = &map_;
  }
  ~ColmapDatabaseTest() override { fs::remove_all(folder_); }

  void Write() { WriteColmapDatabase(project_, path_, true); }

  template <class Value>
  std::vector<Value> Blob(const std::string& query) const {
    SQLite::Database database(path_.string());
    SQLite::Statement row(database, query);
    EXPECT_TRUE(row.executeStep()) << query;
    const SQLite::Column column = row.getColumn(0);
    std::vector<Value> values(column.getBytes() / sizeof(Value));
    if (!values.empty()) std::memcpy(values.data(), column.getBlob(), column.getBytes());
    return values;
  }
  std::string Text(const std::string& query) const {
    SQLite::Database database(path_.string());
    return database.execAndGet(query).getString();
  }

  fs::path folder_ = fs::temp_directory_path() / "waystone_colmap_database";
  fs::path path_ = folder_ / "database.db";
  MapData map_;
  ColmapProject project_;
};

TEST_F(ColmapDatabaseTest, HasImagesKeypointsAndMatches) {
  Write();
  EXPECT_EQ(Text("SELECT group_concat(image_id || ' ' || name) FROM images ORDER BY image_id"),
            "10 frame 0.jpg,11 frame 1.jpg");
  EXPECT_EQ(Blob<float>("SELECT data FROM keypoints WHERE image_id = 11"),
            (std::vector<float>{10.5, 20.5, 31.5, 40.5}));
  EXPECT_EQ(Text("SELECT rows || ' ' || cols FROM keypoints"), "2 2");
  EXPECT_EQ(Text("SELECT rows || ' ' || cols FROM descriptors"), "2 128");
  EXPECT_EQ(Blob<uint8_t>("SELECT data FROM descriptors"), std::vector<uint8_t>(256, 254));
  for (const char* table : {"matches", "two_view_geometries"}) {
    const std::string from = std::string(" FROM ") + table;
    EXPECT_EQ(Text("SELECT pair_id || ' ' || rows || ' ' || cols" + from), "21474836481 2 2");
    EXPECT_EQ(Blob<uint32_t>("SELECT data" + from), (std::vector<uint32_t>{0, 0, 1, 1}));
  }
}

TEST_F(ColmapDatabaseTest, HasFundamentalMatricesInColmapsPixels) {
  Write();
  const auto f = Blob<double>("SELECT F FROM two_view_geometries");
  ASSERT_EQ(f.size(), 9U);
  const Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> fundamental(f.data());
  const auto a = Blob<float>("SELECT data FROM keypoints WHERE image_id = 10");
  const auto b = Blob<float>("SELECT data FROM keypoints WHERE image_id = 11");
  for (size_t i = 0; i < a.size(); i += 2) {
    const Eigen::Vector3d x_a(a[i], a[i + 1], 1);
    const Eigen::Vector3d x_b(b[i], b[i + 1], 1);
    EXPECT_NEAR(x_b.dot(fundamental * x_a), 0, 1e-9);
    EXPECT_GT(std::abs(x_b.dot(fundamental * (x_a + Eigen::Vector3d::UnitY()))), 0.1);
  }
  project_.matches[0].matches.fit.planar = true;  // no matrix is determined then
  Write();
  EXPECT_TRUE(Blob<double>("SELECT F FROM two_view_geometries").empty());
}

TEST_F(ColmapDatabaseTest, GuessesACameraThatTheMapDoesNotKnow) {
  Write();
  EXPECT_EQ(Text("SELECT camera_id || ' ' || model || ' ' || width || ' ' || height || ' ' || "
                 "prior_focal_length FROM cameras"),
            "1 2 640 480 0");
  EXPECT_EQ(Blob<double>("SELECT params FROM cameras"), (std::vector<double>{768, 320, 240, 0}));
  map_.sequences[0].camera = {CameraModel::kPinhole, 640, 480, {500, 501, 319, 239}};
  Write();
  EXPECT_EQ(Text("SELECT model || ' ' || prior_focal_length FROM cameras"), "1 1");
  EXPECT_EQ(Blob<double>("SELECT params FROM cameras"),
            (std::vector<double>{500, 501, 319.5, 239.5}));
}

// Features are found in smaller copies of large images, and COLMAP is asked about the images.
TEST_F(ColmapDatabaseTest, IsInPixelsOfTheOriginalImages) {
  for (SampledKeyframe& keyframe : project_.features) {
    keyframe.features.image_width = 1920;
    keyframe.features.image_height = 1440;
  }
  Write();
  // The middle of a pixel of the copy is that of three by three: 3 x + 1, and COLMAP adds a half.
  EXPECT_EQ(Blob<float>("SELECT data FROM keypoints WHERE image_id = 11"),
            (std::vector<float>{31.5, 61.5, 94.5, 121.5}));
  EXPECT_EQ(Text("SELECT width || ' ' || height FROM cameras"), "1920 1440");
  const std::vector<double> f = Blob<double>("SELECT F FROM two_view_geometries");
  const Eigen::Matrix3d fundamental =
      Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(f.data());
  EXPECT_NEAR(Eigen::Vector3d(94.5, 121.5, 1).dot(fundamental * Eigen::Vector3d(31.5, 121.5, 1)), 0,
              1e-9);
  EXPECT_GT(
      std::abs(Eigen::Vector3d(94.5, 121.5, 1).dot(fundamental * Eigen::Vector3d(31.5, 124.5, 1))),
      0.1);
}

TEST_F(ColmapDatabaseTest, NamesTheSequencesOfSeveral) {
  map_.sequences.push_back({SequenceId{2}, "rooms", kFolderKind, 9, 0, {}});
  map_.keyframes[1].sequence = SequenceId{2};
  map_.keyframes[1].source = "a/b.png";
  EXPECT_EQ(ColmapImageName(map_, map_.keyframes[0]), "walk.mp4/frame 0.jpg");
  EXPECT_EQ(ColmapImageName(map_, map_.keyframes[1]), "rooms/a/b.png");
}

TEST_F(ColmapDatabaseTest, ReplacesNothingUnasked) {
  Write();
  EXPECT_THROW(WriteColmapDatabase(project_, path_, false), MapError);
  EXPECT_THROW(WriteColmapDatabase(project_, folder_ / "missing" / "database.db", true), MapError);
}

}  // namespace
}  // namespace waystone
