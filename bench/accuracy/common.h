// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "bench/accuracy/benches.h"
#include "builder/build_map.h"
#include "core/robust/quantile.h"
#include "localizer/localizer.h"

namespace waystone::bench {

// The numbers in "250,500" for a comma: {250, 500}; empty unless the text is whole numbers with
// `separator` between them.
std::vector<int> ParseNumbers(const std::string& text, char separator);

// "A:B" or "A:B:STEP": frame numbers from A to B inclusive.
struct Range {
  int from = 0;
  int to = 0;
  int step = 1;
};
// Throws MapError(kUsage) for anything else.
Range ParseRange(const std::string& text);

// Removes `--name VALUE` from the arguments and returns the value; `fallback` when it isn't there.
std::string TakeOption(Args& args, const std::string& name, const std::string& fallback);

// A map of a range of frames of a source, built as `waystone build` does.
BuildResult BuildRange(const std::string& source, const Range& range);

// All image files of a folder and its subfolders (in natural order), or the file itself.
std::vector<std::filesystem::path> ImagesIn(const std::filesystem::path& path);

std::vector<uint8_t> ReadBytes(const std::filesystem::path& path);

// The cells of each line of a CSV file below its heading.
std::vector<std::vector<std::string>> ReadCsv(const std::filesystem::path& path);

// A folder for this process's files, which is removed at the end.
class ScratchFolder {
 public:
  ScratchFolder();
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;
  ~ScratchFolder();
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

// The bytes of the map's file.
int64_t CountFileBytes(const MapData& map);

// The most memory that the process has used so far, MB.
double PeakMb();

}  // namespace waystone::bench
