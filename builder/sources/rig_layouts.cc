// SPDX-License-Identifier: Apache-2.0
#include "builder/sources/rig_layouts.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <utility>

#include "builder/sources/files.h"
#include "core/base/error.h"
#include "core/base/natural_order.h"
#include "core/base/text.h"
#include "core/image/extensions.h"

namespace waystone {
namespace {

namespace fs = std::filesystem;

constexpr const char* kParallel = "parallel folders";
constexpr const char* kNumbered = "numbered folders";
constexpr const char* kOneMoment = "one moment";

bool IsHidden(const fs::path& path) { return path.filename().string().starts_with('.'); }

// The entries of a folder that are folders, or images, by name. An entry that can't be examined (a
// dangling link) counts as an image that can't be read later on.
std::vector<fs::path> Entries(const fs::path& folder, bool folders) {
  std::vector<fs::path> paths;
  std::error_code ignored;
  if (!fs::is_directory(folder, ignored)) return paths;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    if (IsHidden(entry.path())) continue;
    const bool is_folder = entry.is_directory(ignored);
    if (folders ? is_folder : !is_folder && HasImageExtension(entry.path()))
      paths.push_back(entry.path());
  }
  std::ranges::sort(paths, NaturalLess, [](const fs::path& p) { return p.filename().string(); });
  return paths;
}

// The images of a folder that are called like cameras.
std::map<std::string, fs::path> ImagesByCamera(const fs::path& folder,
                                               const std::vector<std::string>& names) {
  std::map<std::string, fs::path> found;
  for (const fs::path& path : Entries(folder, false)) {
    const std::string name = path.stem().string();
    if (std::ranges::find(names, name) != names.end()) found.emplace(name, path);
  }
  return found;
}

// FRONT/000.jpg, BACK/000.jpg
std::optional<CameraImages> FindParallel(const fs::path& folder,
                                         const std::vector<std::string>& names) {
  CameraImages found{.layout = kParallel, .cameras = {}, .images = {}};
  for (const std::string& name : names) {
    std::vector<NamedImage> images;
    for (const fs::path& path : Entries(folder / name, false)) {
      images.push_back({path.filename().string(), path});
    }
    if (images.empty()) continue;
    found.cameras.push_back(name);
    found.images.push_back(std::move(images));
  }
  return found.cameras.empty() ? std::nullopt : std::optional(found);
}

// 000/front.jpg, 000/back.jpg; or front.jpg, back.jpg in the folder itself. A moment without an
// image of a camera has an empty path for it.
std::optional<CameraImages> FindByMoment(const std::vector<fs::path>& folders,
                                         const std::vector<std::string>& names,
                                         const std::string& layout) {
  std::vector<std::pair<std::string, std::map<std::string, fs::path>>> moments;
  for (const fs::path& folder : folders) {
    auto images = ImagesByCamera(folder, names);
    const std::string name =
        folder.has_filename() ? folder.filename() : folder.parent_path().filename();
    if (!images.empty()) moments.emplace_back(name, std::move(images));
  }
  CameraImages found{.layout = layout, .cameras = {}, .images = {}};
  for (const std::string& name : names) {
    const auto has = [&](const auto& moment) { return moment.second.contains(name); };
    if (std::ranges::none_of(moments, has)) continue;
    found.cameras.push_back(name);
    auto& images = found.images.emplace_back();
    for (auto& [moment, by_camera] : moments) images.push_back({moment, by_camera[name]});
  }
  return found.cameras.empty() ? std::nullopt : std::optional(found);
}

[[noreturn]] void Refuse(const fs::path& folder, const std::string& cause) {
  throw MapError(ErrorCode::kBadSource, Quoted(folder) + ": " + cause);
}

// The time in a file's name, in seconds: nanoseconds as in EuRoC, or seconds with a decimal point.
std::optional<double> TimeOf(const fs::path& path) {
  constexpr size_t kNanosecondDigits = 16;
  const std::string name = path.stem().string();
  const auto integer = ToInteger(name);
  if (integer && name.size() >= kNanosecondDigits) return 1e-9 * static_cast<double>(*integer);
  if (integer || name.find('.') == std::string::npos) return std::nullopt;
  return ToNumber(name);
}

bool AllTimed(const std::vector<std::vector<NamedImage>>& images) {
  return std::ranges::all_of(images, [](const auto& list) {
    return std::ranges::all_of(list,
                               [](const auto& image) { return TimeOf(image.path).has_value(); });
  });
}

// A camera's images by time: the index of the first image of each time in its list.
using Timeline = std::map<double, size_t>;

Timeline TimelineOf(const std::vector<NamedImage>& list) {
  Timeline timeline;
  for (size_t i = 0; i < list.size(); ++i) timeline.emplace(*TimeOf(list[i].path), i);
  return timeline;
}

// The image nearest in time, the earlier one in the list if there are two.
std::pair<double, size_t> Nearest(const Timeline& timeline, double time_s) {
  const auto gap_and_place = [&](Timeline::const_iterator at) {
    return std::pair(std::abs(at->first - time_s), at->second);
  };
  const auto after = timeline.lower_bound(time_s);
  if (after == timeline.begin()) return gap_and_place(after);
  const auto before = gap_and_place(std::prev(after));
  return after == timeline.end() ? before : std::min(before, gap_and_place(after));
}

// Each image of the first camera with those of the others nearest in time; moments that lack one
// are left out.
std::vector<RigMoment> ByTime(const std::vector<std::vector<NamedImage>>& images,
                              const fs::path& folder, double max_gap_s) {
  std::vector<Timeline> timelines;
  for (const auto& list : images) timelines.push_back(TimelineOf(list));
  std::vector<RigMoment> moments;
  for (const NamedImage& first : images.front()) {
    RigMoment moment{.source = first.moment, .time_s = TimeOf(first.path), .images = {}};
    for (size_t c = 0; c < images.size(); ++c) {
      const auto [gap_s, nearest] = Nearest(timelines[c], *moment.time_s);
      if (gap_s <= max_gap_s) moment.images.push_back(images[c][nearest].path);
    }
    if (moment.images.size() == images.size()) moments.push_back(std::move(moment));
  }
  if (moments.empty()) {
    Refuse(folder, "no images of all cameras are within " + std::to_string(max_gap_s) +
                       " s of each other; check the time stamps");
  }
  return moments;
}

std::vector<RigMoment> ByOrder(const std::vector<std::vector<NamedImage>>& images, const Rig& rig,
                               const fs::path& folder) {
  const size_t count = images.front().size();
  for (size_t c = 0; c < images.size(); ++c) {
    if (images[c].size() == count) continue;
    Refuse(folder, "camera '" + rig.cameras[c].name + "' has " + std::to_string(images[c].size()) +
                       " images and '" + rig.cameras[0].name + "' has " + std::to_string(count) +
                       "; name the files by time stamp, or remove unmatched images");
  }
  std::vector<RigMoment> moments;
  for (size_t i = 0; i < count; ++i) {
    RigMoment moment{.source = images.front()[i].moment, .time_s = {}, .images = {}};
    for (size_t c = 0; c < images.size(); ++c) {
      if (images[c][i].path.empty()) {
        Refuse(folder / images[c][i].moment,
               "no image of camera '" + rig.cameras[c].name + "'; add it or remove the folder");
      }
      moment.images.push_back(images[c][i].path);
    }
    moments.push_back(std::move(moment));
  }
  return moments;
}

}  // namespace

