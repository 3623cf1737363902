// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sys/mount.h>

#include <filesystem>
#include <string>

namespace waystone {

// A file system of its own on a folder, where the machine allows it (a container often doesn't).
class MountedFolder {
 public:
  // `options` are those of tmpfs: "size=300k".
  MountedFolder(const std::filesystem::path& folder, const std::string& options)
      : folder_(folder),
        mounted_(mount("none", folder.c_str(), "tmpfs", 0, options.c_str()) == 0) {}
  MountedFolder(const MountedFolder&) = delete;
  MountedFolder& operator=(const MountedFolder&) = delete;
  ~MountedFolder() {
    if (mounted_) umount(folder_.c_str());
  }

  bool mounted() const { return mounted_; }
  bool MakeReadOnly() {
    return mount("none", folder_.c_str(), "tmpfs", MS_REMOUNT | MS_RDONLY, "") == 0;
  }

 private:
  std::filesystem::path folder_;
  bool mounted_;
};

}  // namespace waystone
