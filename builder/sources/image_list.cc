// SPDX-License-Identifier: Apache-2.0
#include "builder/sources/image_list.h"

#include <algorithm>

#include "builder/sources/files.h"
#include "core/base/error.h"
#include "core/base/text.h"
#include "core/image/decode.h"

namespace waystone {
namespace {

namespace fs = std::filesystem;

cv::Mat LoadImage(const fs::path& path, const DecodeLimits& limits, cv::Size size) {
  cv::Mat grey = DecodeGrey(ReadImageFile(path, limits, ErrorCode::kBadImage), limits);
  if (grey.size() != size) {
    throw MapError(ErrorCode::kBadImage, "it is " + SizeText(grey.cols, grey.rows) +
                                             ", but the first frame is " +
                                             SizeText(size.width, size.height) +
                                             "; all frames of a sequence must have the same size");
  }
  return grey;
}

class ImageListSource : public Source {
 public:
  ImageListSource(ImageList list, const SourceOptions& options)
      : list_(std::move(list)),
        limits_(options.limits),
        range_(RangeOf(options, static_cast<int>(list_.images.size()), list_.root.string())),
        next_(range_.first),
        size_(SizeOfFirst()),
        camera_(ReadCamera(options)) {}

  const std::string& kind() const override { return list_.kind; }
  const std::string& name() const override { return list_.name; }
  int size() const override { return range_.size(); }
  const std::optional<Camera>& camera() const override { return camera_; }
  cv::Size frame_size() const override { return size_; }

  std::string Announcement() const override {
    const int frames = static_cast<int>(list_.images.size());
    return list_.title + ", " + std::to_string(frames) + (frames == 1 ? " frame " : " frames ") +
           SizeText(size_.width, size_.height) + UsedPart(size(), frames);
  }

  std::optional<EncodedFrame> NextEncoded() override {
    if (next_ > range_.last) return std::nullopt;
    const ListedImage& image = list_.images[next_];
    FrameInfo info{next_, image.path.generic_string(), image.time_s};
    next_ += range_.every;
    return EncodedFrame(std::move(info), [path = list_.root / image.path, limits = limits_,
                                          size = size_] { return LoadImage(path, limits, size); });
  }

 private:
  // Size of the first frame whose header is valid.
  cv::Size SizeOfFirst() const {
    std::string first_error;
    for (int i = range_.first; i <= range_.last; i += range_.every) {
      const fs::path& path = list_.images[i].path;
      try {
        const ImageHeader header =
            ReadImageHeader(ReadImageFile(list_.root / path, limits_, ErrorCode::kBadImage));
        CheckLimits(header, limits_);
        return {header.width, header.height};
      } catch (const MapError& error) {
        if (first_error.empty()) first_error = path.generic_string() + ": " + error.what();
      }
    }
    throw MapError(ErrorCode::kBadSource, "none of the " + std::to_string(range_.size()) +
                                              " frames of " + Quoted(list_.root) +
                                              " can be read; the first is " + first_error);
  }

  std::optional<Camera> ReadCamera(const SourceOptions& options) const {
    if (!options.camera_file && !list_.own_camera) return std::nullopt;
    Camera camera = options.camera_file ? ReadCameraFile(*options.camera_file) : list_.own_camera();
    if (camera.width == 0 && camera.height == 0) {
      camera.width = size_.width;
      camera.height = size_.height;
    }
    CheckCamera(camera);
    CheckCameraSize(camera, size_.width, size_.height, list_.root.string());
    return camera;
  }

  ImageList list_;
  DecodeLimits limits_;
  FrameRange range_;
  int next_;
  cv::Size size_;
  std::optional<Camera> camera_;
};

}  // namespace

std::unique_ptr<Source> OpenImageList(ImageList list, const SourceOptions& options) {
  return std::make_unique<ImageListSource>(std::move(list), options);
}

FrameRange RangeOf(const SourceOptions& options, int frames, const std::string& path) {
  if (options.from >= frames) {
    throw MapError(ErrorCode::kBadSource, "'" + path + "' has " + std::to_string(frames) +
                                              " frames, none at or after index " +
                                              std::to_string(options.from) +
                                              "; use a smaller --from");
  }
  return {options.from, std::min(options.to.value_or(frames - 1), frames - 1),
          std::min(options.every, frames)};
}

std::string UsedPart(int used, int frames) {
  return used == frames ? "" : ", " + std::to_string(used) + " used";
}

void CheckCameraSize(const Camera& camera, int width, int height, const std::string& path) {
  if (camera.width == width && camera.height == height) return;
  throw MapError(ErrorCode::kBadCamera,
                 "the camera is for images of " + SizeText(camera.width, camera.height) +
                     ", those of '" + path + "' are " + SizeText(width, height) +
                     "; use the calibration of these images, or scale its parameters to "
                     "their size");
}

}  // namespace waystone
