// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <chrono>
#include <functional>
#include <iostream>
#include <memory>
#include <new>
#include <string>
#include <thread>
#include <vector>

#include "cli/commands/commands.h"
#include "cli/commands/served_files.h"
#include "cli/commands/settings.h"
#include "cli/files/finite.h"
#include "cli/system/signals.h"
#include "core/base/error.h"
#include "core/base/text.h"
#include "core/image/decode.h"
#include "server/http/http_server.h"
#include "server/service/application.h"
#include "server/service/map_catalog.h"
#include "server/service/registry_maps.h"

namespace waystone {
namespace {

constexpr int64_t kBytesPerMegabyte = 1'000'000;

struct ServeFlags {
  std::vector<std::string> maps;
  HttpOptions http;
  ServiceOptions service;
  std::vector<std::string> public_names;
  std::string token_file;
  std::vector<std::string> settings;  // of --set
  int64_t max_body_mb = 20;
  int64_t query_log_mb = 2000;
  bool log = false;
  double drain_s = 0.5;  // between /readyz saying so and the end
  double watch_s = 1;    // between looks at the files; 0 looks only at SIGHUP
  RegistryMapsOptions registry;
};

void WriteLine(const std::string& line) { std::cerr << line + "\n" << std::flush; }

void WriteError(const std::string& cause) { WriteLine("waystone: " + Printable(cause)); }

void Announce(const HttpServer& server, const std::vector<std::string>& names, bool tokens) {
  constexpr size_t kShown = 100;
  std::cout << "Serving " << names.size() << (names.size() == 1 ? " map" : " maps") << " at "
            << server.url() << '\n';
  for (size_t i = 0; i < std::min(names.size(), kShown); ++i) {
    std::cout << "  curl --data-binary @photo.jpg -H 'Content-Type: image/jpeg' "
              << (tokens ? "-H \"Authorization: Bearer $TOKEN\" " : "") << server.url()
              << "/v1/maps/" << EncodeSegment(names[i]) << "/localize\n";
  }
  if (names.size() > kShown) std::cout << "  and so on\n";
  std::cout << std::flush;
}

void Report(const ServedFiles::Change& change) {
  WriteError((change.name.empty() ? "" : "map " + change.name + ": ") + change.message);
}

void Refresh(ServedFiles& files, MapCatalog& catalog, Application& application, bool all) {
  try {
    for (const ServedFiles::Change& change : files.Refresh(catalog, all)) {
      application.metrics().CountReload(change.good);
      Report(change);
    }
  } catch (const std::bad_alloc&) {  // not even for saying what became of each map
    std::cerr << "waystone: maps not reloaded, out of memory; trying again\n";
  }
}

// Looks after the maps until the program is told to end: calls `refresh` when a signal says so
// (true) and every `watch_s` seconds (false), unless these are 0.
void Watch(double watch_s, const std::function<void(bool)>& refresh) {
  constexpr double kNoWatchS = 3600;  // how long one sleep is when only signals count
  while (true) {
    switch (WaitForSignal(watch_s > 0 ? watch_s : kNoWatchS)) {
      case Awaited::kEnd:
        return;
      case Awaited::kReload:
        refresh(true);
        break;
      case Awaited::kNothing:
        if (watch_s > 0) refresh(false);
        break;
    }
  }
}

void Complete(ServeFlags& flags) {
  flags.http.max_body_bytes = flags.max_body_mb * kBytesPerMegabyte;
  flags.service.query_log_bytes = flags.query_log_mb * kBytesPerMegabyte;
  if (!flags.token_file.empty()) flags.service.tokens = Tokens::FromFile(flags.token_file);
  flags.http.has_tokens = !flags.service.tokens.empty();
  flags.service.names = ServerNames(flags.http.host, flags.public_names);
  // Queries that compute or wait must leave threads for other requests.
  constexpr int kOtherRequests = 16;
  ApplySettings(flags.settings, flags.service.localize);
  flags.service.Check();
  flags.http.request_threads =
      std::max(CountQueryThreads(flags.service) + flags.service.queue_length + kOtherRequests,
               flags.http.request_threads);
  flags.http.Check();  // before maps are read, which may take a while
}

// Serves until the program is told to end. `watch` gets the application.
int ServeMaps(const ServeFlags& flags, const std::shared_ptr<MapSource>& maps,
              const std::function<void(Application&)>& watch) {
  Application application(maps, flags.service, {flags.log ? WriteLine : nullptr, WriteError});
  HttpServer server(
      flags.http, [&application](const HttpRequest& in) { return application.Answer(in); },
      [&application](const std::string& authorization) {
        return application.Admit(authorization);
      });
  server.Start();
  Announce(server, maps->Names(), flags.http.has_tokens);
  watch(application);
  application.BeginStop();
  server.Drain();
  std::this_thread::sleep_for(std::chrono::duration<double>(flags.drain_s));
  server.Stop([&application] { application.EndQueue(); });
  return 0;
}

int ServeFiles(const ServeFlags& flags) {
  ServedFiles files({flags.maps.begin(), flags.maps.end()});
  const ServedFiles::Opened opened = files.OpenAll();
  for (const ServedFiles::Change& refused : opened.refused) Report(refused);
  const auto catalog = std::make_shared<MapCatalog>(opened.maps);
  return ServeMaps(flags, catalog, [&](Application& application) {
    Watch(flags.watch_s, [&](bool all) { Refresh(files, *catalog, application, all); });
  });
}

int ServeRegistry(ServeFlags flags) {
  if (flags.registry.cache.empty()) {
    throw MapError(ErrorCode::kUsage,
                   "--registry needs --cache DIR, a folder of this server's own for map files");
  }
  // Requests that wait for maps must leave threads for others.
  flags.http.request_threads += RegistryMaps::kMaxWaiting;
  constexpr double kNoPollS = 3600;  // only at SIGHUP, and when the registry says so
  flags.registry.poll_s = flags.watch_s > 0 ? flags.watch_s : kNoPollS;
  const auto maps = std::make_shared<RegistryMaps>(flags.registry, WriteError);
  flags.service.registry = flags.registry.registry;
  return ServeMaps(flags, maps, [&](Application&) { Watch(0, [&](bool) { maps->Refresh(); }); });
}

int RunServe(ServeFlags flags) {
  BlockSignals();  // before there are threads: one that was made earlier would take them
  if (flags.maps.empty() == flags.registry.registry.empty()) {
    throw MapError(ErrorCode::kUsage, "give either maps or --registry; see waystone serve --help");
  }
  Complete(flags);
  PrepareDecoders();
  return flags.registry.registry.empty() ? ServeFiles(flags) : ServeRegistry(flags);
}

void AddRegistryFlags(CLI::App* command, RegistryMapsOptions& registry) {
  CLI::Option* given = command->add_option(
      "--registry", registry.registry,
      "Serve the maps of this registry (a folder or postgresql://...) instead of files: fetched "
      "and opened when they are asked for");
  command
      ->add_option("--cache", registry.cache,
                   "Folder for the map files of the registry, of this server alone")
      ->needs(given);
  command
      ->add_option("--cache-size", registry.cache_bytes,
                   "Maximum size of the cache, such as 50G; the least recently used files go")
      ->transform(CLI::AsSizeValue(true))
      ->capture_default_str()
      ->needs(given);
  command
      ->add_option("--memory", registry.memory_bytes,
                   "Maximum memory of the registry's open maps, such as 8G; the least recently "
                   "used ones are closed. A map counts as twice its file, with an appearance layer "
                   "three times")
      ->transform(CLI::AsSizeValue(true))
      ->capture_default_str()
      ->needs(given);
  command
      ->add_option("--store", registry.store,
                   "Folder or address of the map files, where it isn't the one that the registry "
                   "names")
      ->needs(given);
}

void AddServiceFlags(CLI::App* command, ServeFlags& flags) {
  command
      ->add_option("--threads", flags.service.query_threads,
                   "Number of queries processed concurrently, 0 for one per core")
      ->capture_default_str();
  command
      ->add_option("--queue", flags.service.queue_length,
                   "Maximum queries in the queue; further ones get status 429")
      ->capture_default_str();
  command->add_option("--max-body", flags.max_body_mb, "Maximum size of a request body in MB")
      ->capture_default_str()
      ->check(CLI::Range(1, 400));
  command->add_option("--max-images", flags.service.limits.max_images, "Maximum images per request")
      ->capture_default_str();
  command
      ->add_option("--max-pixels", flags.service.localize.limits.max_pixels,
                   "Maximum pixels of an image")
      ->capture_default_str();
  command
      ->add_option("--connections", flags.http.max_connections,
                   "Maximum concurrent connections; idle and slow ones make room for new ones")
      ->capture_default_str();
  command
      ->add_option("--drain", flags.drain_s,
                   "Seconds between the end of readiness (/readyz) and the end of the server")
      ->capture_default_str()
      ->check(Finite())
      ->check(CLI::Range(0.0, 600.0));
  command
      ->add_option("--watch", flags.watch_s,
                   "Seconds between checks for changed map files, or of the registry; 0: only on "
                   "SIGHUP")
      ->capture_default_str()
      ->check(Finite())
      ->check(CLI::Range(0.0, 3600.0));
  AddSetFlag(*command, flags.settings);
  command->add_flag("--log", flags.log, "Log each request to stderr as a line of JSON");
  command->add_option("--query-log", flags.service.query_log,
                      "Store queries with their images in this folder, for waystone replay");
  command->add_option("--query-log-max", flags.query_log_mb, "Maximum size of the query log in MB")
      ->capture_default_str()
      ->check(CLI::Range(1, 1'000'000));
}

}  // namespace

void AddServe(CLI::App& app, Run& run) {
  auto flags = std::make_shared<ServeFlags>();
  CLI::App* command = app.add_subcommand("serve", "Serve maps over HTTP");
  command->add_option("maps", flags->maps,
                      "Map files, or folders of *.db files; a map is named after its file");
  command
      ->add_option("--host", flags->http.host,
                   "Address to listen on; requests to 0.0.0.0 may use any IP address, but names "
                   "only with --public-name")
      ->capture_default_str();
  command->add_option("--port", flags->http.port, "Port to listen on; 0 chooses a free port")
      ->capture_default_str();
  command
      ->add_option("--public-name", flags->public_names,
                   "Another name of the server, NAME or NAME:PORT, once for each: behind a proxy, "
                   "a port mapping or DNS. Requests for other host names get status 421, requests "
                   "by web pages of other sites 403")
      ->allow_extra_args(false);
  command->add_option("--token-file", flags->token_file,
                      "File of accepted bearer tokens, one per line");
  command->add_flag("--insecure", flags->http.insecure,
                    "Accept requests from other machines without authentication");
  AddRegistryFlags(command, flags->registry);
  AddServiceFlags(command, *flags);
  command->footer(
      "Stops on Ctrl-C or SIGTERM after finishing the requests in progress. Reloads maps on "
      "SIGHUP\n"
      "and when their files change; requests in progress finish on the version they started with.\n"
      "Example: waystone serve lab.db --port 8080\n"
      "Example: waystone serve --registry /srv/maps --cache /var/cache/maps --memory 8G");
  command->callback([flags, &run] { run = [flags] { return RunServe(*flags); }; });
}

}  // namespace waystone
