// SPDX-License-Identifier: Apache-2.0
#include "world/write_walk.h"

#include <tbb/parallel_for.h>

#include <cmath>
#include <fstream>
#include <iomanip>
#include <memory>
#include <mutex>
#include <numbers>
#include <opencv2/imgcodecs.hpp>
#include <sstream>
#include <system_error>
#include <vector>

#include "core/base/check.h"
#include "core/base/error.h"
#include "world/texture.h"
#include "world/truth.h"

namespace waystone {
namespace {

namespace fs = std::filesystem;

constexpr double kSwingFrames = 150.0;  // frames from bright to dark and back

constexpr const char* kReadme = R"(A walk through a made building, and its truth.

Made by Waystone (waystone demo --write). All lengths are metres. World frame: x east, y north,
z up, origin at the south-west corner of the plan, at floor height. Camera frame: x right, y down,
z forward. Pixel (0, 0) is the centre of the top left pixel.

plan.txt        the building from above, north up. # wall, . floor, D door, a-z wall with a poster,
                1-9 stops of the walk
poses.csv       frame, time in seconds, position, unit quaternion: x_world = R(q) x_camera + (x, y, z)
planes.csv      every plane: id, kind, a point on it, its unit normal towards the room. Walls in one
                plane that face the same way are one plane, also across a gap.
adjacency.csv   pairs of planes that share an edge of the building, each pair both ways round
camera.yaml     the pinhole camera of images/
images/         one picture a frame
plane_ids/      16 bit pictures: the id of the plane that each pixel of images/ shows
visible.csv     how many pixels of each plane each picture of images/ shows
rig/            six cameras of 90 by 90 degrees at the same pose: front looks along the camera's z
rig.yaml        their calibration and the rotation of each: x_rig = R(q) x_camera
queries/        photos from between the frames, and of another building
odometry.csv    frame, time in seconds, x, y, theta: what a robot's wheels would report, in the frame of
                the first picture (x ahead, y to the left), with their errors
queries.csv     image, the frame before it (empty: another building), position: for waystone eval
panorama/       equirectangular pictures: the middle looks along the camera's z, columns are azimuth
                (growing to the right), rows elevation

The homography of a plane with normal n at distance d from camera a (n . x_a = d), between cameras
a and b with x_b = R x_a + t, is K (R + t n^T / d) K^-1.
Not all of these are there: it depends on what was asked for.
)";

std::string FrameName(size_t frame) {
  std::ostringstream name;
  name << std::setw(6) << std::setfill('0') << frame;
  return name.str();
}

void WriteText(const fs::path& path, const std::string& text) {
  std::ofstream file(path, std::ios::binary);
  file << text;
  file.close();
  if (file.fail()) {
    throw MapError(ErrorCode::kFileUnwritable,
                   "cannot write " + path.string() + "; check the folder and the free space");
  }
}

void WritePicture(const fs::path& path, const cv::Mat& image, const std::vector<int>& flags = {}) {
  bool written = false;
  try {
    written = cv::imwrite(path.string(), image, flags);
  } catch (const cv::Exception&) {
    written = false;
  }
  if (!written) {
    throw MapError(ErrorCode::kFileUnwritable,
                   "cannot write " + path.string() + "; check the folder and the free space");
  }
}

void MakeFolder(const fs::path& path) {
  std::error_code error;
  fs::create_directories(path, error);
  if (error) {
    throw MapError(ErrorCode::kFileUnwritable, "cannot make the folder " + path.string() + ": " +
                                                   error.message() + "; write to another one");
  }
}

void MakeEmptyFolder(const fs::path& path) {
  MakeFolder(path);
  std::error_code error;
  const bool empty = fs::is_empty(path, error);
  if (empty && !error) return;
  throw MapError(ErrorCode::kFileExists,
                 "the folder " + path.string() + " isn't empty; name a new one or empty it");
}

std::ostringstream Numbers() {
  std::ostringstream text;
  text << std::setprecision(12);
  return text;
}

std::string PosesCsv(const Walk& walk) {
  std::ostringstream text = Numbers();
  text << "frame,time_s,x,y,z,qx,qy,qz,qw\n";
  for (size_t i = 0; i < walk.frames.size(); ++i) {
    const Eigen::Vector3d p = walk.frames[i].world_from_camera.translation();
    const Eigen::Quaterniond q(walk.frames[i].world_from_camera.linear());
    text << i << ',' << walk.frames[i].time_s << ',' << p.x() << ',' << p.y() << ',' << p.z() << ','
         << q.x() << ',' << q.y() << ',' << q.z() << ',' << q.w() << '\n';
  }
  return text.str();
}

std::string PlanesCsv(const World& world) {
  std::ostringstream text = Numbers();
  text << "id,kind,x,y,z,nx,ny,nz\n";
  for (const WorldPlane& plane : world.planes()) {
    const Eigen::Vector3d n = plane.normal + Eigen::Vector3d::Zero();  // no "-0"
    text << plane.id << ',' << NameOf(plane.kind) << ',' << plane.origin.x() << ','
         << plane.origin.y() << ',' << plane.origin.z() << ',' << n.x() << ',' << n.y() << ','
         << n.z() << '\n';
  }
  return text.str();
}

std::string AdjacencyCsv(const World& world) {
  std::ostringstream text;
  text << "plane,neighbour\n";
  for (const WorldPlane& plane : world.planes()) {
    for (const int neighbour : plane.neighbours) text << plane.id << ',' << neighbour << '\n';
  }
  return text.str();
}

std::string CameraYaml(const Camera& camera) {
  const Eigen::Matrix3d k = CalibrationMatrix(camera);
  std::ostringstream text = Numbers();
  text << "camera_model: PINHOLE\nimage_width: " << camera.width
       << "\nimage_height: " << camera.height << "\nfx: " << k(0, 0) << "\nfy: " << k(1, 1)
       << "\ncx: " << k(0, 2) << "\ncy: " << k(1, 2) << '\n';
  return text.str();
}

std::string RigYaml(const std::array<RigFace, 6>& rig) {
  std::ostringstream text = Numbers();
  text << "cameras:\n";
  for (const RigFace& face : rig) {
    const Eigen::Quaterniond q(face.rig_from_camera);
    const std::vector<double>& p = face.camera.params;
    text << "  - name: " << face.name
         << "\n    camera_model: PINHOLE\n    image_width: " << face.camera.width
         << "\n    image_height: " << face.camera.height << "\n    fx: " << p[0]
         << "\n    fy: " << p[1] << "\n    cx: " << p[2] << "\n    cy: " << p[3]
         << "\n    rig_from_camera_xyzw: [" << q.x() << ", " << q.y() << ", " << q.z() << ", "
         << q.w() << "]\n";
  }
  return text.str();
}

class Writer {
 public:
  Writer(const World& world, const Walk& walk, fs::path dir, const WriteWalkOptions& options)
      : world_(world), walk_(walk), dir_(std::move(dir)), options_(options) {
    if (options.format == "jpg") flags_ = {cv::IMWRITE_JPEG_QUALITY, options.jpeg_quality};
    if (options.pinhole) pinhole_ = std::make_unique<Renderer>(options.camera);
    if (options.rig) rig_ = std::make_unique<Renderer>(SixFaceRig(options.rig_width_px)[0].camera);
    if (options.panorama) {
      panorama_ = std::make_unique<Renderer>(PanoramaCamera(options.panorama_width_px));
    }
  }

