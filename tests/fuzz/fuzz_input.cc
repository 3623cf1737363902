// SPDX-License-Identifier: Apache-2.0
#include "tests/fuzz/fuzz_input.h"

#include <stdlib.h>

#include <algorithm>
#include <fstream>
#include <system_error>

namespace waystone {
namespace {

class RemovedFolder {
 public:
  RemovedFolder() {
    std::string name = (std::filesystem::temp_directory_path() / "waystone-fuzz-XXXXXX").string();
    if (mkdtemp(name.data()) == nullptr) throw std::runtime_error("no temporary folder");
    path_ = name;
  }
  ~RemovedFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  RemovedFolder(const RemovedFolder&) = delete;
  RemovedFolder& operator=(const RemovedFolder&) = delete;

  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

}  // namespace

void Require(bool holds, const std::string& property) {
  if (!holds) throw FuzzFinding(property);
}

std::string_view TextOf(FuzzInput input) {
  return {reinterpret_cast<const char*>(input.data()), input.size()};
}

std::pair<std::string_view, FuzzInput> SplitLine(FuzzInput input) {
  const std::string_view text = TextOf(input);
  const size_t end = std::min(text.find('\n'), text.size());
  return {text.substr(0, end), input.subspan(std::min(end + 1, input.size()))};
}

const std::filesystem::path& FuzzFolder() {
  static const RemovedFolder folder;
  return folder.path();
}

std::filesystem::path WriteInput(const std::string& name, std::string_view bytes) {
  std::filesystem::path path = FuzzFolder() / name;
  std::filesystem::remove(path);  // some file systems wait for the disk where a file is cut to 0
  std::ofstream out(path, std::ios::binary | std::ios::trunc);
  out << bytes;
  if (!out.flush()) throw std::runtime_error(path.string() + " can't be written");
  return path;
}

}  // namespace waystone
