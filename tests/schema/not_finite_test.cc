// SPDX-License-Identifier: Apache-2.0
// NaN and infinity never get into a map, and never out of one that somebody else made.
#include <gtest/gtest.h>

#include <limits>

#include "schema/file/map_database.h"
#include "schema/file/map_store.h"
#include "schema/layers/layer_blobs.h"
#include "tests/schema/made_map.h"

namespace waystone {
namespace {

namespace fs = std::filesystem;

using Put = std::function<void(MapData&, double)>;

constexpr double kNotANumber = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinite = std::numeric_limits<double>::infinity();

// A map in which everything that may be absent is there.
MapData WholeMap() {
  for (uint64_t seed = 40; seed < 400; ++seed) {
    MapData map = MadeMap(seed);
    const bool whole = map.sequences[0].camera && !map.sequences[0].camera->params.empty() &&
                       !map.edges.empty() && map.appearance->mirror &&
                       map.appearance->mirror->ring && map.appearance->verified_verdict &&
                       map.appearance->metres_per_unit && !map.planes[0].outline.empty() &&
                       !map.planes[0].features.empty();
    if (whole) return map;
  }
  ADD_FAILURE() << "no map has everything";
  return {};
}

Eigen::half Half(double value) { return static_cast<Eigen::half>(static_cast<float>(value)); }

// Every kind of number of the planes.
std::vector<std::pair<std::string, Put>> PlaneNumbers() {
  return {
      {"camera", [](MapData& m, double v) { m.sequences[0].camera->params[0] = v; }},
      {"time", [](MapData& m, double v) { m.keyframes[0].time_s = v; }},
      {"x", [](MapData& m, double v) { m.planes[0].features[0].reference.x_px = float(v); }},
      {"scale",
       [](MapData& m, double v) { m.planes[0].features[0].reference.scale_px = float(v); }},
      {"angle",
       [](MapData& m, double v) { m.planes[0].features[0].reference.angle_rad = float(v); }},
      {"outline", [](MapData& m, double v) { m.planes[0].outline[0].y() = v; }},
      {"homography",
       [](MapData& m, double v) { m.planes[0].views.back().reference_from_keyframe(2, 1) = v; }},
      {"homology", [](MapData& m, double v) { m.edges[0].homology(0, 0) = v; }},
      {"third eigenvalue", [](MapData& m, double v) { m.edges[0].third_eigenvalue = v; }},
      {"intercept", [](MapData& m, double v) { m.verdict->intercept = v; }},
      {"log inliers", [](MapData& m, double v) { m.verdict->log_inliers = v; }},
      {"inlier share", [](MapData& m, double v) { m.verdict->inlier_share = v; }},
  };
}

std::vector<std::pair<std::string, Put>> LayerNumbers() {
  return {
      {"band", [](MapData& m, double v) { m.appearance->described.band.top_rad = v; }},
      {"metres", [](MapData& m, double v) { m.appearance->metres_per_unit = v; }},
      {"mirror band", [](MapData& m, double v) { m.appearance->mirror->band.bottom_rad = v; }},
      {"mirror centre", [](MapData& m, double v) { m.appearance->mirror->ring->centre_px.x = v; }},
      {"mirror radius", [](MapData& m, double v) { m.appearance->mirror->ring->outer_px = v; }},
      {"node time", [](MapData& m, double v) { m.appearance->nodes[0].time_s = v; }},
      {"node", [](MapData& m, double v) { m.appearance->nodes[0].pose.x = v; }},
      {"node angle", [](MapData& m, double v) { m.appearance->nodes[0].pose.theta_rad = v; }},
      {"magnitude",
       [](MapData& m, double v) { m.appearance->nodes[0].signature.magnitudes(0, 0) = Half(v); }},
      {"phase",
       [](MapData& m, double v) { m.appearance->nodes[0].signature.phases(0, 1) = Half(v); }},
      {"distance", [](MapData& m, double v) { m.appearance->edges[0].distance = v; }},
      {"relation", [](MapData& m, double v) { m.appearance->edges[0].a_from_b.y = v; }},
      {"sigma", [](MapData& m, double v) { m.appearance->edges[0].sigma_rad = v; }},
      {"model", [](MapData& m, double v) { m.appearance->verdict->intercept = v; }},
      {"term", [](MapData& m, double v) { m.appearance->verdict->terms[0].weight = v; }},
      {"frame time", [](MapData& m, double v) { m.orientation->frames[0].time_s = v; }},
      {"quaternion",
       [](MapData& m, double v) { m.orientation->frames[0].rotation->building_from_rig.x() = v; }},
      {"covariance",
       [](MapData& m, double v) { m.orientation->frames[0].rotation->covariance(1, 1) = v; }},
      {"turn", [](MapData& m, double v) { m.orientation->turns[0].angle_rad = v; }},
  };
}

TEST(NotFinite, IsNeverWritten) {
  const TemporaryFolder folder;
  const MapData map = WholeMap();
  for (const auto& numbers : {PlaneNumbers(), LayerNumbers()}) {
    for (const auto& [name, put] : numbers) {
      for (const double value : {kNotANumber, kInfinite, -kInfinite}) {
        MapData changed = map;
        put(changed, value);
        const MapError error = ErrorOf([&] { WriteMap(changed, folder / "m.db", {}); });
        EXPECT_EQ(error.code(), ErrorCode::kMapDamaged) << name << " " << value << error.what();
        EXPECT_TRUE(folder.Names().empty()) << name;
      }
    }
  }
}

// Sets one number in the file and makes every CRC fit again: as whoever writes maps could.
class ForgedNumbersTest : public testing::Test {
 protected:
  void ExpectRefused(const std::string& sql) {
    fs::remove(path_);
    WriteMap(map_, path_, {});
    RunSql(path_, sql);
    {
      SQLite::Database database(path_.string(), SQLite::OPEN_READWRITE);
      database.exec("PRAGMA synchronous = OFF");
      WriteContents(database, ExpectedObjects(Migrations()));
      database.exec("VACUUM");
    }
    EXPECT_FALSE(CheckMap(path_).empty()) << sql;
    EXPECT_EQ(ErrorOf([&] { ReadMap(path_); }).code(), ErrorCode::kMapDamaged) << sql;
  }

