// SPDX-License-Identifier: Apache-2.0
#include "builder/report/report.h"

#include <cerrno>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

#include "builder/report/html.h"
#include "builder/report/overlay.h"
#include "core/base/error.h"
#include "core/image/encode.h"
#include "schema/file/file_replacer.h"
#include "schema/layers/planes/surfaces.h"

namespace waystone {
namespace {

namespace fs = std::filesystem;

constexpr int kJpegQuality = 85;

// Leaves nothing at `path` if it fails; `name` is for the message.
void Save(const fs::path& path, const fs::path& name, std::string_view bytes) {
  std::ofstream out(path, std::ios::binary | std::ios::trunc);
  out << bytes;
  if (out.flush()) return;
  const std::string cause = std::strerror(errno);
  out.close();
  std::error_code ignored;
  fs::remove(path, ignored);
  throw UnwritableError(name, cause, std::ssize(bytes));
}

// As a whole: an incomplete page would be taken for somebody else's.
void SavePage(const fs::path& path, std::string_view bytes) {
  FileReplacer file(path, true);
  Save(file.temporary(), path, bytes);
  file.Commit();
}

void MakeFolder(const fs::path& dir) {
  std::error_code error;
  fs::create_directories(dir, error);
  if (error) {
    throw MapError(ErrorCode::kFileUnwritable, "can't create " + dir.string() + ": " +
                                                   error.message() + "; choose another folder");
  }
}

bool IsReport(const fs::path& page) {
  std::ifstream in(page, std::ios::binary);
  std::string start(kReportStart.size(), ' ');
  return in.read(start.data(), std::ssize(start)) && start == kReportStart;
}

// Whether a file has the name of a picture of a report: "17.jpg".
bool IsPictureName(const fs::path& path) {
  const std::string stem = path.stem().string();
  return path.extension() == ".jpg" && stem.find_first_not_of("0123456789") == std::string::npos;
}

// Pictures of an earlier report, which may have more keyframes.
void RemovePictures(const fs::path& images) {
  std::vector<fs::path> old;
  std::error_code ignored;
  for (const fs::directory_entry& entry : fs::directory_iterator(images, ignored)) {
    if (entry.is_regular_file(ignored) && IsPictureName(entry.path())) old.push_back(entry.path());
  }
  for (const fs::path& picture : old) fs::remove(picture, ignored);
}

// Creates the missing folders, and removes them again.
void TryFolder(const fs::path& dir) {
  std::error_code ignored;
  std::vector<fs::path> missing;  // the innermost first
  for (fs::path at = fs::absolute(dir); !fs::exists(at, ignored); at = at.parent_path()) {
    missing.push_back(at);
  }
  MakeFolder(dir);
  for (const fs::path& made : missing) fs::remove(made, ignored);
}

}  // namespace

void CheckReportFolder(const fs::path& dir) {
  std::error_code ignored;
  if (fs::exists(dir, ignored) && !fs::is_directory(dir, ignored)) {
    throw MapError(
        ErrorCode::kFileExists,
        dir.string() + " exists and is not a folder; choose another folder for the report");
  }
  const fs::path page = dir / "index.html";
  if (!IsReport(page)) {
    for (const fs::path& used : {page, dir / "images"}) {
      if (!fs::exists(used, ignored)) continue;
      throw MapError(ErrorCode::kFileExists,
                     used.string() +
                         " exists and is not of a Waystone report; choose another folder for the "
                         "report");
    }
  }
  TryFolder(dir / "images");
}

void WriteReport(const MapData& map, const BuildReport& report,
                 const std::vector<TableSize>& tables, const fs::path& dir) {
  CheckReportFolder(dir);
  MakeFolder(dir);
  SavePage(dir / "index.html",
           ReportHtml(map, report, tables));  // first: the folder is ours from now on
  MakeFolder(dir / "images");
  RemovePictures(dir / "images");
  const std::vector<PlaneId> surface_of_plane = FindSurfaces(map.planes, map.edges);
  for (const Keyframe& keyframe : map.keyframes) {
    const std::vector<uint8_t> jpeg =
        EncodeJpeg(DrawPlanes(map, surface_of_plane, keyframe), kJpegQuality);
    const fs::path picture = dir / ImageName(keyframe.id);
    Save(picture, picture, {reinterpret_cast<const char*>(jpeg.data()), jpeg.size()});
  }
}

}  // namespace waystone
