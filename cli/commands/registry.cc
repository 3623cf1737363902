// SPDX-License-Identifier: Apache-2.0
// What is done with the maps of a registry once they are published.
#include <algorithm>
#include <iomanip>
#include <iostream>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "api/json.h"
#include "cli/commands/commands.h"
#include "core/base/error.h"
#include "registry/registry.h"

namespace waystone {
namespace {

struct MapsFlags {
  std::string registry;
  std::string name;
  std::string tag;
  bool json = false;
};

struct MoveFlags {
  std::string name;
  std::string registry;
  int version = 0;  // 0: not given
};

constexpr double kBytesPerMb = 1e6;

Json StateJson(const MapState& state, bool current) {
  Json json = Json::parse(ManifestOf(state.version));
  json["current"] = current;
  json["retired"] = state.retired;
  return json;
}

std::string Joined(const Json& list) {
  std::string text;
  for (const Json& item : list) text += (text.empty() ? "" : ", ") + item.get<std::string>();
  return text;
}

void PrintState(const MapState& state, bool current) {
  const MapVersion& version = state.version;
  const Json details = Json::parse(version.details);
  const std::string tags = Joined(details.value("tags", Json::array()));
  std::cout << version.name << "  version " << version.number
            << (state.retired ? "  retired" : (current ? "" : "  not current")) << "  "
            << std::fixed << std::setprecision(1)
            << static_cast<double>(version.bytes) / kBytesPerMb << " MB  "
            << Joined(details.value("layers", Json::array())) << "  "
            << details.value("published_at", "") << " by " << details.value("publisher", "")
            << (tags.empty() ? "" : "  tags: " + tags) << '\n';
}

bool HasTag(const MapVersion& version, const std::string& tag) {
  const Json tags = Json::parse(version.details).value("tags", Json::array());
  return std::ranges::count(tags, Json(tag)) > 0;
}

void Print(const MapState& state, bool current, bool json) {
  if (json) {
    std::cout << Dump(StateJson(state, current)) << '\n';
  } else {
    PrintState(state, current);
  }
}

// The state of one name.
std::optional<MapState> FindState(const RegistryNews& news, const std::string& name) {
  for (const MapState& state : news.changed) {
    if (state.version.name == name) return state;
  }
  return std::nullopt;
}

int RunMaps(const MapsFlags& flags) {
  const std::unique_ptr<Registry> registry = OpenRegistry(flags.registry);
  RegistryNews news = registry->Refresh();
  if (!flags.name.empty()) {
    const std::vector<MapVersion> versions = registry->Versions(flags.name);
    const std::optional<MapState> state = FindState(news, flags.name);
    for (const MapVersion& version : versions) {
      const bool current = state && version.number == state->version.number;
      Print({version, current && state->retired}, current && !state->retired, flags.json);
    }
    return 0;
  }
  std::ranges::sort(news.changed, {}, [](const MapState& state) { return state.version.name; });
  for (const MapState& state : news.changed) {
    if (flags.tag.empty() || HasTag(state.version, flags.tag)) {
      Print(state, !state.retired, flags.json);
    }
  }
  for (const RegistryNews::Problem& problem : news.problems) {
    std::cerr << "waystone: map " << problem.name << ": " << problem.message << '\n';
  }
  return news.problems.empty() ? 0 : InfoOf(ErrorCode::kFileUnreadable).exit_code;
}

int RunRollback(const MoveFlags& flags) {
  const std::optional<int> version =
      flags.version > 0 ? std::optional(flags.version) : std::nullopt;
  const MapVersion current = OpenRegistry(flags.registry)->Rollback(flags.name, version);
  std::cout << "Current: " << Describe(current) << " (" << current.sha256 << ")\n";
  return 0;
}

int RunRetire(const MoveFlags& flags) {
  OpenRegistry(flags.registry)->Retire(flags.name);
  std::cout << "Retired " << flags.name << '\n';
  return 0;
}

}  // namespace

void AddMaps(CLI::App& app, Run& run) {
  auto flags = std::make_shared<MapsFlags>();
  CLI::App* command = app.add_subcommand("maps", "List the maps of a registry");
  command->add_option("registry", flags->registry, "Registry: a folder or postgresql://...")
      ->required();
  CLI::Option* name =
      command->add_option("--name", flags->name, "List all versions of this map instead");
  command->add_option("--tag", flags->tag, "List only maps with this tag")->excludes(name);
  command->add_flag("--json", flags->json, "Print each manifest as one JSON object per line");
  command->footer("Example: waystone maps /srv/maps");
  command->callback([flags, &run] { run = [flags] { return RunMaps(*flags); }; });
}

void AddRollback(CLI::App& app, Run& run) {
  auto flags = std::make_shared<MoveFlags>();
  CLI::App* command =
      app.add_subcommand("rollback", "Make an earlier version of a map the current one");
  command->add_option("name", flags->name, "Name of the map")->required();
  command->add_option("--in", flags->registry, "Registry: a folder or postgresql://...")
      ->required();
  command
      ->add_option("--version", flags->version,
                   "Number of the version, as waystone maps --name lists them; default: the one "
                   "before the current one, or the last one of a retired map")
      ->check(CLI::PositiveNumber);
  command->footer("Example: waystone rollback lab --in /srv/maps");
  command->callback([flags, &run] { run = [flags] { return RunRollback(*flags); }; });
}

void AddRetire(CLI::App& app, Run& run) {
  auto flags = std::make_shared<MoveFlags>();
  CLI::App* command = app.add_subcommand("retire", "Stop serving a map; its versions stay");
  command->add_option("name", flags->name, "Name of the map")->required();
  command->add_option("--in", flags->registry, "Registry: a folder or postgresql://...")
      ->required();
  command->footer("Example: waystone retire lab --in /srv/maps");
  command->callback([flags, &run] { run = [flags] { return RunRetire(*flags); }; });
}

}  // namespace waystone
