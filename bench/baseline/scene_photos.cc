// SPDX-License-Identifier: Apache-2.0
#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "bench/baseline/scenes.h"
#include "core/base/error.h"
#include "core/base/natural_order.h"
#include "core/homography/homography.h"
#include "core/image/decode.h"

namespace waystone::bench {
namespace {

namespace fs = std::filesystem;
using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

Vector3d RayOf(const PosedCamera& camera, const Vector2d& x) {
  return camera.world_from_camera * (camera.k.inverse() * x.homogeneous());
}

// Whether the rays of two pixels come closest in front of both cameras.
bool MeetInFront(const PosedCamera& a, const PosedCamera& b, const Vector2d& x_a,
                 const Vector2d& x_b) {
  const Vector3d ray_a = RayOf(a, x_a);
  const Vector3d ray_b = RayOf(b, x_b);
  Eigen::Matrix<double, 3, 2> rays;
  rays << ray_a, -ray_b;
  const Vector2d along = rays.colPivHouseholderQr().solve(b.centre - a.centre);
  return along.x() > 0 && along.y() > 0;
}

class PhotoScene : public Scene {
 public:
  PhotoScene(const fs::path& folder, const SceneLimits& limits) : folder_(folder), limits_(limits) {
    for (const PhotoPose& photo : ReadPhotoPoses(folder)) poses_[photo.image] = photo.camera;
    name_ = folder.filename();
    map_ = ImagesIn(folder / "map");
    for (const auto& entry : fs::directory_iterator(folder)) {
      if (!entry.path().filename().string().starts_with("query")) continue;
      const auto images = ImagesIn(entry.path());
      queries_.insert(queries_.end(), images.begin(), images.end());
    }
    std::ranges::sort(queries_, [](const fs::path& a, const fs::path& b) {
      return NaturalLess(a.native(), b.native());
    });
    for (const fs::path& image : map_) widths_.push_back(ReadImageHeader(ReadBytes(image)).width);
  }

  const std::string& name() const override { return name_; }
  std::unique_ptr<Source> OpenMap() const override { return OpenSource(folder_ / "map", {}); }
  int queries() const override { return static_cast<int>(queries_.size()); }
  cv::Mat Decode(int query) const override { return DecodeGrey(ReadBytes(queries_[query])); }
  bool IsRight(int query, const SceneAnswer& answer) const override {
    const PosedCamera& asked = PoseOf(queries_[query]);
    const PosedCamera& named = PoseOf(map_.at(answer.image_frame));
    const double cosine = asked.world_from_camera.col(2).dot(named.world_from_camera.col(2));
    if (cosine < std::cos(limits_.church_angle_rad)) return false;
    std::vector<Vector2d> reference_points;
    for (const Vector2d& x : answer.reference_points) {
      reference_points.push_back(
          InImage(x, answer.reference_width, widths_.at(answer.reference_frame)));
    }
    return MedianEpipolarError(asked, PoseOf(map_.at(answer.reference_frame)), answer.query_points,
                               reference_points) <= limits_.church_px;
  }
  std::string Criterion() const override {
    return "looks within 30 degrees of the named photo's direction, and the median epipolar error "
           "by the poses <= " +
           std::to_string(static_cast<int>(limits_.church_px)) + " px";
  }

 private:
  const PosedCamera& PoseOf(const fs::path& image) const {
    return poses_.at(image.filename().string());
  }

  fs::path folder_;
  std::string name_;
  SceneLimits limits_;
  std::map<std::string, PosedCamera> poses_;
  std::vector<fs::path> map_;
  std::vector<int> widths_;  // px, of each of them
  std::vector<fs::path> queries_;
};

}  // namespace

std::vector<PhotoPose> ReadPhotoPoses(const fs::path& folder) {
  constexpr size_t kCells = 18;
  const fs::path path = folder / "poses.csv";
  std::vector<PhotoPose> photos;
  for (const std::vector<std::string>& row : ReadCsv(path)) {
    if (row.size() != kCells) {
      throw MapError(ErrorCode::kFileUnreadable,
                     path.string() + ": a line for " + (row.size() > 1 ? row[1] : row[0]) +
                         " has " + std::to_string(row.size()) + " cells, 18 were expected");
    }
    const auto number = [&](size_t i) { return std::stod(row[i]); };
    PhotoPose photo{row[0], row[1], {}};
    photo.camera.k << number(2), 0, number(4), 0, number(3), number(5), 0, 0, 1;
    photo.camera.centre = Vector3d(number(6), number(7), number(8));
    for (int i = 0; i < 9; ++i) photo.camera.world_from_camera(i / 3, i % 3) = number(9 + i);
    photos.push_back(std::move(photo));
  }
  return photos;
}

double MedianEpipolarError(const PosedCamera& a, const PosedCamera& b,
                           const std::vector<Vector2d>& x_a, const std::vector<Vector2d>& x_b) {
  if (x_a.empty()) return std::numeric_limits<double>::infinity();
  // The epipolar line of x_a in b joins b's images of a's centre and of a point on x_a's ray.
  const auto in_b = [&](const Vector3d& direction) -> Vector3d {
    return b.k * (b.world_from_camera.transpose() * direction);
  };
  std::vector<double> errors;
  int in_front = 0;
  for (size_t i = 0; i < x_a.size(); ++i) {
    const Vector3d line = in_b(a.centre - b.centre).cross(in_b(RayOf(a, x_a[i])));
    errors.push_back(std::abs(line.dot(x_b[i].homogeneous())) / line.head<2>().norm());
    in_front += MeetInFront(a, b, x_a[i], x_b[i]);
  }
  if (2 * in_front < std::ssize(x_a)) return std::numeric_limits<double>::infinity();
  return Quantile(errors, 0.5);
}

std::unique_ptr<Scene> OpenPhotoScene(const fs::path& folder, const SceneLimits& limits) {
  return std::make_unique<PhotoScene>(folder, limits);
}

}  // namespace waystone::bench
