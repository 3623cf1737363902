// SPDX-License-Identifier: Apache-2.0
#include <iostream>
#include <memory>
#include <string>
#include <vector>

#include "cli/commands.h"
#include "cli/map_file.h"
#include "cli/signals.h"
#include "core/base/error.h"
#include "server/http/home_page.h"
#include "server/http/http_server.h"
#include "server/http/map_service.h"
#include "server/http/router.h"

namespace waystone {
namespace {

struct ServeFlags {
  std::vector<std::string> maps;
  HttpOptions http;
  ServiceOptions service;
};

MapService::Maps OpenMaps(const std::vector<std::string>& paths) {
  MapService::Maps maps;
  for (const std::string& path : paths) {
    OpenMap map = OpenMapFile(path, true);
    if (!maps.emplace(map.name, map.index).second) {
      throw MapError(ErrorCode::kUsage, "two of the files are called " + map.name +
                                            "; rename one, maps go by their file's name");
    }
  }
  return maps;
}

void Announce(const HttpServer& server, const MapService::Maps& maps) {
  std::cout << "Serving " << maps.size() << (maps.size() == 1 ? " map" : " maps") << " at "
            << server.url() << '\n';
  for (const auto& [name, index] : maps) {
    std::cout << "  curl --data-binary @photo.jpg -H 'Content-Type: image/jpeg' " << server.url()
              << "/v1/maps/" << EncodeSegment(name) << "/localize\n";
  }
  std::cout << std::flush;
}

int RunServe(const ServeFlags& flags) {
  flags.http.Check();  // before maps are read, which may take a while
  MapService::Maps maps = OpenMaps(flags.maps);
  BlockInterrupts();
  MapService service(maps, flags.service);
  Router router;
  service.AddTo(router);
  router.OnInternalError(
      [](const std::string& cause) { std::cerr << "waystone: internal error: " + cause + "\n"; });
  HttpServer server(flags.http, [&router](const HttpRequest& in) { return router.Dispatch(in); });
  server.Start();
  Announce(server, maps);
  WaitForInterrupt();
  server.Stop();
  return 0;
}

}  // namespace

void AddServe(CLI::App& app, Run& run) {
  auto flags = std::make_shared<ServeFlags>();
  CLI::App* command = app.add_subcommand("serve", "Answer photos over HTTP");
  command->add_option("maps", flags->maps, "Map files; each goes by its file's name")->required();
  command->add_option("--host", flags->http.host, "Address to listen on")->capture_default_str();
  command->add_option("--port", flags->http.port, "Port to listen on; 0 takes any free one")
      ->capture_default_str();
  command->add_flag("--insecure", flags->http.insecure,
                    "Let other machines ask, although nobody has to show who they are");
  command
      ->add_option("--threads", flags->service.query_threads,
                   "Queries computed at once; 0 takes all cores")
      ->capture_default_str();
  command
      ->add_option("--queue", flags->service.queue_length,
                   "Queries that may wait; more get status 429")
      ->capture_default_str();
  command->footer(
      "Ends on Ctrl-C or SIGTERM, after the answers at hand.\n"
      "Example: waystone serve lab.db --port 8080");
  command->callback([flags, &run] { run = [flags] { return RunServe(*flags); }; });
}

}  // namespace waystone
