// SPDX-License-Identifier: Apache-2.0
#include "builder/sources/source.h"

#include "builder/sources/files.h"
#include "builder/sources/recognise.h"
#include "core/base/error.h"
#include "core/image/extensions.h"

namespace waystone {
namespace {

namespace fs = std::filesystem;

std::unique_ptr<Source> OpenFolder(const fs::path& folder, const SourceOptions& options) {
  for (const auto recognise : {RecogniseTum, RecogniseKitti, RecogniseEuroc}) {
    if (auto list = recognise(folder)) return OpenImageList(std::move(*list), options);
  }
  if (auto rig = RecogniseCameraRig(folder, options)) return rig;
  if (auto rig = RecogniseRigPanoramas(folder, options)) return rig;
  return OpenImageList(ListFolder(folder), options);
}

std::unique_ptr<Source> Open(const std::string& path, const SourceOptions& options) {
  if (fs::is_directory(path)) return OpenFolder(path, options);
  if (fs::exists(path)) {
    if (HasImageExtension(path)) {
      throw MapError(
          ErrorCode::kBadSource,
          "'" + path + "' is a single image, but a map requires a sequence; use its folder");
    }
    if (!fs::is_regular_file(path)) {
      throw MapError(ErrorCode::kBadSource, "'" + path + "' is neither a folder nor a file");
    }
    return OpenVideo(path, options);
  }
  if (HasWildcard(path)) return OpenImageList(ListPattern(path), options);
  throw MapError(ErrorCode::kBadSource, "'" + path + "' does not exist; check the path");
}

[[noreturn]] void RefuseOption(const std::string& message) {
  throw MapError(ErrorCode::kBadOptions, message);
}

}  // namespace

EncodedFrame::EncodedFrame(FrameInfo info, std::function<cv::Mat()> load)
    : EncodedFrame(
          std::move(info), [load = std::move(load)] { return std::vector<cv::Mat>{load()}; },
          [](const std::vector<cv::Mat>& images) { return images.front(); }) {}

EncodedFrame::EncodedFrame(FrameInfo info, std::function<std::vector<cv::Mat>()> load,
                           std::function<cv::Mat(const std::vector<cv::Mat>&)> join)
    : info_(std::move(info)), load_(std::move(load)), join_(std::move(join)) {}

Frame EncodedFrame::Decode(bool join) const {
  Frame frame{.info = info_, .images = {}, .grey = {}, .error = {}};
  try {
    frame.images = Load();
    if (join) frame.grey = Join(frame.images);
  } catch (const MapError& error) {
    frame.error = error.what();
  }
  return frame;
}

std::optional<Frame> Source::Next() {
  const std::optional<EncodedFrame> frame = NextEncoded();
  if (!frame) return std::nullopt;
  return frame->Decode();
}

void SourceOptions::Check() const {
  CheckFields("source", *this);
  if (to && *to < from) {
    RefuseOption("--to is " + std::to_string(*to) + ", before --from " + std::to_string(from) +
                 "; it must be at least " + std::to_string(from));
  }
}

std::unique_ptr<Source> OpenSource(const std::string& path, const SourceOptions& options) {
  options.Check();
  if (path.empty()) throw MapError(ErrorCode::kBadSource, "the path of the source is empty");
  try {
    return Open(path, options);
  } catch (const fs::filesystem_error& error) {
    throw MapError(
        ErrorCode::kFileUnreadable,
        "'" + path + "' can't be read: " + error.code().message() + "; check its permissions");
  }
}

}  // namespace waystone
