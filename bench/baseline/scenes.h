// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <filesystem>
#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "bench/accuracy/common.h"
#include "builder/sources/source.h"
#include "world/render.h"
#include "world/world.h"

namespace waystone::bench {

// What a graph answered to a query, as far as it can be compared with the truth.
struct SceneAnswer {
  int image_frame = 0;      // number of the map's frame that was named as the place
  int reference_frame = 0;  // of the one that the matches lead to
  // Inliers in the query's image, and where the answer puts each in the working image of the
  // reference frame, px.
  std::vector<Eigen::Vector2d> query_points;
  std::vector<Eigen::Vector2d> reference_points;
  int reference_width = 0;  // px, of that working image
};

// A pixel of a working image of width `width`, in the image of width `image_width` from which it
// was made.
Eigen::Vector2d InImage(const Eigen::Vector2d& x, int width, int image_width);

// The points moved by a homography.
std::vector<Eigen::Vector2d> MoveAll(const Eigen::Matrix3d& b_from_a,
                                     const std::vector<Eigen::Vector2d>& points);

// What a map answered, when it says `localized`: the keyframe it named, and its best plane's
// inliers moved by the homography; for a place without planes its keyframe's matches.
SceneAnswer SceneAnswerOf(const MapIndex& index, const Answer& answer);

// A sequence to map with queries whose truth is known.
class Scene {
 public:
  virtual ~Scene() = default;

  virtual const std::string& name() const = 0;
  // The frames to map; a new source each time.
  virtual std::unique_ptr<Source> OpenMap() const = 0;
  virtual int queries() const = 0;
  // An image as a client would have it; decoding is part of a query's time.
  virtual cv::Mat Decode(int query) const = 0;
  virtual bool IsRight(int query, const SceneAnswer& answer) const = 0;
  // What IsRight checks, in one line.
  virtual std::string Criterion() const = 0;
};

// The number of points with known truth that a median error needs.
inline constexpr size_t kMinJudged = 5;

// Median distance, px, at which an answer still counts as right.
struct SceneLimits {
  double kitchen_px = 20;  // its truth has noise of about 5 px
  double church_px = 4;    // to the epipolar line
  double world_px = 10;
  double church_angle_rad = 30 * 3.14159265358979 / 180;  // between the viewing directions
};

// A TUM RGB-D folder with depth and poses. Right: the median of the distances between the inliers,
// moved by the homography, and where depth and poses put them is at most kitchen_px.
std::unique_ptr<Scene> OpenRgbdScene(const std::string& folder, const Range& map,
                                     const Range& queries, const SceneLimits& limits);

// A folder with map/, one or several folders query*/ and poses.csv. Right: the camera of the named
// image looks within church_angle_rad of the query's direction, and the homography's inliers are
// the same points of the scene: the median of the distances between them, moved by the homography,
// and their epipolar lines by the poses is at most church_px, and half of them and more lie in
// front of both cameras when triangulated.
std::unique_ptr<Scene> OpenPhotoScene(const std::filesystem::path& folder,
                                      const SceneLimits& limits);

// Median distance, px, of an answer's inliers from where the rendered planes they are on put them;
// nothing with fewer than kMinJudged of them.
std::optional<double> WorldError(const World& world, const Camera& camera,
                                 const RenderedFrame& query,
                                 const Eigen::Isometry3d& world_from_query,
                                 const Eigen::Isometry3d& world_from_reference,
                                 const SceneAnswer& answer);

// A rendered walk through the demo plan, and another walk through it, higher, with another gaze and
// sway, whose frames are the queries. Right: as in OpenRgbdScene, with world_px, by the rendered
// planes' true homographies.
std::unique_ptr<Scene> MakeWorldScene(int map_frames, int queries, const SceneLimits& limits);

// A calibrated camera.
struct PosedCamera {
  Eigen::Matrix3d k = Eigen::Matrix3d::Identity();
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  Eigen::Matrix3d world_from_camera = Eigen::Matrix3d::Identity();
};
// A line of a folder's poses.csv: role, image, fx, fy, cx, cy, centre, rotation by rows.
struct PhotoPose {
  std::string role;
  std::string image;
  PosedCamera camera;
};
// Throws MapError(kFileUnreadable) for a line with too few or too many cells.
std::vector<PhotoPose> ReadPhotoPoses(const std::filesystem::path& folder);

// Median distance of x_b to the epipolar lines of x_a, px; infinite when fewer than half of the
// points lie in front of both cameras.
double MedianEpipolarError(const PosedCamera& a, const PosedCamera& b,
                           const std::vector<Eigen::Vector2d>& x_a,
                           const std::vector<Eigen::Vector2d>& x_b);

}  // namespace waystone::bench
