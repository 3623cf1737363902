// SPDX-License-Identifier: Apache-2.0
#include "bench/accuracy/common.h"

#include <sys/resource.h>

#include <algorithm>
#include <charconv>
#include <fstream>
#include <iterator>
#include <sstream>

#include "core/base/error.h"
#include "core/base/natural_order.h"
#include "schema/file/map_store.h"

namespace waystone::bench {

std::vector<int> ParseNumbers(const std::string& text, char separator) {
  std::vector<int> numbers;
  const char* at = text.data();
  const char* const end = at + text.size();
  while (true) {
    const auto [stop, error] = std::from_chars(at, end, numbers.emplace_back());
    if (error != std::errc()) return {};
    if (stop == end) return numbers;
    if (*stop != separator) return {};
    at = stop + 1;
  }
}

Range ParseRange(const std::string& text) {
  const std::vector<int> numbers = ParseNumbers(text, ':');
  Range range;
  if (numbers.size() == 2 || numbers.size() == 3) {
    range = {numbers[0], numbers[1], numbers.size() == 3 ? numbers[2] : 1};
  }
  if (numbers.size() < 2 || numbers.size() > 3 || range.from < 0 || range.to < range.from ||
      range.step < 1) {
    throw MapError(ErrorCode::kUsage,
                   "'" + text + "' is no range of frames; write 0:499 or 0:499:10");
  }
  return range;
}

std::string TakeOption(Args& args, const std::string& name, const std::string& fallback) {
  const auto found = std::find(args.begin(), args.end(), "--" + name);
  if (found == args.end()) return fallback;
  if (found + 1 == args.end()) {
    throw MapError(ErrorCode::kUsage, "--" + name + " wants a value");
  }
  std::string value = *(found + 1);
  args.erase(found, found + 2);
  return value;
}

BuildResult BuildRange(const std::string& source, const Range& range) {
  SourceOptions options;
  options.from = range.from;
  options.to = range.to;
  options.every = range.step;
  std::vector<std::unique_ptr<Source>> sources;
  sources.push_back(OpenSource(source, options));
  return BuildMap(sources, BuildOptions{}, {});
}

std::vector<std::filesystem::path> ImagesIn(const std::filesystem::path& path) {
  if (!std::filesystem::is_directory(path)) return {path};
  std::vector<std::filesystem::path> images;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(path)) {
    const std::string extension = entry.path().extension().string();
    if (extension == ".jpg" || extension == ".jpeg" || extension == ".png") {
      images.push_back(entry.path());
    }
  }
  std::ranges::sort(
      images, [](const auto& a, const auto& b) { return NaturalLess(a.native(), b.native()); });
  return images;
}

std::vector<uint8_t> ReadBytes(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) throw MapError(ErrorCode::kFileUnreadable, "can't read " + path.string());
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

std::vector<std::vector<std::string>> ReadCsv(const std::filesystem::path& path) {
  std::ifstream in(path);
  if (!in) throw MapError(ErrorCode::kFileUnreadable, "can't read " + path.string());
  std::vector<std::vector<std::string>> rows;
  std::string line;
  std::getline(in, line);
  while (std::getline(in, line)) {
    std::vector<std::string> cells;
    std::istringstream text(line);
    for (std::string cell; std::getline(text, cell, ',');) cells.push_back(cell);
    if (!cells.empty()) rows.push_back(cells);
  }
  return rows;
}

ScratchFolder::ScratchFolder() {
  std::string name = (std::filesystem::temp_directory_path() / "waystone-bench-XXXXXX").string();
  if (mkdtemp(name.data()) == nullptr) {
    throw MapError(ErrorCode::kFileUnwritable, "can't make " + name);
  }
  path_ = name;
}

ScratchFolder::~ScratchFolder() {
  std::error_code ignored;
  std::filesystem::remove_all(path_, ignored);
}

int64_t CountFileBytes(const MapData& map) {
  const ScratchFolder scratch;
  const std::filesystem::path file = scratch.path() / "map.db";
  WriteMap(map, file, {});
  return static_cast<int64_t>(std::filesystem::file_size(file));
}

double PeakMb() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024;
}

}  // namespace waystone::bench
