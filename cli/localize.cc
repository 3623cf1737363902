// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <iostream>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

#include "cli/commands.h"
#include "cli/map_file.h"
#include "core/base/error.h"
#include "core/image/decode.h"
#include "localizer/localizer.h"
#include "localizer/panorama_series.h"
#include "server/http/answer_json.h"

namespace waystone {
namespace {

struct LocalizeFlags {
  std::string map;
  std::vector<std::string> photos;
  bool json = false;
  bool series = false;
};

std::string Milliseconds(double ms) { return std::to_string(std::lround(ms)) + " ms"; }

// " at (1.20, -3.45), heading 31 deg"
std::string PlaceText(const LayerPlace& place) {
  constexpr double kDegrees = 180 / std::numbers::pi;
  char text[100];
  std::snprintf(text, sizeof text, " at (%.2f, %.2f), heading %.0f deg", place.pose.x, place.pose.y,
                place.pose.theta_rad * kDegrees);
  return text;
}

// "q.jpg: localized near rgb/000120.jpg (plane 3, 143 inliers, 69 ms)"
std::string HumanLine(const Answer& answer) {
  const std::string time = Milliseconds(answer.timing.total_ms);
  if (answer.verdict != Verdict::kLocalized) {
    std::string line = answer.image + ": " + NameOf(answer.verdict);
    if (!answer.message.empty()) line += ": " + answer.message;
    return line + " (" + time + ")";
  }
  std::string line = answer.image + ": localized";
  if (answer.keyframe) line += " near " + answer.keyframe->source;
  if (answer.panorama)
    line += " near " + answer.panorama->node.source + PlaceText(*answer.panorama);
  line += " (";
  if (!answer.planes.empty()) {
    const RecognisedPlane& best = answer.planes.front();
    line += "plane " + std::to_string(best.id.value) + ", " + std::to_string(best.inliers) +
            " inliers, ";
  }
  return line + time + ")";
}

void Print(Answer answer, const OpenMap& map, bool json) {
  answer.map = map.name;
  std::cout << (json ? Dump(ToJson(answer)) : HumanLine(answer)) << std::endl;
}

// Returns whether the photo could be read.
bool AnswerOne(const OpenMap& map, const std::string& photo, bool json) {
  std::vector<uint8_t> bytes;
  try {
    bytes = ReadBytes(photo);
  } catch (const MapError& error) {
    std::cerr << "waystone: " << error.what() << '\n';
    return false;
  }
  const Answer answer = Localize(*map.index, bytes, photo, {});
  Print(answer, map, json);
  return answer.verdict != Verdict::kBadImage;
}

// One panorama after the other, each asked with what the ones before it showed. One that can't be
// read is named and passed over.
bool AnswerSeries(const OpenMap& map, const LocalizeFlags& flags) {
  if (!map.index->HasAppearance()) {
    throw MapError(ErrorCode::kUsage, "map '" + map.name +
                                          "' has no appearance layer, which --series needs; build "
                                          "it from panoramas, or leave --series out");
  }
  bool all_read = true;
  SeriesContext context;
  for (const std::string& photo : flags.photos) {
    try {
      const cv::Mat grey = DecodeGrey(ReadBytes(photo), DecodeLimits{});
      const PanoramaQuery query = DescribeQuery(*map.index, grey, {});
      Answer answer = ContinueSeries(*map.index, query, context);
      context.previous = answer.belief;
      answer.image = photo;
      Print(std::move(answer), map, flags.json);
    } catch (const MapError& error) {
      std::cerr << "waystone: " << photo << ": " << error.what() << '\n';
      all_read = false;
    }
  }
  return all_read;
}

int RunLocalize(const LocalizeFlags& flags) {
  const OpenMap map = OpenMapFile(flags.map, false);
  if (flags.series) return AnswerSeries(map, flags) ? 0 : InfoOf(ErrorCode::kBadImage).exit_code;
  bool all_read = true;
  for (const std::string& photo : flags.photos) all_read &= AnswerOne(map, photo, flags.json);
  return all_read ? 0 : InfoOf(ErrorCode::kBadImage).exit_code;
}

}  // namespace

void AddLocalize(CLI::App& app, Run& run) {
  auto flags = std::make_shared<LocalizeFlags>();
  CLI::App* command =
      app.add_subcommand("localize", "Say where photos were taken, without a server");
  command->add_option("map", flags->map, "Map file")->required();
  command->add_option("photos", flags->photos, "Image files")->required();
  command->add_flag("--json", flags->json, "One JSON object a photo, as the server answers");
  command->add_flag("--series", flags->series,
                    "The images are panoramas of one robot in order: each answer builds on those "
                    "before it");
  command->footer(
      "Exits with 3 when a photo can't be read, after answering the others.\n"
      "Example: waystone localize lab.db photo.jpg --json\n"
      "         waystone localize office.db 1.jpg 2.jpg 3.jpg --series");
  command->callback([flags, &run] { run = [flags] { return RunLocalize(*flags); }; });
}

}  // namespace waystone
