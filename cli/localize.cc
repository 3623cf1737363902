// SPDX-License-Identifier: Apache-2.0
#include <filesystem>
#include <iostream>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "api/answer_json.h"
#include "cli/answer_text.h"
#include "cli/asked_server.h"
#include "cli/commands.h"
#include "cli/map_file.h"
#include "core/base/error.h"
#include "core/image/decode.h"
#include "localizer/appearance/panorama_series.h"
#include "localizer/localizer.h"
#include "server/http/localize_request.h"

namespace waystone {
namespace {

struct LocalizeFlags {
  std::string map;
  std::vector<std::string> photos;
  bool json = false;
  bool series = false;
  std::optional<double> fov_deg;
  ServerFlags server;
};

// The flags as a request of the server says them, so that both understand the same.
LocalizeRequest RequestOf(const LocalizeFlags& flags) {
  Json object = Json::object();
  if (flags.fov_deg) object["fov_deg"] = *flags.fov_deg;
  return ParseRequestObject(object, {});
}

void PrintJson(const Json& answer, bool json) {
  std::cout << (json ? Dump(answer) : AnswerLine(answer)) << std::endl;
}

void Print(Answer answer, const OpenMap& map, bool json) {
  answer.map = map.name;
  PrintJson(ToJson(answer), json);
}

// Returns whether the photo could be read.
bool AnswerOne(const OpenMap& map, const std::string& photo, const LocalizeFlags& flags) {
  std::vector<uint8_t> bytes;
  try {
    bytes = ReadBytes(photo);
  } catch (const MapError& error) {
    std::cerr << "waystone: " << error.what() << '\n';
    return false;
  }
  LocalizeOptions options;
  options.camera = CameraFor(RequestOf(flags), map.index->map(),
                             {photo, std::string(bytes.begin(), bytes.end())});
  const Answer answer = Localize(*map.index, bytes, photo, options);
  Print(answer, map, flags.json);
  return answer.verdict != Verdict::kBadImage;
}

// One panorama after the other, each asked with what the ones before it showed. One that can't be
// read is named and passed over.
bool AnswerSeries(const OpenMap& map, const LocalizeFlags& flags) {
  if (!map.index->HasAppearance()) {
    throw MapError(ErrorCode::kUsage, "map '" + map.name +
                                          "' has no appearance layer, which --series requires; "
                                          "build it from panoramas or omit --series");
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

// Asks a server instead, which names what it can't do; photos that can't be read are passed over.
bool AnswerByServer(const LocalizeFlags& flags) {
  bool all_read = true;
  for (const std::string& photo : flags.photos) {
    try {
      const std::vector<uint8_t> bytes = ReadBytes(photo);
      const Json answer =
          AskServer(flags.server, flags.map, photo, std::string(bytes.begin(), bytes.end()),
                    RequestObject(RequestOf(flags)));
      PrintJson(answer, flags.json);
      all_read &= answer.value("verdict", "") != NameOf(Verdict::kBadImage);
    } catch (const MapError& error) {
      std::cerr << "waystone: " << error.what() << '\n';
      all_read = false;
    }
  }
  return all_read;
}

int RunLocalize(const LocalizeFlags& flags) {
  if (!flags.server.url.empty()) {
    if (flags.series) {
      throw MapError(ErrorCode::kUsage, "--series requires a map file; omit --series or --server");
    }
    return AnswerByServer(flags) ? 0 : InfoOf(ErrorCode::kBadImage).exit_code;
  }
  const OpenMap map = OpenMapFile(flags.map, false);
  if (flags.series) return AnswerSeries(map, flags) ? 0 : InfoOf(ErrorCode::kBadImage).exit_code;
  bool all_read = true;
  for (const std::string& photo : flags.photos) all_read &= AnswerOne(map, photo, flags);
  return all_read ? 0 : InfoOf(ErrorCode::kBadImage).exit_code;
}

}  // namespace

void AddLocalize(CLI::App& app, Run& run) {
  auto flags = std::make_shared<LocalizeFlags>();
  CLI::App* command = app.add_subcommand("localize", "Localize images with a map file or a server");
  command->add_option("map", flags->map, "Map file; with --server the name of a map, or - for all")
      ->required();
  command->add_option("photos", flags->photos, "Image files")->required();
  command->add_flag("--json", flags->json,
                    "Print one JSON object per image, as the server returns it");
  command->add_flag("--series", flags->series,
                    "The images are consecutive panoramas of one robot; each answer uses the "
                    "previous ones");
  command
      ->add_option("--fov-deg", flags->fov_deg,
                   "Horizontal field of view of the photos in degrees, used by maps of panoramas; "
                   "default: EXIF data")
      ->check(CLI::Range(1.0, 179.0))
      ->excludes("--series");
  AddServerFlags(command, flags->server);
  command->footer(
      "Exits with status 3 if any image can't be read, after processing the others.\n"
      "Example: waystone localize lab.db photo.jpg --json\n"
      "         waystone localize office.db 1.jpg 2.jpg 3.jpg --series\n"
      "         waystone localize office.db photo.jpg --fov-deg 63\n"
      "         waystone localize - photo.jpg --server http://127.0.0.1:8080");
  command->callback([flags, &run] { run = [flags] { return RunLocalize(*flags); }; });
}

}  // namespace waystone