  // The row gets this blob instead of its own, with its CRC.
  void ExpectBlobRefused(const std::string& table, const std::string& blob, const Bytes& bytes) {
    static constexpr char kHex[] = "0123456789abcdef";
    std::string hex;
    for (const uint8_t byte : bytes) hex += {kHex[byte >> 4], kHex[byte & 15]};
    ExpectRefused("UPDATE " + table + " SET " + blob + " = x'" + hex + "', " + blob +
                  "_crc32c = " + std::to_string(Crc32c(bytes)) + " WHERE length(" + blob +
                  ") = " + std::to_string(bytes.size()));
  }

  TemporaryFolder folder_;
  fs::path path_ = folder_ / "m.db";
  MapData map_ = WholeMap();
};

TEST_F(ForgedNumbersTest, InfiniteColumnsAreRefused) {
  for (const std::string column :
       {"keyframes SET time_s", "edges SET third_eigenvalue", "verdict_model SET intercept",
        "verdict_model SET log_inliers", "appearance_layer SET top_rad",
        "appearance_layer SET metres_per_unit", "appearance_mirror SET inner_px",
        "appearance_nodes SET x", "appearance_edges SET distance",
        "appearance_verdict SET intercept", "appearance_verdict_terms SET weight",
        "orientation_frames SET qx", "orientation_turns SET angle_rad"}) {
    ExpectRefused("UPDATE " + column + " = 9e999");
  }
}

TEST_F(ForgedNumbersTest, BlobsThatAreNotFiniteAreRefused) {
  for (const double value : {kNotANumber, kInfinite}) {
    const Plane& plane = map_.planes[0];
    auto outline = plane.outline;
    outline.back().x() = value;
    ExpectBlobRefused("planes", "outline", EncodeOutline(outline));
    auto features = plane.features;
    features.back().reference.y_px = static_cast<float>(value);
    ExpectBlobRefused("plane_features", "keypoints", EncodeKeypoints(features));
    Eigen::Matrix3d matrix = Eigen::Matrix3d::Identity();
    matrix(1, 2) = value;
    ExpectBlobRefused("plane_views", "homography", EncodeMatrix(matrix));
    ExpectBlobRefused("edges", "homology", EncodeMatrix(matrix));
    ExpectBlobRefused("orientation_frames", "covariance", EncodeMatrix(matrix));
    std::vector<double> params = map_.sequences[0].camera->params;
    params.back() = value;
    ExpectBlobRefused("sequences", "camera_params", EncodeParameters(params));
    FourierSignature signature = map_.appearance->nodes[0].signature;
    signature.magnitudes(1, 1) = Half(value);
    signature.phases(1, 1) = Half(value);
    ExpectBlobRefused("appearance_signatures", "magnitudes", EncodeHalves(signature.magnitudes));
    ExpectBlobRefused("appearance_signatures", "phases", EncodeHalves(signature.phases));
  }
}

}  // namespace
}  // namespace waystone
