// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <memory>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <set>
#include <string>
#include <vector>

#include "cli/commands/commands.h"
#include "cli/files/output_file.h"
#include "cli/files/panorama_file.h"
#include "core/base/error.h"
#include "schema/file/file_replacer.h"

namespace waystone {
namespace {

namespace fs = std::filesystem;

struct UnwrapFlags {
  std::vector<std::string> images;
  std::string out;
  bool force = false;
  PanoramaFlags panorama;
};

// The panorama's row at an elevation, clamped to the image.
int RowAt(const Panorama& panorama, double elevation_rad) {
  const double per_rad = panorama.grey.rows / (panorama.band.top_rad - panorama.band.bottom_rad);
  return std::clamp(cvRound((panorama.band.top_rad - elevation_rad) * per_rad), 0,
                    panorama.grey.rows - 1);
}

// The panorama with two lines around the band that is used, the rest darkened, and the front
// marked.
cv::Mat DrawUsed(const Panorama& panorama, const ElevationBand& band) {
  const int top = RowAt(panorama, band.top_rad);
  const int bottom = RowAt(panorama, band.bottom_rad);
  cv::Mat drawn = panorama.grey / 2;
  panorama.grey.rowRange(top, bottom + 1).copyTo(drawn.rowRange(top, bottom + 1));
  cv::cvtColor(drawn, drawn, cv::COLOR_GRAY2BGR);
  const cv::Scalar orange(0, 140, 255);
  for (const int row : {top, bottom}) cv::line(drawn, {0, row}, {drawn.cols - 1, row}, orange, 2);
  const int front = drawn.cols / 2;
  cv::line(drawn, {front, top}, {front, bottom}, orange, 1);
  return drawn;
}

void Write(const fs::path& path, const cv::Mat& image, bool force) {
  std::vector<uint8_t> png;
  cv::imencode(".png", image, png);
  FileReplacer file(path, force);
  std::ofstream out(file.temporary(), std::ios::binary | std::ios::trunc);
  out.write(reinterpret_cast<const char*>(png.data()), std::ssize(png));
  out.close();
  if (!out) throw UnwritableError(path, std::strerror(errno), std::ssize(png));
  file.Commit();
}

struct Unwrapped {
  fs::path image, panorama, used;
};

// The output files for each image. Throws MapError where one would replace another image.
std::vector<Unwrapped> OutputsOf(const UnwrapFlags& flags) {
  std::vector<Unwrapped> outputs;
  std::set<std::string> names;
  for (const std::string& image : flags.images) {
    const fs::path path(image);
    const std::string name = (path.has_filename() ? path : path.parent_path()).stem().string();
    if (!names.insert(name).second) {
      throw MapError(ErrorCode::kUsage, "two images are named " + name +
                                            ", so their outputs would collide; unwrap them to "
                                            "different folders");
    }
    outputs.push_back({path, fs::path(flags.out) / (name + "_panorama.png"),
                       fs::path(flags.out) / (name + "_used.png")});
  }
  for (const Unwrapped& output : outputs) {
    for (const std::string& image : flags.images) {
      CheckIsNotInput(output.panorama, image, "an image that is unwrapped");
      CheckIsNotInput(output.used, image, "an image that is unwrapped");
    }
  }
  return outputs;
}

int RunUnwrap(const UnwrapFlags& flags) {
  const PanoramaOptions options = PanoramaOptionsOf(flags.panorama);
  const SignatureOptions signature = SignatureOptionsOf(flags.panorama);
  const std::vector<Unwrapped> outputs = OutputsOf(flags);
  std::error_code failure;
  fs::create_directories(flags.out, failure);
  if (failure) throw UnwritableError(flags.out, failure.message(), 0);
  for (const Unwrapped& output : outputs) {
    for (const fs::path& path : {output.panorama, output.used}) {
      CheckReplacesNoMap(path);
      const FileReplacer writable(path, flags.force);
    }
  }
  for (const auto& [image, unwrapped, used] : outputs) {
    const Panorama panorama = ReadPanorama(image, options);
    ExtractBand(panorama, signature);  // refuses what a map would refuse
    Write(unwrapped, panorama.grey, flags.force);
    Write(used, DrawUsed(panorama, signature.band), flags.force);
    std::cout << image.string() << ": " << unwrapped.string() << " (" << panorama.grey.cols << "x"
              << panorama.grey.rows << "), " << used.string() << '\n';
  }
  return 0;
}

}  // namespace

void AddUnwrap(CLI::App& app, Run& run) {
  auto flags = std::make_shared<UnwrapFlags>();
  CLI::App* command =
      app.add_subcommand("unwrap", "Unwrap panoramic images and show the band that is used");
  command->add_option("images", flags->images, "Panoramas, mirror images or rig folders")
      ->required();
  command->add_option("-o,--out", flags->out, "Output folder")->required();
  command->add_flag("--force", flags->force, "Overwrite existing files");
  AddPanoramaFlags(*command, flags->panorama);
  command->footer(
      "Writes NAME_panorama.png, the unwrapped image, and NAME_used.png with the band marked.\n"
      "Example: waystone unwrap mirror.jpg -o unwrapped --mirror 320 240 60 230");
  command->callback([flags, &run] { run = [flags] { return RunUnwrap(*flags); }; });
}

}  // namespace waystone
