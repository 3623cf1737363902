// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <filesystem>
#include <iostream>
#include <memory>
#include <string>
#include <vector>

#include "cli/commands.h"
#include "cli/map_file.h"
#include "core/base/error.h"
#include "localizer/localizer.h"
#include "server/http/answer_json.h"

namespace waystone {
namespace {

struct LocalizeFlags {
  std::string map;
  std::vector<std::string> photos;
  bool json = false;
};

std::string Milliseconds(double ms) { return std::to_string(std::lround(ms)) + " ms"; }

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
  line += " (";
  if (!answer.planes.empty()) {
    const RecognisedPlane& best = answer.planes.front();
    line += "plane " + std::to_string(best.id.value) + ", " + std::to_string(best.inliers) +
            " inliers, ";
  }
  return line + time + ")";
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
  Answer answer = Localize(*map.index, bytes, photo, {});
  answer.map = map.name;
  std::cout << (json ? Dump(ToJson(answer)) : HumanLine(answer)) << std::endl;
  return answer.verdict != Verdict::kBadImage;
}

int RunLocalize(const LocalizeFlags& flags) {
  const OpenMap map = OpenMapFile(flags.map, false);
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
  command->footer(
      "Exits with 3 when a photo can't be read, after answering the others.\n"
      "Example: waystone localize lab.db photo.jpg --json");
  command->callback([flags, &run] { run = [flags] { return RunLocalize(*flags); }; });
}

}  // namespace waystone
