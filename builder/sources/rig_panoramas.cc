// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <utility>

#include "builder/sources/files.h"
#include "builder/sources/recognise.h"
#include "builder/sources/rig_layouts.h"
#include "core/base/error.h"
#include "core/camera/cube_faces.h"
#include "schema/sequence_kinds.h"

namespace waystone {
namespace {

namespace fs = std::filesystem;

std::vector<std::string> FaceNames() {
  std::vector<std::string> names;
  for (int i = 0; i < kCubeFaces; ++i) names.emplace_back(NameOf(static_cast<CubeFace>(i)));
  return names;
}

bool HasSides(const CameraImages& found) {
  const std::vector<std::string> names = FaceNames();
  return std::all_of(names.begin(), names.begin() + kSideFaces, [&](const std::string& name) {
    return std::ranges::find(found.cameras, name) != found.cameras.end();
  });
}

using FacePaths = std::vector<std::pair<CubeFace, fs::path>>;  // by face

std::vector<cv::Mat> LoadFaces(const FacePaths& paths, const DecodeLimits& limits) {
  std::vector<cv::Mat> faces;
  for (const auto& [face, path] : paths) {
    faces.push_back(DecodeGrey(ReadImageFile(path, limits, ErrorCode::kBadImage), limits));
  }
  return faces;
}

cv::Mat JoinFaces(const FacePaths& paths, const std::vector<cv::Mat>& images) {
  FaceImages faces;
  for (size_t i = 0; i < paths.size(); ++i) faces[static_cast<int>(paths[i].first)] = images[i];
  return FromFaces(faces).grey;
}

// Panoramas joined from the faces of six (or four, or five) cameras.
class RigPanoramaSource : public Source {
 public:
  RigPanoramaSource(const fs::path& folder, CameraImages found, const SourceOptions& options)
      : name_(NameOfPath(folder)),
        found_(std::move(found)),
        limits_(options.limits),
        frames_(Frames(folder)),
        range_(RangeOf(options, frames_, folder.string())),
        next_(range_.first) {}

  const std::string& kind() const override { return kind_; }
  const std::string& name() const override { return name_; }
  int size() const override { return range_.size(); }
  const std::optional<Camera>& camera() const override { return camera_; }

  std::string Announcement() const override {
    return "Rig of " + std::to_string(found_.cameras.size()) + " faces, " +
           std::to_string(frames_) + (frames_ == 1 ? " panorama" : " panoramas") +
           UsedPart(size(), frames_);
  }

  std::optional<EncodedFrame> NextEncoded() override {
    if (next_ > range_.last) return std::nullopt;
    FrameInfo info{next_, found_.images.front()[next_].moment, std::nullopt};
    FacePaths paths = PathsOf(next_);
    next_ += range_.every;
    return EncodedFrame(
        std::move(info), [paths, limits = limits_] { return LoadFaces(paths, limits); },
        [paths](const std::vector<cv::Mat>& images) { return JoinFaces(paths, images); });
  }

  // As wide as the first face that can be read; nothing where none can.
  std::optional<Rig> faces() const override {
    for (int frame = range_.first; frame <= range_.last; frame += range_.every) {
      const FacePaths paths = PathsOf(frame);
      try {
        const ImageHeader header =
            ReadImageHeader(ReadImageFile(paths.front().second, limits_, ErrorCode::kBadImage));
        CheckLimits(header, limits_);
        Rig rig;
        for (const auto& [face, path] : paths) {
          rig.cameras.push_back(CubeRig(header.width).cameras[static_cast<size_t>(face)]);
        }
        return rig;
      } catch (const MapError&) {
        continue;  // reported when the frame is decoded
      }
    }
    return std::nullopt;
  }

 private:
  // By face, in the order of rigs' cameras.
  FacePaths PathsOf(int frame) const {
    const std::vector<std::string> names = FaceNames();
    FacePaths paths;
    for (size_t c = 0; c < found_.cameras.size(); ++c) {
      const auto face = std::ranges::find(names, found_.cameras[c]) - names.begin();
      paths.emplace_back(static_cast<CubeFace>(face), found_.images[c][frame].path);
    }
    std::ranges::sort(paths);
    return paths;
  }

  int Frames(const fs::path& folder) const {
    const size_t frames = found_.images.front().size();
    for (size_t c = 0; c < found_.cameras.size(); ++c) {
      if (found_.images[c].size() == frames) continue;
      throw MapError(ErrorCode::kBadSource, Quoted(folder) + " has " + std::to_string(frames) +
                                                " images of " + found_.cameras.front() + " and " +
                                                std::to_string(found_.images[c].size()) + " of " +
                                                found_.cameras[c] +
                                                "; every face must have the same number of images");
    }
    return static_cast<int>(frames);
  }

  std::string kind_ = kRigKind;
  std::string name_;
  std::optional<Camera> camera_;
  CameraImages found_;
  DecodeLimits limits_;
  int frames_;
  FrameRange range_;
  int next_;
};

}  // namespace

std::unique_ptr<Source> RecogniseRigPanoramas(const fs::path& folder,
                                              const SourceOptions& options) {
  auto found = FindCameraImages(folder, FaceNames());
  if (!found || !HasSides(*found)) return nullptr;
  return std::make_unique<RigPanoramaSource>(folder, std::move(*found), options);
}

}  // namespace waystone
