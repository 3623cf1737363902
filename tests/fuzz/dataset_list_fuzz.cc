// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include "builder/sources/recognise.h"
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
  std::optional<ImageList> (*recognise)(const fs::path& folder);
};

constexpr Layout kLayouts[] = {
    {'t', "tum", "rgb.txt", "rgb/1.png", RecogniseTum},
    {'k', "kitti", "times.txt", "image_0/000001.png", RecogniseKitti},
    {'c', "calibrated", "calib.txt", "image_0/000001.png", RecogniseKitti},
    {'e', "euroc", "data.csv", "data/1.png", RecogniseEuroc},
};

}  // namespace

// The input's first byte says of which dataset it is the list, the times or the calibration. Times
// are finite, and so is a camera.
bool FuzzDatasetList(FuzzInput input) {
  const auto* const layout = std::ranges::find(
      kLayouts, input.empty() ? '\0' : static_cast<char>(input[0]), &Layout::letter);
  if (layout == std::end(kLayouts)) return false;
  const fs::path name = layout->folder;
  fs::create_directories((FuzzFolder() / name / layout->image).parent_path());
  WriteInput(name / layout->image, "");
  WriteInput(name / layout->file, TextOf(input.subspan(1)));
  const auto list = ReadOrRefuse([&] { return layout->recognise(FuzzFolder() / name); });
  if (!list) return false;
  Require(list->has_value(), "a layout is recognised, or its list refused");
  const ImageList& images = **list;
  Require(!images.images.empty(), "a list has images, or is refused");
  for (const ListedImage& image : images.images) {
    Require(!image.time_s || std::isfinite(*image.time_s), "a time is finite");
  }
  if (!images.own_camera) return true;
  const auto camera = ReadOrRefuse(images.own_camera);
  if (!camera) return false;
  for (const double number : camera->params) {
    Require(std::isfinite(number), "a camera is finite");
  }
  return true;
}

}  // namespace waystone