  void WriteConstants() const {
    WriteText(dir_ / "README.txt", kReadme);
    WriteText(dir_ / "plan.txt", world_.plan().Text());
    WriteText(dir_ / "poses.csv", PosesCsv(walk_));
    WriteText(dir_ / "planes.csv", PlanesCsv(world_));
    WriteText(dir_ / "adjacency.csv", AdjacencyCsv(world_));
    if (options_.pinhole) {
      WriteText(dir_ / "camera.yaml", CameraYaml(options_.camera));
      MakeFolder(dir_ / "images");
      if (options_.plane_ids) MakeFolder(dir_ / "plane_ids");
    }
    if (options_.rig) {
      const auto rig = SixFaceRig(options_.rig_width_px);
      WriteText(dir_ / "rig.yaml", RigYaml(rig));
      for (const RigFace& face : rig) MakeFolder(dir_ / "rig" / face.name);
    }
    if (options_.panorama) MakeFolder(dir_ / "panorama");
  }

  void WriteFrames(const WriteProgress& progress) const {
    const size_t count = walk_.frames.size();
    std::vector<std::vector<VisiblePlane>> visible(count);
    std::mutex mutex;
    int done = 0;
    tbb::parallel_for(size_t{0}, count, [&](size_t i) {
      visible[i] = WriteFrame(i);
      const std::lock_guard<std::mutex> lock(mutex);
      if (progress) progress(++done, static_cast<int>(count));
    });
    if (options_.pinhole) WriteVisible(visible);
  }

