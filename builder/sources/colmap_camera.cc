// SPDX-License-Identifier: Apache-2.0
#include "builder/sources/colmap_camera.h"

#include <algorithm>

#include "builder/sources/files.h"
#include "core/base/byte_reader.h"
#include "core/base/error.h"
#include "core/base/text.h"

namespace waystone {
namespace {

constexpr size_t kFirstParameter = 4;  // after id, model, width and height

constexpr int kNoLine = 0;  // of a binary file

[[noreturn]] void Refuse(const std::filesystem::path& path, int line, const std::string& cause) {
  throw MapError(ErrorCode::kBadCamera,
                 Quoted(path) + (line > 0 ? " line " + std::to_string(line) : "") + ": " + cause);
}

[[noreturn]] void RefuseModel(const std::filesystem::path& path, int line,
                              const std::string& model) {
  Refuse(path, line,
         "the model " + model +
             " is not supported; use PINHOLE, SIMPLE_RADIAL, RADIAL, OPENCV, OPENCV_FISHEYE or "
             "FULL_OPENCV");
}

void RequireOne(const std::filesystem::path& path, int line, uint64_t cameras) {
  if (cameras == 1) return;
  Refuse(path, line,
         "there are " + std::to_string(cameras) +
             " cameras; provide a file with only the camera of these images");
}

// A value that doesn't fit an int isn't a valid image size: CheckCamera refuses it.
int ToSide(uint64_t side) { return static_cast<int>(std::min<uint64_t>(side, INT32_MAX)); }

bool IsModelName(std::string_view word) {
  return std::ranges::all_of(word, [](char c) { return c == '_' || (c >= 'A' && c <= 'Z'); });
}

bool IsCameraLine(const std::vector<std::string>& words) {
  return words.size() >= kFirstParameter && ToInteger(words[0]) && IsModelName(words[1]);
}

bool IsBinary(const std::filesystem::path& path) { return path.extension() == ".bin"; }

Camera ReadBinaryCamera(const std::filesystem::path& path) {
  constexpr int64_t kMaxBytes = 1'000'000;
  constexpr size_t kHeadBytes = 24;  // id, model, width, height
  const std::vector<uint8_t> bytes = ReadFile(path, kMaxBytes, ErrorCode::kBadCamera);
  ByteReader reader(
      bytes, {ErrorCode::kBadCamera,
              Quoted(path) + " is cut or isn't COLMAP's cameras.bin; export the model again"});
  RequireOne(path, kNoLine, reader.TakeCount(kHeadBytes));
  reader.Take<uint32_t>();  // id
  const auto model = reader.Take<int32_t>();
  const auto width = reader.Take<uint64_t>();
  const auto height = reader.Take<uint64_t>();
  if (model < 0 || model > static_cast<int>(CameraModel::kFullOpenCv)) {
    RefuseModel(path, kNoLine, "with number " + std::to_string(model));
  }
  Camera camera{static_cast<CameraModel>(model), ToSide(width), ToSide(height), {}};
  for (int i = 0; i < ParameterCount(camera.model); ++i) {
    camera.params.push_back(reader.Take<double>());
  }
  return camera;
}

Camera ReadTextCamera(const std::filesystem::path& path) {
  const std::vector<TextLine> lines = ReadLines(path, ErrorCode::kBadCamera);
  RequireOne(path, lines[lines.size() > 1 ? 1 : 0].number, lines.size());
  const int number = lines[0].number;
  const std::vector<std::string> words = Words(lines[0].text);
  const auto model = CameraModelByName(words[1]);
  if (!model) RefuseModel(path, number, words[1]);
  const auto width = ToInteger(words[2]);
  const auto height = ToInteger(words[3]);
  if (!width || !height) Refuse(path, number, "width and height must be integers");
  Camera camera{
      *model, ToSide(std::max<int64_t>(*width, 0)), ToSide(std::max<int64_t>(*height, 0)), {}};
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
  return camera;
}

}  // namespace

bool LooksLikeColmap(const std::filesystem::path& path) {
  if (IsBinary(path)) return true;
  const std::vector<TextLine> lines = ReadLines(path, ErrorCode::kBadCamera);
  return !lines.empty() && IsCameraLine(Words(lines[0].text));
}

Camera ReadColmapCamera(const std::filesystem::path& path) {
  Camera camera = IsBinary(path) ? ReadBinaryCamera(path) : ReadTextCamera(path);
  MovePrincipalPoint(camera, -kColmapOffset_px);
  return camera;
}

}  // namespace waystone
