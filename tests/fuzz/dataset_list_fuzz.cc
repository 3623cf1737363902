// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <iterator>

#include "builder/sources/source.h"
#include "tests/fuzz/fuzz_targets.h"

namespace waystone {
namespace {

namespace fs = std::filesystem;

// What the first byte of an input says.
struct Layout {
  char letter;
  const char* folder;
  const char* file;   // has the rest of the input
  const char* image;  // is there
};

constexpr Layout kLayouts[] = {
    {'t', "tum", "rgb.txt", "rgb/1.pgm"},
    {'k', "kitti", "times.txt", "image_0/000001.pgm"},
    {'c', "calibrated", "calib.txt", "image_0/000001.pgm"},
    {'e', "euroc", "data.csv", "data/1.pgm"},
};

}  // namespace

// The input's first byte says of which dataset it is the list, the times or the calibration. A
// sequence has frames, whose times are finite, and so is its camera.
bool FuzzDatasetList(FuzzInput input) {
  const auto* const layout = std::ranges::find(
      kLayouts, input.empty() ? '\0' : static_cast<char>(input[0]), &Layout::letter);
  if (layout == std::end(kLayouts)) return false;
  const fs::path folder = layout->folder;
  fs::create_directories((FuzzFolder() / folder / layout->image).parent_path());
  WriteInput(folder / layout->image, "P5 4 2 255\n" + std::string(8, 'x'));
  WriteInput(folder / layout->file, TextOf(input.subspan(1)));
  const auto source =
      ReadOrRefuse([&] { return OpenSource((FuzzFolder() / folder).string(), {}); });
  if (!source) return false;
  int frames = 0;
  while (const auto frame = (*source)->NextEncoded()) {
    Require(std::isfinite(frame->info().time_s.value_or(0)), "a time is finite");
    ++frames;
  }
  Require(frames > 0, "a sequence has frames, or is refused");
  if (!(*source)->camera()) return true;
  for (const double number : (*source)->camera()->params) {
    Require(std::isfinite(number), "a camera is finite");
  }
  return true;
}

}  // namespace waystone
