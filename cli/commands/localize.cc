// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <iostream>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "api/answer_json.h"
#include "api/query_request_json.h"
#include "api/request_answer_json.h"
#include "cli/commands/asked_server.h"
#include "cli/commands/commands.h"
#include "cli/commands/settings.h"
#include "cli/files/finite.h"
#include "cli/files/map_file.h"
#include "cli/output/answer_text.h"
#include "core/base/error.h"
#include "core/base/text.h"
#include "core/geometry/angle.h"
#include "core/image/decode.h"
#include "localizer/session.h"

namespace waystone {
namespace {

struct LocalizeFlags {
  std::string map;
  std::vector<std::string> photos;
  bool json = false;
  bool series = false;
  std::optional<double> fov_deg;
  std::vector<std::string> settings;  // of --set
  ServerFlags server;
  // Hints of a query of all maps.
  std::vector<std::string> tags;
  std::vector<std::string> near;  // frame, x, y, perhaps z, radius
  std::string previous_map;
  std::optional<MapHints> hints;  // what these say

  bool HasHints() const { return !tags.empty() || !near.empty() || !previous_map.empty(); }
};

double NumberOf(const std::string& text) {
  const std::optional<double> number = ToNumber(text);
  if (number && std::isfinite(*number)) return *number;
  throw MapError(ErrorCode::kUsage, "--near: " + QuoteShortened(text) +
                                        " is not a finite number; give FRAME X Y RADIUS or "
                                        "FRAME X Y Z RADIUS");
}

MapHints MakeHints(const LocalizeFlags& flags) {
  MapHints hints;
  hints.tags = flags.tags;
  if (!flags.previous_map.empty()) hints.previous_map = flags.previous_map;
  if (flags.near.empty()) return hints;
  PositionHint& position = hints.position.emplace();
  position.frame = flags.near.front();
  for (size_t i = 1; i < flags.near.size(); ++i) position.at.push_back(NumberOf(flags.near[i]));
  position.radius = position.at.back();
  position.at.pop_back();
  return hints;
}

LocalizeOptions MakeLocalizeOptions(const LocalizeFlags& flags) {
  LocalizeOptions options;
  ApplySettings(flags.settings, options);
  options.Check();
  return options;
}

// What the flags say about a photo, for a map file and for a server alike.
QueryRequest MakeRequest(const LocalizeFlags& flags, const std::string& photo) {
  const std::vector<uint8_t> bytes = ReadBytes(photo);
  QueryRequest request;
  request.images.push_back({photo, std::string(bytes.begin(), bytes.end())});
  if (flags.fov_deg) request.fov_rad = kDegree * *flags.fov_deg;
  request.hints = flags.hints;
  return request;
}

void Print(const Json& answer, bool json) {
  std::cout << (json ? Dump(answer) : AnswerLine(answer)) << std::endl;
}

// Asks about each photo; `ask` gives its answer as JSON. A photo that can't be read, or that a
// server refuses, is named and skipped. Returns the exit status, of the first of these.
template <class AskPhoto>
int AnswerEach(const LocalizeFlags& flags, const AskPhoto& ask) {
  int status = 0;
  const auto pass_over = [&status](ErrorCode code) {
    if (status == 0) status = InfoOf(code).exit_code;
  };
  for (const std::string& photo : flags.photos) {
    try {
      const Json answer = ask(photo);
      Print(answer, flags.json);
      if (answer.value("verdict", "") == NameOf(Verdict::kBadImage))
        pass_over(ErrorCode::kBadImage);
    } catch (const MapError& error) {
      if (error.code() != ErrorCode::kFileUnreadable && flags.server.url.empty()) throw;
      std::cerr << "waystone: " << Printable(error.what()) << '\n';
      pass_over(error.code());
    }
  }
  return status;
}

int AnswerByMap(const QueriedMap& map, const LocalizeFlags& flags) {
  const LocalizeOptions options = MakeLocalizeOptions(flags);
  return AnswerEach(flags, [&](const std::string& photo) {
    const Session session(MakeRequest(flags, photo), {map}, options);
    return ToJson(session, session.Ask(), false);
  });
}

// One panorama after the other, each asked with what the previous ones showed.
int AnswerSeries(const QueriedMap& map, const LocalizeFlags& flags) {
  if (!map.index->HasAppearance()) {
    throw MapError(ErrorCode::kUsage, "map '" + map.name +
                                          "' has no appearance layer, which --series requires; "
                                          "build it from panoramas or omit --series");
  }
  Series series(map, MakeLocalizeOptions(flags));
  return AnswerEach(flags, [&](const std::string& photo) {
    return ToJson(series.Ask(MakeRequest(flags, photo).images.front()));
  });
}

// Asks a server instead, which itself reports what it can't do.
int AnswerByServer(const LocalizeFlags& flags) {
  return AnswerEach(flags, [&](const std::string& photo) {
    const QueryRequest request = MakeRequest(flags, photo);
    return AskServer(flags.server, flags.map, photo, request.images.front().bytes, ToJson(request));
  });
}

int RunLocalize(LocalizeFlags flags) {
  const bool by_server = !flags.server.url.empty();
  if (by_server && flags.series) {
    throw MapError(ErrorCode::kUsage, "--series requires a map file; omit --series or --server");
  }
  if (by_server && !flags.settings.empty()) {
    throw MapError(ErrorCode::kUsage,
                   "--set requires a map file; a server has the options it was started with");
  }
  if (flags.HasHints() && !(by_server && flags.map == "-")) {
    throw MapError(ErrorCode::kUsage,
                   "--tag, --near and --previous-map narrow a query of all maps of a server; give "
                   "- as the map and --server");
  }
  if (flags.HasHints()) flags.hints = MakeHints(flags);
  if (by_server) {
    CheckServerFlags(flags.server);
    return AnswerByServer(flags);
  }
  const OpenMap opened = OpenMapFile(flags.map, false);
  const QueriedMap map{opened.name, opened.index};
  return flags.series ? AnswerSeries(map, flags) : AnswerByMap(map, flags);
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
      ->check(Finite())
      ->check(CLI::Range(1.0, 179.0))
      ->excludes("--series");
  AddSetFlag(*command, flags->settings);
  AddServerFlags(command, flags->server);
  command
      ->add_option("--tag", flags->tags,
                   "With - as the map: query only maps published with this tag; repeatable")
      ->allow_extra_args(false);
  command
      ->add_option(
          "--near", flags->near,
          "With - as the map: query only maps within RADIUS of a point in a frame of poses: "
          "FRAME X Y RADIUS, or FRAME X Y Z RADIUS")
      ->expected(4, 5);
  command->add_option("--previous-map", flags->previous_map,
                      "With - as the map: a map that is always queried");
  command->footer(
      "Exits with status 3 if any image can't be read or a server refuses it, 6 if the server's\n"
      "registry or store can't be reached, after processing the others.\n"
      "Example: waystone localize lab.db photo.jpg --json\n"
      "         waystone localize office.db 1.jpg 2.jpg 3.jpg --series\n"
      "         waystone localize office.db photo.jpg --fov-deg 63\n"
      "         waystone localize - photo.jpg --server http://127.0.0.1:8080");
  command->callback([flags, &run] { run = [flags] { return RunLocalize(*flags); }; });
}

}  // namespace waystone