 private:
  // Returns what the pinhole picture shows.
  std::vector<VisiblePlane> WriteFrame(size_t i) const {
    const Eigen::Isometry3d& pose = walk_.frames[i].world_from_camera;
    const RenderOptions render = FrameRenderOptions(walk_, static_cast<int>(i), options_);
    const std::string name = FrameName(i);
    const std::string picture = name + "." + options_.format;
    if (rig_) WriteRig(picture, pose, render);
    if (panorama_) {
      WritePicture(dir_ / "panorama" / picture, panorama_->Render(world_, pose, render).grey,
                   flags_);
    }
    if (!pinhole_) return {};
    const RenderedFrame frame = pinhole_->Render(world_, pose, render);
    WritePicture(dir_ / "images" / picture, frame.grey, flags_);
    if (options_.plane_ids) WritePicture(dir_ / "plane_ids" / (name + ".png"), frame.plane_ids);
    return VisiblePlanes(frame.plane_ids);
  }

  void WriteRig(const std::string& picture, const Eigen::Isometry3d& pose,
                const RenderOptions& options) const {
    const auto rig = SixFaceRig(options_.rig_width_px);
    for (size_t k = 0; k < rig.size(); ++k) {
      Eigen::Isometry3d rig_from_camera = Eigen::Isometry3d::Identity();
      rig_from_camera.linear() = rig[k].rig_from_camera;
      RenderOptions render = options;
      render.motion = rig_from_camera.inverse(Eigen::Isometry) * options.motion * rig_from_camera;
      render.noise_seed = MixSeeds(options.noise_seed, k);
      WritePicture(dir_ / "rig" / rig[k].name / picture,
                   rig_->Render(world_, pose * rig_from_camera, render).grey, flags_);
    }
  }

  void WriteVisible(const std::vector<std::vector<VisiblePlane>>& visible) const {
    std::ostringstream text;
    text << "frame,plane,pixels\n";
    for (size_t i = 0; i < visible.size(); ++i) {
      for (const VisiblePlane& seen : visible[i]) {
        text << i << ',' << seen.plane << ',' << seen.pixels << '\n';
      }
    }
    WriteText(dir_ / "visible.csv", text.str());
  }

  const World& world_;
  const Walk& walk_;
  const fs::path dir_;
  const WriteWalkOptions& options_;
  std::vector<int> flags_;
  std::unique_ptr<Renderer> pinhole_;
  std::unique_ptr<Renderer> rig_;
  std::unique_ptr<Renderer> panorama_;
};

}  // namespace

void WriteWalkOptions::Check() const {
  CheckFields("walk_files", *this);
  if (format != "jpg" && format != "png") {
    throw MapError(ErrorCode::kBadOptions,
                   "picture format \"" + format + "\"; it must be jpg or png");
  }
  if (pinhole && camera.model != CameraModel::kPinhole &&
      camera.model != CameraModel::kSimplePinhole) {
    throw MapError(
        ErrorCode::kBadOptions,
        "the walk's camera is " + std::string(NameOf(camera.model)) + "; it must be PINHOLE");
  }
}

RenderOptions FrameRenderOptions(const Walk& walk, int frame, const WriteWalkOptions& options) {
  WS_CHECK(frame >= 0 && frame < static_cast<int>(walk.frames.size()), "no such frame");
  RenderOptions render = options.render;
  const auto i = static_cast<size_t>(frame);
  render.noise_seed = MixSeeds(options.render.noise_seed, i);
  render.exposure_gain *= std::pow(1.0 + options.exposure_swing,
                                   std::sin(2.0 * std::numbers::pi * frame / kSwingFrames));
  if (render.motion_samples > 1 && i + 1 < walk.frames.size()) {
    const Eigen::Isometry3d motion = walk.frames[i].world_from_camera.inverse(Eigen::Isometry) *
                                     walk.frames[i + 1].world_from_camera;
    render.motion = PartOfMotion(motion, options.shutter);
  }
  return render;
}

void WriteWalk(const World& world, const Walk& walk, const fs::path& dir,
               const WriteWalkOptions& options, const WriteProgress& progress) {
  options.Check();
  const Writer writer(world, walk, dir, options);
  MakeEmptyFolder(dir);
  writer.WriteConstants();
  writer.WriteFrames(progress);
}

}  // namespace waystone
