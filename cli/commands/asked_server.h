// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>
#include <string>

#include "api/json.h"

namespace waystone {

// Flags that make commands ask a server instead of a map file.
struct ServerFlags {
  std::string url;         // empty: none
  std::string token_file;  // its first token is sent; default: WAYSTONE_TOKEN
};
void AddServerFlags(CLI::App* command, ServerFlags& flags);

// Throws MapError: kUsage for anything but an HTTP address with a port up to 65535, and as
// ReadTokenFile does. To be called before photos are read.
void CheckServerFlags(const ServerFlags& flags);

// Asks a server where a photo was taken: in the map of that name, or in all maps for "-", with the
// fields of `request` (docs/http-api.md). The answer has what AnswerLine prints, and names the
// photo as `name`. Throws MapError for whatever keeps it from answering, with the server's own code
// where it gave one: kFileUnreadable for a server that can't be reached, doesn't answer in a
// minute, or doesn't answer as ours do.
Json AskServer(const ServerFlags& flags, const std::string& map, const std::string& name,
               const std::string& bytes, const Json& request = {});

}  // namespace waystone
