// SPDX-License-Identifier: Apache-2.0
#include "schema/file/folder_entries.h"

#include <dirent.h>

#include <cerrno>
#include <memory>
#include <new>
#include <string_view>
#include <system_error>

namespace waystone {
namespace {

struct CloseFolder {
  void operator()(DIR* folder) const { closedir(folder); }
};

[[noreturn]] void ThrowUnlistable(const std::filesystem::path& folder) {
  if (errno == ENOMEM) throw std::bad_alloc();
  throw std::filesystem::filesystem_error("cannot read the folder", folder,
                                          std::error_code(errno, std::generic_category()));
}

}  // namespace

std::vector<std::string> FolderEntries(const std::filesystem::path& folder) {
  const std::unique_ptr<DIR, CloseFolder> open(opendir(folder.c_str()));
  if (!open) ThrowUnlistable(folder);
  std::vector<std::string> names;
  errno = 0;
  while (const dirent* entry = readdir(open.get())) {
    const std::string_view name = entry->d_name;
    if (name != "." && name != "..") names.emplace_back(name);
    errno = 0;
  }
  if (errno != 0) ThrowUnlistable(folder);
  return names;
}

}  // namespace waystone
