// SPDX-License-Identifier: Apache-2.0
#include "builder/sources/colmap_camera.h"

#include <algorithm>

#include "builder/sources/files.h"
#include "core/base/error.h"
#include "core/base/text.h"

namespace waystone {
namespace {

constexpr size_t kFirstParameter = 4;  // behind id, model, width and height

[[noreturn]] void Refuse(const std::filesystem::path& path, int line, const std::string& cause) {
  throw MapError(ErrorCode::kBadCamera,
                 Quoted(path) + " line " + std::to_string(line) + ": " + cause);
}

bool IsModelName(std::string_view word) {
  return std::ranges::all_of(word, [](char c) { return c == '_' || (c >= 'A' && c <= 'Z'); });
}

bool IsCameraLine(const std::vector<std::string>& words) {
  return words.size() >= kFirstParameter && ToInteger(words[0]) && IsModelName(words[1]);
}

// COLMAP calls the centre of the top left pixel (0.5, 0.5).
void MovePrincipalPoint(Camera& camera) {
  constexpr double kColmapOffset_px = 0.5;
  const std::vector<std::string> names = Words(ParameterNames(camera.model));
  for (size_t i = 0; i < names.size(); ++i) {
    if (names[i] == "cx" || names[i] == "cy") camera.params[i] -= kColmapOffset_px;
  }
}

}  // namespace

bool LooksLikeColmap(const std::filesystem::path& path) {
  const std::vector<TextLine> lines = ReadLines(path, ErrorCode::kBadCamera);
  return !lines.empty() && IsCameraLine(Words(lines[0].text));
}

Camera ReadColmapCamera(const std::filesystem::path& path) {
  const std::vector<TextLine> lines = ReadLines(path, ErrorCode::kBadCamera);
  if (lines.size() != 1) {
    Refuse(path, lines[1].number,
           "there are " + std::to_string(lines.size()) +
               " cameras; provide a file with only the camera of these images");
  }
  const int number = lines[0].number;
  const std::vector<std::string> words = Words(lines[0].text);
  const auto model = CameraModelByName(words[1]);
  if (!model) {
    Refuse(path, number,
           "the model " + words[1] +
               " is not supported; use PINHOLE, SIMPLE_RADIAL, RADIAL, OPENCV, "
               "OPENCV_FISHEYE or FULL_OPENCV");
  }
  Camera camera{.model = *model, .width = 0, .height = 0, .params = {}};
  const auto width = ToInteger(words[2]);
  const auto height = ToInteger(words[3]);
  if (!width || !height) Refuse(path, number, "width and height must be integers");
  // What doesn't fit an int is no size of an image: CheckCamera says so.
  camera.width = static_cast<int>(std::clamp<int64_t>(*width, 0, INT32_MAX));
  camera.height = static_cast<int>(std::clamp<int64_t>(*height, 0, INT32_MAX));
  for (size_t i = kFirstParameter; i < words.size(); ++i) {
    const auto value = ToNumber(words[i]);
    if (!value) Refuse(path, number, "'" + words[i] + "' is not a number");
    camera.params.push_back(*value);
  }
  if (static_cast<int>(camera.params.size()) != ParameterCount(*model)) {
    Refuse(path, number,
           words[1] + " has " + std::to_string(ParameterCount(*model)) + " parameters (" +
               std::string(ParameterNames(*model)) + "), not " +
               std::to_string(camera.params.size()) + "; correct the line");
  }
  MovePrincipalPoint(camera);
  return camera;
}

}  // namespace waystone
