// SPDX-License-Identifier: Apache-2.0
#include "registry/coarse_file.h"

#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <string>

#include "core/base/error.h"
#include "localizer/coarse/coarse_entry.h"
#include "schema/file/file_replacer.h"
#include "schema/file/sha256.h"

namespace waystone {
namespace {

// A file of these bytes, while it exists.
class TemporaryFile {
 public:
  explicit TemporaryFile(const std::string& bytes)
      : path_((std::filesystem::temp_directory_path() / "waystone-coarse-XXXXXX").string()) {
    const int file = mkstemp(path_.data());
    if (file < 0) throw UnwritableError(path_, std::strerror(errno), std::ssize(bytes));
    size_t written = 0;
    while (written < bytes.size()) {
      const ssize_t count = write(file, bytes.data() + written, bytes.size() - written);
      if (count < 0 && errno != EINTR) break;
      written += count > 0 ? static_cast<size_t>(count) : 0;
    }
    const int cause = errno;
    close(file);
    if (written == bytes.size()) return;
    unlink(path_.c_str());
    throw UnwritableError(path_, std::strerror(cause), std::ssize(bytes));
  }
  ~TemporaryFile() { unlink(path_.c_str()); }
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;

  const std::string& path() const { return path_; }

 private:
  std::string path_;
};

}  // namespace

std::optional<CoarseFile> PutCoarseEntry(const Store& store, const MapIndex& index) {
  const CoarseEntry entry = MakeCoarseEntry(index);
  if (entry.codes() == 0) return std::nullopt;
  const std::string bytes = EncodeCoarseEntry(entry);
  const CoarseFile file{
      Sha256({reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size()}),
      std::ssize(bytes)};
  const TemporaryFile written(bytes);
  store.Put(written.path(), file.sha256, file.bytes);
  return file;
}

}  // namespace waystone
