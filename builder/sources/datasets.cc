// SPDX-License-Identifier: Apache-2.0
// The public datasets' layouts: TUM RGB-D, KITTI odometry, EuRoC.
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string_view>

#include "builder/sources/files.h"
#include "builder/sources/recognise.h"
#include "core/base/error.h"
#include "core/base/text.h"
#include "schema/sequence_kinds.h"

namespace waystone {
namespace {

namespace fs = std::filesystem;

bool Exists(const fs::path& path) {
  std::error_code ignored;
  return fs::exists(path, ignored);
}

[[noreturn]] void RefuseLine(const fs::path& file, const TextLine& line,
                             const std::string& wanted) {
  throw MapError(ErrorCode::kBadSource, Quoted(file) + " line " + std::to_string(line.number) +
                                            ": '" + line.text.substr(0, 60) + "' is not " + wanted +
                                            "; correct or remove the line");
}

void RefuseEmptyList(const fs::path& file, const ImageList& list) {
  if (!list.images.empty()) return;
  throw MapError(ErrorCode::kBadSource, Quoted(file) + " lists no images");
}

// ToNumber also accepts "nan" and "inf".
std::optional<double> ToFinite(std::string_view word) {
  const std::optional<double> number = ToNumber(word);
  return number && std::isfinite(*number) ? number : std::nullopt;
}

// Time stamps of a KITTI sequence, one per line, in order; none when the file is missing.
std::vector<double> ReadKittiTimes(const fs::path& file) {
  std::vector<double> times;
  if (!Exists(file)) return times;
  for (const TextLine& line : ReadLines(file, ErrorCode::kBadSource)) {
    const auto time = ToFinite(line.text);
    if (!time) RefuseLine(file, line, "a time in seconds");
    if (!times.empty() && *time < times.back()) {
      RefuseLine(file, line, "a time at or after that of the line before");
    }
    times.push_back(*time);
  }
  return times;
}

// The projection matrix `key` of a KITTI calib.txt: "P0: " and a 3x4 matrix, row by row.
Camera ReadKittiCamera(const fs::path& file, const std::string& key) {
  constexpr size_t kEntries = 12;
  for (const TextLine& line : ReadLines(file, ErrorCode::kBadCamera)) {
    std::vector<std::string> words = Words(line.text);
    if (words[0] != key + ":") continue;
    std::vector<double> p;
    for (size_t i = 1; i < words.size(); ++i) {
      if (const auto number = ToFinite(words[i])) p.push_back(*number);
    }
    if (p.size() != kEntries || words.size() != kEntries + 1) {
      throw MapError(ErrorCode::kBadCamera, Quoted(file) + " line " + std::to_string(line.number) +
                                                ": " + key + " has " + std::to_string(p.size()) +
                                                " numbers, not 12; correct it or use --camera");
    }
    return {CameraModel::kPinhole, 0, 0, {p[0], p[5], p[2], p[6]}};
  }
  throw MapError(ErrorCode::kBadCamera,
                 Quoted(file) + " has no line '" + key + ":'; add it or use --camera");
}

// Lists come with other people's data and must not name files elsewhere.
bool LiesInside(const fs::path& path) {
  const fs::path normal = path.lexically_normal();
  return path.is_relative() && normal.begin() != normal.end() && *normal.begin() != "..";
}

}  // namespace

std::optional<ImageList> RecogniseTum(const fs::path& folder) {
  const fs::path file = folder / "rgb.txt";
  if (!Exists(file)) return std::nullopt;
  ImageList list{.kind = kTumKind,
                 .title = "TUM sequence",
                 .name = NameOfPath(folder),
                 .root = folder,
                 .images = {},
                 .own_camera = CameraFileIfThere(folder / kCameraFile)};
  for (const TextLine& line : ReadLines(file, ErrorCode::kBadSource)) {
    const std::vector<std::string> words = Words(line.text);
    const auto time = ToFinite(words[0]);
    if (words.size() != 2 || !time || !LiesInside(words[1])) {
      RefuseLine(file, line, "a time and the name of a file in the same folder");
    }
    list.images.push_back({words[1], time});
  }
  RefuseEmptyList(file, list);
  return list;
}

std::optional<ImageList> RecogniseKitti(const fs::path& folder) {
  // Left grey, left colour, and the right ones where nothing else is there.
  constexpr std::array kCameras{0, 2, 1, 3};
  const fs::path calibration = folder / "calib.txt";
  const auto camera = std::ranges::find_if(
      kCameras, [&](int number) { return Exists(folder / ("image_" + std::to_string(number))); });
  const bool described = Exists(folder / "times.txt") || Exists(calibration);
  if (camera == kCameras.end() || !described) return std::nullopt;
  const std::string images = "image_" + std::to_string(*camera);
  const std::vector<double> times = ReadKittiTimes(folder / "times.txt");
  ImageList list = ListFolder(folder / images);
  for (ListedImage& image : list.images) {
    // The file's name is the number of its line.
    const auto number = ToInteger(image.path.stem().string());
    if (number && *number >= 0 && *number < static_cast<int64_t>(times.size())) {
      image.time_s = times[*number];
    }
    image.path = images / image.path;
  }
  list.kind = kKittiKind;
  list.title = "KITTI sequence";
  list.name = NameOfPath(folder);
  list.root = folder;
  list.own_camera = {};
  if (Exists(calibration)) {
    list.own_camera = [calibration, key = "P" + std::to_string(*camera)] {
      return ReadKittiCamera(calibration, key);
    };
  }
  return list;
}

std::optional<ImageList> RecogniseEuroc(const fs::path& folder) {
  constexpr double kSecondsPerNanosecond = 1e-9;
  const std::array<fs::path, 3> layouts{fs::path("mav0/cam0"), fs::path("cam0"), fs::path()};
  const auto inside = std::ranges::find_if(layouts, [&](const fs::path& layout) {
    return Exists(folder / layout / "data.csv") && Exists(folder / layout / "data");
  });
  if (inside == layouts.end()) return std::nullopt;
  const fs::path file = folder / *inside / "data.csv";
  ImageList list{.kind = kEurocKind,
                 .title = "EuRoC sequence",
                 .name = NameOfPath(folder),
                 .root = folder,
                 .images = {},
                 .own_camera = CameraFileIfThere(folder / *inside / "sensor.yaml")};
  for (const TextLine& line : ReadLines(file, ErrorCode::kBadSource)) {
    const std::vector<std::string> words = Words(line.text, ", \t");
    const auto time_ns = words.empty() ? std::nullopt : ToInteger(words[0]);
    if (words.size() != 2 || !time_ns || !LiesInside(words[1])) {
      RefuseLine(file, line, "a time in nanoseconds, a comma and the name of a file in data");
    }
    list.images.push_back(
        {*inside / "data" / words[1], static_cast<double>(*time_ns) * kSecondsPerNanosecond});
  }
  RefuseEmptyList(file, list);
  return list;
}

}  // namespace waystone