std::optional<CameraImages> FindCameraImages(const fs::path& folder,
                                             const std::vector<std::string>& names) {
  for (const fs::path& place : {folder, folder / "rig"}) {
    if (auto found = FindParallel(place, names)) return found;
    if (auto found = FindByMoment({place}, names, kOneMoment)) return found;
    if (auto found = FindByMoment(Entries(place, true), names, kNumbered)) return found;
  }
  return std::nullopt;
}

std::vector<RigMoment> GroupMoments(const CameraImages& found, const Rig& rig,
                                    const fs::path& folder, double max_time_gap_s) {
  std::vector<std::vector<NamedImage>> images;
  for (const RigCamera& camera : rig.cameras) {
    const auto at = std::ranges::find(found.cameras, camera.name);
    if (at == found.cameras.end()) {
      Refuse(folder, "no images of camera '" + camera.name + "', one of the rig's " +
                         std::to_string(rig.cameras.size()) +
                         "; add them, or remove the camera from the rig file");
    }
    images.push_back(found.images[at - found.cameras.begin()]);
  }
  const bool timed = found.layout == kParallel && AllTimed(images);
  return timed ? ByTime(images, folder, max_time_gap_s) : ByOrder(images, rig, folder);
}

std::vector<RigMoment> ListMoments(const fs::path& folder) {
  std::vector<RigMoment> moments;
  for (const fs::path& place : {folder, folder / "images", folder / "panorama"}) {
    for (const fs::path& path : Entries(place, false)) {
      moments.push_back({.source = path.filename().string(), .time_s = {}, .images = {path}});
    }
    if (!moments.empty()) break;
  }
  return moments;
}

}  // namespace waystone
