// SPDX-License-Identifier: Apache-2.0
#include "cli/files/output_file.h"

#include <system_error>

#include "core/base/error.h"
#include "schema/file/map_database.h"

namespace waystone {
namespace {

namespace fs = std::filesystem;

bool IsMapFile(const fs::path& path) {
  std::error_code ignored;
  if (!fs::is_regular_file(path, ignored)) return false;
  try {
    ReadMapHeader(path);
    return true;
  } catch (const MapError&) {
    return false;
  }
}

}  // namespace

void CheckIsNotInput(const fs::path& output, const fs::path& input, const std::string& what) {
  std::error_code ignored;
  if (!fs::equivalent(output, input, ignored)) return;
  throw MapError(ErrorCode::kFileExists,
                 output.string() + " is " + what + "; choose another name for the output");
}

void CheckReplacesNoMap(const fs::path& output) {
  if (!IsMapFile(output)) return;
  throw MapError(ErrorCode::kFileExists,
                 output.string() +
                     " is a map, which only another map replaces; choose another "
                     "name or remove the file");
}

}  // namespace waystone
