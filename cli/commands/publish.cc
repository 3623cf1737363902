// SPDX-License-Identifier: Apache-2.0
#include <filesystem>
#include <iostream>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "api/json.h"
#include "cli/commands/commands.h"
#include "cli/files/map_file.h"
#include "core/base/error.h"
#include "registry/coarse_file.h"
#include "registry/registry.h"
#include "registry/store.h"

namespace waystone {
namespace {

struct PublishFlags {
  std::string map;
  std::string registry;
  std::string name;
  std::string store;
  std::vector<std::string> tags;
  bool json = false;
};

// The absolute path of a folder, because other programs read it in the registry.
std::string Absolute(const std::string& store) {
  const bool folder = !store.empty() && store.find("://") == std::string::npos;
  return folder ? std::filesystem::absolute(store).lexically_normal().string() : store;
}

int RunPublish(const PublishFlags& flags) {
  const OpenMap map = OpenMapFile(flags.map, true);  // refuses a damaged one
  const auto bytes = static_cast<int64_t>(std::filesystem::file_size(flags.map));
  MapVersion version =
      MakeVersion(flags.name.empty() ? map.name : flags.name, *map.index, bytes, flags.tags);
  const std::string given = Absolute(flags.store);
  const std::unique_ptr<Registry> registry = OpenRegistry(flags.registry, NewRegistry{given});
  const std::unique_ptr<Store> store = OpenStore(given.empty() ? registry->store() : given);
  store->Put(flags.map, version.sha256, version.bytes);
  const std::optional<CoarseFile> coarse = PutCoarseEntry(*store, *map.index);
  if (coarse) version = MakeVersion(version.name, *map.index, bytes, flags.tags, coarse);
  if (!coarse) {
    std::cerr << "The map's places have no features for the coarse index: queries of all maps of a "
                 "large registry won't find it\n";
  }
  const MapVersion published = registry->Publish(version);
  if (flags.json) {
    std::cout << ManifestOf(published) << '\n';
  } else {
    std::cout << "Published " << Describe(published) << " (" << published.sha256 << ")\n";
  }
  return 0;
}

}  // namespace

void AddPublish(CLI::App& app, Run& run) {
  auto flags = std::make_shared<PublishFlags>();
  CLI::App* command = app.add_subcommand("publish", "Publish a map in a registry");
  command->add_option("map", flags->map, "Map file")->required();
  command
      ->add_option("--to", flags->registry,
                   "Registry: a folder, or postgresql://...; created if missing")
      ->required();
  command->add_option("--name", flags->name, "Name of the map; default: the file's");
  command->add_option("--tag", flags->tags, "Tag of this version, shown in lists; repeatable")
      ->allow_extra_args(false);
  command->add_option("--store", flags->store,
                      "Folder, or address (http, https) that takes GET, HEAD and PUT, of the map "
                      "files. A new registry keeps it; default: the registry's own folder");
  command->add_flag("--json", flags->json, "Print the version's manifest as one JSON object");
  command->footer(
      "Servers of the registry (waystone serve --registry) switch to the new version\n"
      "within seconds. Versions never change; publishing the current one again does nothing.\n"
      "Example: waystone publish lab.db --to /srv/maps --tag berlin");
  command->callback([flags, &run] { run = [flags] { return RunPublish(*flags); }; });
}

}  // namespace waystone
