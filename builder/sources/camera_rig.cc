// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <utility>

#include "builder/sources/files.h"
#include "builder/sources/recognise.h"
#include "builder/sources/rig_layouts.h"
#include "schema/sequence_kinds.h"

namespace waystone {
namespace {

namespace fs = std::filesystem;

// Whether a rig's cameras are faces of 90 degrees, which together give panoramas.
bool IsCube(const Rig& rig) {
  constexpr double kSamePose = 1e-6;
  constexpr double kSameShare = 1e-3;  // of the width
  for (const RigCamera& camera : rig.cameras) {
    const int width = camera.camera.width;
    if (camera.camera.model != CameraModel::kPinhole || camera.camera.height != width) return false;
    const Rig cube = CubeRig(width);
    const auto face = std::ranges::find(cube.cameras, camera.name, &RigCamera::name);
    if (face == cube.cameras.end()) return false;
    if (!camera.rig_from_camera.isApprox(face->rig_from_camera, kSamePose)) return false;
    for (size_t i = 0; i < face->camera.params.size(); ++i) {
      const double off = std::abs(camera.camera.params[i] - face->camera.params[i]);
      if (off > kSameShare * width) return false;
    }
  }
  return true;
}

// The rig in the frame of its first camera, whose images are the frames: the rotation that all
// cameras together give then holds for its image.
Rig InFrameOfFirst(Rig rig) {
  const Eigen::Isometry3d first_from_rig = rig.cameras.front().rig_from_camera.inverse();
  for (RigCamera& camera : rig.cameras) {
    camera.rig_from_camera = first_from_rig * camera.rig_from_camera;
  }
  return rig;
}

// The moments of a calibrated rig. Its first camera's images are the frames; the others are
// available as well (Source::faces).
class CameraRigSource : public Source {
 public:
  CameraRigSource(const fs::path& folder, RigSequence sequence, const SourceOptions& options)
      : name_(NameOfPath(folder)),
        sequence_(std::make_shared<const RigSequence>(std::move(sequence))),
        limits_(options.limits),
        camera_(sequence_->rig.cameras.front().camera),
        frames_(static_cast<int>(sequence_->moments.size())),
        range_(RangeOf(options, frames_, folder.string())),
        next_(range_.first) {}

  const std::string& kind() const override { return kind_; }
  const std::string& name() const override { return name_; }
  int size() const override { return range_.size(); }
  const std::optional<Camera>& camera() const override { return camera_; }
  cv::Size frame_size() const override { return {camera_->width, camera_->height}; }
  std::optional<Rig> faces() const override { return sequence_->rig; }

  std::string Announcement() const override {
    return "Rig of " + std::to_string(sequence_->rig.cameras.size()) + " cameras, " +
           std::to_string(frames_) + (frames_ == 1 ? " moment" : " moments") +
           UsedPart(size(), frames_);
  }

  std::optional<EncodedFrame> NextEncoded() override {
    if (next_ > range_.last) return std::nullopt;
    const RigMoment& moment = sequence_->moments[next_];
    FrameInfo info{next_, moment.source, moment.time_s};
    next_ += range_.every;
    return EncodedFrame(
        std::move(info),
        [sequence = sequence_, &moment, limits = limits_] {
          return ReadMoment(*sequence, moment, limits);
        },
        [](const std::vector<cv::Mat>& images) { return images.front(); });
  }

 private:
  std::string kind_ = kCamerasKind;
  std::string name_;
  std::shared_ptr<const RigSequence> sequence_;
  DecodeLimits limits_;
  std::optional<Camera> camera_;
  int frames_;
  FrameRange range_;
  int next_;
};

}  // namespace

std::unique_ptr<Source> RecogniseCameraRig(const fs::path& folder, const SourceOptions& options) {
  if (options.camera_file && !HasSeveralCameras(*options.camera_file)) return nullptr;
  const std::optional<Rig> rig = RigOfFolder(folder, options.camera_file);
  if (!rig || rig->cameras.size() < 2 || IsCube(*rig)) return nullptr;
  std::vector<std::string> names;
  for (const RigCamera& camera : rig->cameras) names.push_back(camera.name);
  const auto found = FindCameraImages(folder, names);
  if (!found) return nullptr;
  RigSequence sequence{.layout = found->layout, .rig = InFrameOfFirst(*rig), .moments = {}};
  sequence.moments = GroupMoments(*found, *rig, folder, RigOptions{}.max_time_gap_s);
  return std::make_unique<CameraRigSource>(folder, std::move(sequence), options);
}

}  // namespace waystone
