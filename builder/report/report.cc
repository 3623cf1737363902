// SPDX-License-Identifier: Apache-2.0
#include "builder/report/report.h"

#include <cstdint>
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
#include "schema/layers/planes/surfaces.h"

namespace waystone {
namespace {

namespace fs = std::filesystem;

constexpr int kJpegQuality = 85;

void Save(const fs::path& path, std::string_view bytes) {
  std::ofstream out(path, std::ios::binary | std::ios::trunc);
  out << bytes;
  out.close();
  if (!out) {
    throw MapError(ErrorCode::kFileUnwritable,
                   path.string() + " can't be written; choose another folder or free up space");
  }
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

// Makes the folders that are missing, and removes them again.
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
  MakeFolder(dir / "images");
  Save(dir / "index.html",
       ReportHtml(map, report, tables));  // first: the folder is ours from now on
  RemovePictures(dir / "images");
  const std::vector<PlaneId> surface_of_plane = FindSurfaces(map.planes, map.edges);
  for (const Keyframe& keyframe : map.keyframes) {
    const std::vector<uint8_t> jpeg =
        EncodeJpeg(DrawPlanes(map, surface_of_plane, keyframe), kJpegQuality);
    Save(dir / ImageName(keyframe.id), {reinterpret_cast<const char*>(jpeg.data()), jpeg.size()});
  }
}

}  // namespace waystone
