// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cerrno>
#include <cstring>
#include <exception>
#include <fstream>
#include <iostream>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "api/names_file.h"
#include "api/query_request_json.h"
#include "cli/commands/commands.h"
#include "cli/files/chosen_ids.h"
#include "cli/files/map_file.h"
#include "cli/files/output_file.h"
#include "core/base/error.h"
#include "core/base/text.h"
#include "schema/file/file_replacer.h"
#include "schema/file/map_lock.h"
#include "schema/file/map_store.h"

namespace waystone {
namespace {

struct NameFlags {
  std::string map;
  std::string name;
  std::vector<std::string> keyframes, nodes, planes, images, polygons;
  std::string sequence;
  std::string remove, names_in, names_out;
  bool fitting = false;
  bool force = false;
  bool json = false;
};

[[noreturn]] void RefuseUsage(const std::string& cause) {
  throw MapError(ErrorCode::kUsage, cause);
}

void AddIds(const MapData& map, NamedKind kind, const std::vector<std::string>& texts,
            NamedPlace& place) {
  for (const std::string& text : texts) {
    const std::vector<NamedRange> ranges = RangesOfIds(map, kind, text);
    place.ranges.insert(place.ranges.end(), ranges.begin(), ranges.end());
  }
}

// Tries each colon, since names of images may contain some.
void AddImages(const MapData& map, const std::string& text, const std::string& sequence,
               NamedPlace& place) {
  std::exception_ptr refusal;
  for (size_t colon = text.find(':'); colon != std::string::npos;
       colon = text.find(':', colon + 1)) {
    try {
      const NamedPlace found =
          PlaceOfImages(map, place.name, {sequence, text.substr(0, colon), text.substr(colon + 1)});
      place.ranges.insert(place.ranges.end(), found.ranges.begin(), found.ranges.end());
      return;
    } catch (const MapError& error) {
      if (!refusal || error.code() != ErrorCode::kNotFound) refusal = std::current_exception();
    }
  }
  if (refusal) std::rethrow_exception(refusal);
  AddImages(map, text + ":" + text, sequence, place);
}

NamedPlace PlaceIn(const NameFlags& flags, const MapData& map) {
  if (const auto problem = FindNameProblem(flags.name)) {
    RefuseUsage("the name " + QuoteShortened(flags.name) + " " + *problem);
  }
  NamedPlace place{flags.name, {}, {}};
  AddIds(map, NamedKind::kKeyframes, flags.keyframes, place);
  AddIds(map, NamedKind::kNodes, flags.nodes, place);
  AddIds(map, NamedKind::kPlanes, flags.planes, place);
  for (const std::string& text : flags.images) AddImages(map, text, flags.sequence, place);
  if (!flags.polygons.empty() && !map.poses && !map.appearance) {
    throw MapError(ErrorCode::kNoLayer,
                   flags.map +
                       " has no positions for a polygon; build it with --poses or from panoramas, "
                       "or name keyframes");
  }
  for (const std::string& text : flags.polygons) {
    place.polygons.push_back(ReadPolygon("--polygon", text));
  }
  if (place.ranges.empty() && place.polygons.empty()) {
    RefuseUsage(
        "specify what has this name: --keyframes, --nodes, --planes, --images or --polygon");
  }
  return place;
}

void RemovePlace(std::vector<NamedPlace>& places, const std::string& name) {
  const auto found = std::ranges::find(places, name, &NamedPlace::name);
  if (found == places.end()) {
    throw MapError(ErrorCode::kNotFound, "the map has no place named " + QuoteShortened(name) +
                                             "; `waystone name MAP` lists them");
  }
  places.erase(found);
}

std::string MisfitText(const NameMisfit& misfit) {
  return QuoteShortened(misfit.name) + ": " + misfit.cause;
}

// The file's places replace those of the same name.
void TakeNamesFile(const NameFlags& flags, MapData& map) {
  const std::vector<uint8_t> bytes = ReadBytes(flags.names_in, "a file written by --export");
  ReadNames read;
  try {
    read = ReadNamesFile({reinterpret_cast<const char*>(bytes.data()), bytes.size()}, map);
  } catch (const MapError& error) {
    throw MapError(error.code(), flags.names_in + ": " + error.what());
  }
  if (!read.misfits.empty() && !flags.fitting) {
    throw MapError(ErrorCode::kNotAvailable,
                   flags.names_in + ": " + std::to_string(read.misfits.size()) +
                       " parts of places are not in this map, the first " +
                       MisfitText(read.misfits.front()) +
                       "; nothing was changed; --fitting takes the others and lists these");
  }
  for (const NameMisfit& misfit : read.misfits) {
    std::cerr << "waystone: left out: " << Printable(MisfitText(misfit)) << '\n';
  }
  for (const NamedPlace& place : read.places)
    std::erase_if(map.names, [&](const NamedPlace& old) { return old.name == place.name; });
  map.names.insert(map.names.end(), read.places.begin(), read.places.end());
}

void WriteNamesFile(const NameFlags& flags, const MapData& map) {
  CheckIsNotInput(flags.names_out, flags.map, "the map whose names are exported");
  CheckReplacesNoMap(flags.names_out);
  FileReplacer file(flags.names_out, flags.force);
  std::ofstream out(file.temporary(), std::ios::binary);
  const Json json = NamesFileJson(MapNameOf(flags.map), map);
  if (!(out << json.dump(2, ' ', false, Json::error_handler_t::replace) << '\n').flush()) {
    throw UnwritableError(flags.names_out, std::strerror(errno), 0);
  }
  file.Commit();
}

// "keyframes 120:180,200, a polygon of 4 corners".
std::string HeldText(const NamedPlace& place) {
  std::string text;
  const NamedRange* before = nullptr;
  for (const NamedRange& range : place.ranges) {
    const bool same = before && before->kind == range.kind;
    if (same) {
      text += ",";
    } else {
      text += (text.empty() ? "" : ", ") + std::string(NameOf(range.kind)) + " ";
    }
    text += std::to_string(range.first);
    if (range.last > range.first) text += ":" + std::to_string(range.last);
    before = &range;
  }
  for (const NamedPolygon& polygon : place.polygons) {
    text += (text.empty() ? "" : ", ") + std::string("a polygon of ") +
            std::to_string(polygon.size()) + " corners";
  }
  return text;
}

void PrintNames(const NameFlags& flags, const MapData& map) {
  if (flags.json) {
    std::cout << Dump({{"map", MapNameOf(flags.map)}, {"places", NamedPlacesJson(map.names)}})
              << '\n';
    return;
  }
  std::cout << flags.map << ": " << map.names.size()
            << (map.names.size() == 1 ? " named place\n" : " named places\n");
  for (const NamedPlace& place : map.names) {
    std::cout << "  " << Printable(place.name) << ": " << HeldText(place) << '\n';
  }
}

void CheckNameFlags(const NameFlags& flags) {
  const int actions = static_cast<int>(!flags.name.empty()) + (flags.remove.empty() ? 0 : 1) +
                      (flags.names_in.empty() ? 0 : 1) + (flags.names_out.empty() ? 0 : 1);
  if (actions > 1) RefuseUsage("specify one of NAME, --remove, --from and --export");
  const bool holds = !flags.keyframes.empty() || !flags.nodes.empty() || !flags.planes.empty() ||
                     !flags.images.empty() || !flags.polygons.empty();
  if (holds && flags.name.empty()) RefuseUsage("specify the name of the place");
}

int RunName(const NameFlags& flags) {
  CheckNameFlags(flags);
  const bool changes = !flags.name.empty() || !flags.remove.empty() || !flags.names_in.empty();
  std::optional<MapLock> lock;
  if (changes) lock.emplace(flags.map);
  MapData map = ReadMap(flags.map, {.images = changes});
  if (!flags.names_out.empty()) {
    WriteNamesFile(flags, map);
    return 0;
  }
  const std::vector<NamedPlace> before = map.names;
  if (!flags.name.empty()) map.names.push_back(PlaceIn(flags, map));
  if (!flags.remove.empty()) RemovePlace(map.names, flags.remove);
  if (!flags.names_in.empty()) TakeNamesFile(flags, map);
  map.names = Canonical(std::move(map.names));
  if (const auto problem = FindBoundProblem(map.names)) {
    RefuseUsage("too many names: " + *problem);
  }
  if (map.names != before) RewriteOptionalTables(map, flags.map);
  PrintNames(flags, map);
  return 0;
}

}  // namespace

void AddName(CLI::App& app, Run& run) {
  auto flags = std::make_shared<NameFlags>();
  CLI::App* command = app.add_subcommand("name", "Name places of a map, and list their names");
  command->add_option("map", flags->map, "Map file")->required();
  command->add_option("name", flags->name, "Name of the place; without one, the names are listed");
  const auto add = [&](const char* flag, std::vector<std::string>& values, const char* help) {
    command->add_option(flag, values, help)->allow_extra_args(false);
  };
  add("--keyframes", flags->keyframes, "Ids of keyframes: 12, 120:180 or 3,5,9:12");
  add("--nodes", flags->nodes, "Ids of panoramas (nodes of the appearance layer)");
  add("--planes", flags->planes, "Ids of planes: what an answer recognizes first");
  add("--images", flags->images, "FIRST:LAST, images of a sequence by name, or by number of frame");
  command->add_option("--sequence", flags->sequence, "Name of the sequence of --images")
      ->needs("--images");
  add("--polygon", flags->polygons,
      "Area from above, \"x,y x,y x,y ...\", in the frame of the map's poses");
  command->add_option("--remove", flags->remove, "Remove the place of this name");
  command->add_option("--export", flags->names_out, "Write the names to this file");
  command->add_option("--from", flags->names_in, "Take the names of a file of --export");
  command->add_flag("--fitting", flags->fitting, "--from: take what the map has, and list the rest")
      ->needs("--from");
  command->add_flag("--force", flags->force, "--export: overwrite an existing file")
      ->needs("--export");
  command->add_flag("--json", flags->json, "Print one JSON object");
  command->footer(
      "A name that is there already gets what is specified in addition. The map file is written\n"
      "anew beside the old one and renamed.\n"
      "Example: waystone name lab.db --keyframes 120:180 \"Kitchen, window side\"\n"
      "         waystone name lab.db --export names.json\n"
      "         waystone name rebuilt.db --from names.json");
  command->callback([flags, &run] { run = [flags] { return RunName(*flags); }; });
}

}  // namespace waystone
