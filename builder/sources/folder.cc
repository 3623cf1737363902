// SPDX-License-Identifier: Apache-2.0
#include <glob.h>

#include <algorithm>

#include "builder/sources/files.h"
#include "builder/sources/recognise.h"
#include "core/base/error.h"
#include "core/base/natural_order.h"
#include "core/image/extensions.h"
#include "schema/sequence_kinds.h"

namespace waystone {
namespace {

namespace fs = std::filesystem;

constexpr const char* kImagesFolder = "images";

// The contents of a folder or pattern: images, and for the message what else there is.
struct Contents {
  std::vector<ListedImage> images;  // in natural order
  std::vector<std::string> folders;
  int other_files = 0;
};

// `path` is relative to `root`. Hidden files are neither images (a Mac writes a ._x.jpg beside
// every x.jpg on foreign disks) nor worth mentioning.
void Add(Contents& contents, const fs::path& root, const fs::path& path) {
  if (path.filename().string().starts_with('.')) return;
  std::error_code ignored;
  if (fs::is_directory(root / path, ignored)) {
    contents.folders.push_back(path.string());
  } else if (HasImageExtension(path)) {
    contents.images.push_back({path, std::nullopt});
  } else {
    ++contents.other_files;
  }
}

void Sort(Contents& contents) {
  std::ranges::sort(contents.folders, NaturalLess);
  std::ranges::sort(contents.images, NaturalLess,
                    [](const ListedImage& image) { return image.path.generic_string(); });
}

Contents ListContents(const fs::path& folder) {
  Contents contents;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    Add(contents, folder, entry.path().filename());
  }
  Sort(contents);
  return contents;
}

std::string FoldersText(const std::vector<std::string>& folders) {
  constexpr size_t kShown = 3;
  std::string text =
      folders.size() == 1 ? "1 folder (" : std::to_string(folders.size()) + " folders (";
  for (size_t i = 0; i < std::min(folders.size(), kShown); ++i) {
    text += (i > 0 ? ", " : "") + folders[i];
  }
  return text + (folders.size() > kShown ? ", ...)" : ")");
}

[[noreturn]] void RefuseEmpty(const fs::path& folder, const Contents& contents) {
  std::string message = "no image in " + Quoted(folder) + ": ";
  if (contents.other_files > 0) {
    message += std::to_string(contents.other_files) +
               (contents.other_files == 1 ? " file" : " files") + " found, none of type " +
               ImageExtensionsText();
  } else {
    message += contents.folders.empty() ? "it is empty" : "it contains no files";
  }
  if (contents.folders.empty()) {
    message += "; expected a folder of images, a video, or a TUM, KITTI or EuRoC sequence";
  } else {
    message += ", but it contains " + FoldersText(contents.folders) +
               "; use one of them, or a glob such as " + Quoted(folder / "*" / "*.jpg");
  }
  throw MapError(ErrorCode::kBadSource, message);
}

std::vector<std::string> Matches(const std::string& pattern) {
  glob_t found{};
  const int code = glob(pattern.c_str(), GLOB_NOSORT | GLOB_TILDE, nullptr, &found);
  std::vector<std::string> paths;
  if (code == 0) paths.assign(found.gl_pathv, found.gl_pathv + found.gl_pathc);
  globfree(&found);
  return paths;
}

// "~" and "~user" expanded to the home directory, as in the matches.
fs::path Expanded(const fs::path& part) {
  if (!part.string().starts_with('~')) return part;
  const std::vector<std::string> homes = Matches(part.string());
  return homes.empty() ? part : fs::path(homes.front());
}

// Folder of the pattern: its parts before the first wildcard.
fs::path BaseOf(const fs::path& pattern) {
  fs::path base;
  for (const fs::path& part : pattern.parent_path()) {
    if (HasWildcard(part.string())) break;
    base /= base.empty() ? Expanded(part) : part;
  }
  return base.empty() ? "." : base;
}

}  // namespace

std::string NameOfPath(const fs::path& path) {
  fs::path whole = fs::absolute(path).lexically_normal();
  if (!whole.has_filename()) whole = whole.parent_path();
  return whole.filename().string();
}

std::function<Camera()> CameraFileIfThere(const fs::path& path) {
  std::error_code ignored;
  if (!fs::exists(path, ignored)) return {};
  return [path] { return ReadCameraFile(path); };
}

ImageList ListFolder(const fs::path& folder) {
  Contents contents = ListContents(folder);
  const fs::path inner = folder / kImagesFolder;
  std::error_code ignored;
  // A folder with a camera and images/ is a walk with its truth: pictures beside it aren't frames.
  const bool use_inner = fs::is_directory(inner, ignored) &&
                         (contents.images.empty() || fs::exists(folder / kCameraFile, ignored));
  if (use_inner) {
    Contents inside = ListContents(inner);
    for (ListedImage& image : inside.images) image.path = kImagesFolder / image.path;
    if (!inside.images.empty()) contents.images = std::move(inside.images);
  }
  if (contents.images.empty()) RefuseEmpty(folder, contents);
  ImageList list{.kind = kFolderKind,
                 .title = "Image folder",
                 .name = NameOfPath(folder),
                 .root = folder,
                 .images = std::move(contents.images),
                 .own_camera = {}};
  list.own_camera = CameraFileIfThere(folder / kCameraFile);
  if (!list.own_camera && list.name == kImagesFolder) {
    list.own_camera = CameraFileIfThere(folder / ".." / kCameraFile);
  }
  return list;
}

bool HasWildcard(const std::string& path) { return path.find_first_of("*?[") != std::string::npos; }

ImageList ListPattern(const std::string& pattern) {
  const fs::path base = BaseOf(pattern);
  const std::vector<std::string> matches = Matches(pattern);
  Contents contents;
  for (const std::string& match : matches)
    Add(contents, base, fs::path(match).lexically_relative(base));
  Sort(contents);
  if (contents.images.empty()) {
    throw MapError(ErrorCode::kBadSource, "no image matches '" + pattern + "': it matches " +
                                              std::to_string(matches.size()) +
                                              " files and folders, none of type " +
                                              ImageExtensionsText() + "; check the pattern");
  }
  ImageList list{.kind = kFolderKind,
                 .title = "Images matching '" + pattern + "'",
                 .name = NameOfPath(base),
                 .root = base,
                 .images = std::move(contents.images),
                 .own_camera = CameraFileIfThere(base / kCameraFile)};
  return list;
}

}  // namespace waystone
