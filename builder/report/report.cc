// SPDX-License-Identifier: Apache-2.0
#include "builder/report/report.h"

#include <cstdint>
#include <fstream>
#include <string>
#include <string_view>
#include <vector>

#include "builder/report/html.h"
#include "builder/report/overlay.h"
#include "core/base/error.h"
#include "core/image/encode.h"
#include "schema/layers/planes/surfaces.h"

namespace waystone {
namespace {

constexpr int kJpegQuality = 85;

void Save(const std::filesystem::path& path, std::string_view bytes) {
  std::ofstream out(path, std::ios::binary | std::ios::trunc);
  out << bytes;
  out.close();
  if (!out) {
    throw MapError(ErrorCode::kFileUnwritable,
                   path.string() + " can't be written; choose another folder or free up space");
  }
}

void MakeFolder(const std::filesystem::path& dir) {
  std::error_code error;
  std::filesystem::create_directories(dir, error);
  if (error) {
    throw MapError(ErrorCode::kFileUnwritable, "can't create " + dir.string() + ": " +
                                                   error.message() + "; choose another folder");
  }
}

bool IsReport(const std::filesystem::path& page) {
  std::ifstream in(page, std::ios::binary);
  std::string start(kReportStart.size(), ' ');
  return in.read(start.data(), std::ssize(start)) && start == kReportStart;
}

}  // namespace

void CheckReportFolder(const std::filesystem::path& dir) {
  std::error_code ignored;
  const std::filesystem::path page = dir / "index.html";
  const bool used =
      std::filesystem::exists(page, ignored) || std::filesystem::exists(dir / "images", ignored);
  if (!used || IsReport(page)) return;
  throw MapError(ErrorCode::kFileExists,
                 dir.string() +
                     " has an index.html or images/ that are not a Waystone report; "
                     "choose another folder for the report");
}

void WriteReport(const MapData& map, const BuildReport& report,
                 const std::vector<TableSize>& tables, const std::filesystem::path& dir) {
  CheckReportFolder(dir);
  MakeFolder(dir / "images");
  Save(dir / "index.html",
       ReportHtml(map, report, tables));  // first: the folder is ours from now on
  const std::vector<PlaneId> surface_of_plane = FindSurfaces(map.planes, map.edges);
  for (const Keyframe& keyframe : map.keyframes) {
    const std::vector<uint8_t> jpeg =
        EncodeJpeg(DrawPlanes(map, surface_of_plane, keyframe), kJpegQuality);
    Save(dir / ImageName(keyframe.id), {reinterpret_cast<const char*>(jpeg.data()), jpeg.size()});
  }
}

}  // namespace waystone
