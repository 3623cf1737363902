// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>
#include <string>

#include "api/json.h"

namespace waystone {

// How commands are told to ask a server instead of a map file.
struct ServerFlags {
  std::string url;         // empty: none
  std::string token_file;  // its first token; else the variable WAYSTONE_TOKEN
};
void AddServerFlags(CLI::App* command, ServerFlags& flags);

// Throws MapError: kUsage for what is no HTTP address, or has a port beyond 65535, and as
// ReadTokenFile does. For asking before photos are read.
void CheckServerFlags(const ServerFlags& flags);

// Asks a server where a photo was taken: of the map of that name, or of all for "-", with the
// fields of `request` (docs/http-api.md). Throws MapError for what keeps it from answering, by the
// server's own code where it gave one: kFileUnreadable for a server that can't be reached or
// doesn't answer as ours do.
Json AskServer(const ServerFlags& flags, const std::string& map, const std::string& name,
               const std::string& bytes, const Json& request = {});

}  // namespace waystone
