// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <iostream>
#include <map>
#include <memory>
#include <opencv2/imgcodecs.hpp>
#include <set>
#include <string>
#include <vector>

#include "api/json.h"
#include "api/json_value.h"
#include "builder/sources/rig_source.h"
#include "cli/commands/commands.h"
#include "cli/output/directions_picture.h"
#include "core/base/error.h"
#include "core/base/text.h"
#include "core/geometry/angle.h"
#include "core/manhattan/cube_rotations.h"
#include "core/manhattan/great_circles.h"
#include "core/manhattan/manhattan_frame.h"

namespace waystone {
namespace {

struct DirectionsFlags {
  std::vector<std::string> photos;
  std::string camera;
  std::string detector = "edge_drawing";
  std::string draw;  // folder; empty for no pictures
  bool json = false;
};

struct Directions {
  std::string image;
  ManhattanFrame frame;
};

// Columns are the axes, as the rig sees them.
Json AxesJson(const Eigen::Matrix3d& axes) {
  Json rows = Json::array();
  for (int axis = 0; axis < 3; ++axis) {
    rows.push_back({axes(0, axis), axes(1, axis), axes(2, axis)});
  }
  return rows;
}

Json MatrixJson(const Eigen::Matrix3d& matrix) { return AxesJson(matrix.transpose()); }

Json ToJson(const Directions& answer) {
  const ManhattanFrame& frame = answer.frame;
  return {{"image", answer.image},
          {"reliable", frame.reliable()},
          {"trouble", NameOf(frame.error)},
          {"axes", AxesJson(frame.rig_from_axes)},
          {"lines", frame.lines},
          {"support", frame.support},
          {"lines_of_no_axis", std::ranges::count(frame.axis_of_line, -1)},
          {"rival", frame.rival},
          {"covariance_rad2", MatrixJson(frame.covariance)},
          {"sigma_rad", frame.sigma_rad()}};
}

std::string HumanText(const Directions& answer) {
  const ManhattanFrame& frame = answer.frame;
  std::string text = Printable(answer.image) + ": ";
  char line[128];
  if (frame.reliable()) {
    (void)std::snprintf(line, sizeof line, "reliable, sigma %.2f degrees\n",
                        kDegreesPerRadian * frame.sigma_rad());
    text += line;
  } else {
    text += "not reliable: " + std::string(SentenceOf(frame.error)) + "\n";
  }
  for (int axis = 0; axis < 3; ++axis) {
    const Eigen::Vector3d v = frame.rig_from_axes.col(axis);
    (void)std::snprintf(line, sizeof line, "  axis %d  (%7.4f, %7.4f, %7.4f)  %d lines\n", axis + 1,
                        v.x(), v.y(), v.z(), frame.lines[axis]);
    text += line;
  }
  return text;
}

// A moment's images and what was found in them.
struct Looked {
  std::vector<cv::Mat> images;
  std::vector<GreatCircle> lines;
  ManhattanFrame frame;
};

Looked LookAt(const RigSequence& sequence, const RigMoment& moment, const SegmentOptions& options) {
  Looked looked{.images = ReadMoment(sequence, moment), .lines = {}, .frame = {}};
  for (size_t c = 0; c < looked.images.size(); ++c) {
    const auto found = FindGreatCircles(sequence.rig, static_cast<int>(c),
                                        DetectSegments(looked.images[c], options));
    looked.lines.insert(looked.lines.end(), found.begin(), found.end());
  }
  looked.frame = FindManhattanFrame(looked.lines);
  return looked;
}

// "rgb/000012.jpg" becomes "rgb_000012_lines.png": no photo of the same folder is overwritten.
std::string PictureName(std::string source) {
  std::ranges::replace(source, '/', '_');
  return std::filesystem::path(source).stem().string() + "_lines.png";
}

void SavePicture(const std::filesystem::path& folder, const std::string& source,
                 const cv::Mat& picture) {
  std::error_code ignored;  // what can't be made can't be written to either
  std::filesystem::create_directories(folder, ignored);
  const std::filesystem::path path = folder / PictureName(source);
  if (cv::imwrite(path.string(), picture)) return;
  throw MapError(ErrorCode::kFileUnwritable,
                 path.string() + " can't be written; choose another folder or free up space");
}

// Throws MapError where a picture would replace another one or a photo.
void CheckPictures(const std::vector<RigSequence>& sequences, const std::filesystem::path& folder) {
  namespace fs = std::filesystem;
  std::error_code ignored;
  std::set<fs::path> photos;
  for (const RigSequence& sequence : sequences) {
    for (const RigMoment& moment : sequence.moments) {
      for (const fs::path& image : moment.images) photos.insert(fs::canonical(image, ignored));
    }
  }
  std::map<std::string, std::string> source_of_picture;
  for (const RigSequence& sequence : sequences) {
    for (const RigMoment& moment : sequence.moments) {
      const std::string picture = PictureName(moment.source);
      const auto [other, fresh] = source_of_picture.emplace(picture, moment.source);
      if (!fresh) {
        throw MapError(ErrorCode::kUsage, "the pictures of " + other->second + " and " +
                                              moment.source + " would both be " + picture +
                                              "; draw them to different folders");
      }
      if (!photos.contains(fs::weakly_canonical(folder / picture, ignored))) continue;
      throw MapError(ErrorCode::kFileExists,
                     (folder / picture).string() + " is one of the photos; draw to another folder");
    }
  }
}

// Answers every moment of a photo or folder, following the axes from one to the next. Returns
// whether all images could be read.
bool AnswerSequence(const RigSequence& sequence, const DirectionsFlags& flags) {
  const SegmentOptions segments{.detector = SegmentDetectorByName(flags.detector)};
  bool all_read = true;
  // At first the axes closest to the rig's own: x right, y down, z forward.
  Eigen::Matrix3d previous = Eigen::Matrix3d::Identity();
  for (const RigMoment& moment : sequence.moments) {
    Looked looked;
    try {
      looked = LookAt(sequence, moment, segments);
    } catch (const MapError& error) {
      std::cerr << "waystone: " << Printable(error.what()) << '\n';
      all_read = false;
      continue;
    }
    looked.frame = Renumbered(std::move(looked.frame), previous);
    if (looked.frame.reliable()) previous = looked.frame.rig_from_axes;
    if (!flags.draw.empty()) {
      SavePicture(flags.draw, moment.source,
                  DrawDirections(sequence.rig, looked.images, looked.lines, looked.frame));
    }
    const Directions answer{.image = moment.source, .frame = std::move(looked.frame)};
    std::cout << (flags.json ? Dump(ToJson(answer)) + "\n" : HumanText(answer)) << std::flush;
  }
  return all_read;
}

// Those that can be opened, after a message for each that can't.
std::vector<RigSequence> OpenAll(const DirectionsFlags& flags) {
  RigOptions options;
  if (!flags.camera.empty()) {
    options.rig_file = flags.camera;
    (void)ReadRigFile(flags.camera);  // fails once, not for each photo
  }
  std::vector<RigSequence> sequences;
  for (const std::string& path : flags.photos) {
    try {
      sequences.push_back(OpenRigSequence(path, options));
    } catch (const MapError& error) {
      std::cerr << "waystone: " << Printable(error.what()) << '\n';
    }
  }
  return sequences;
}

int RunDirections(const DirectionsFlags& flags) {
  const std::vector<RigSequence> sequences = OpenAll(flags);
  if (!flags.draw.empty()) CheckPictures(sequences, flags.draw);
  bool all_read = sequences.size() == flags.photos.size();
  for (const RigSequence& sequence : sequences) all_read &= AnswerSequence(sequence, flags);
  return all_read ? 0 : InfoOf(ErrorCode::kBadImage).exit_code;
}

}  // namespace

void AddDirections(CLI::App& app, Run& run) {
  auto flags = std::make_shared<DirectionsFlags>();
  CLI::App* command = app.add_subcommand(
      "directions", "Estimate the Manhattan axes in images of calibrated cameras");
  command
      ->add_option("photos", flags->photos, "Photos, panoramas, or folders of images or of a rig")
      ->required();
  command->add_option("--camera", flags->camera,
                      "Camera or rig file; default: rig.yaml or camera.yaml beside the photos");
  command->add_option("--detector", flags->detector, "Line detector: edge_drawing, canny or lsd")
      ->capture_default_str();
  command->add_option("--draw", flags->draw,
                      "Write NAME_lines.png to this folder for each photo: a copy with its lines "
                      "coloured by axis, 1 red, 2 green, 3 blue");
  command->add_flag("--json", flags->json, "Print one JSON object per photo");
  command->footer(
      "Axes are unit vectors in the camera or rig frame (x right, y down, z forward). Their order\n"
      "is the one closest to that frame, and is tracked through the photos of a folder. Exits\n"
      "with status 3 if any photo can't be read, after processing the others.\n"
      "Example: waystone directions photo.jpg --camera camera.yaml --json");
  command->callback([flags, &run] { run = [flags] { return RunDirections(*flags); }; });
}

}  // namespace waystone
