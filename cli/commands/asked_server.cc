// SPDX-License-Identifier: Apache-2.0
#include "cli/commands/asked_server.h"

#include <cstdlib>

#include "api/token_file.h"
#include "clients/cpp/waystone_client.h"
#include "core/base/error.h"

namespace waystone {
namespace {

std::string TokenOf(const ServerFlags& flags) {
  if (flags.token_file.empty()) {
    const char* token = std::getenv("WAYSTONE_TOKEN");
    return token ? token : "";
  }
  return ReadTokenFile(flags.token_file).front();
}

// The server's own code; a server that can't be reached, or isn't ours, is a file that can't be
// read.
ErrorCode CodeOf(const ClientError& error) {
  for (int i = 0; i <= static_cast<int>(ErrorCode::kInternal); ++i) {
    const auto code = static_cast<ErrorCode>(i);
    if (InfoOf(code).name == error.code()) return code;
  }
  return ErrorCode::kFileUnreadable;
}

// Throws unless the answer has what a line of it is made of.
void CheckAnswer(const Json& answer) {
  const auto at = [&answer](const char* path) {
    const Json::json_pointer pointer(path);
    return answer.contains(pointer) ? answer.at(pointer) : Json();
  };
  const bool has_place = answer.contains("place") && at("/planes").is_array();
  const bool whole = at("/image").is_string() && at("/verdict").is_string() &&
                     at("/timing_ms/total").is_number() &&
                     (has_place || at("/verdict") != "localized");
  if (whole) return;
  throw ClientError("bad_answer", 200, "the response is no answer of Waystone; check the address");
}

}  // namespace

void AddServerFlags(CLI::App* command, ServerFlags& flags) {
  command->add_option(
      "--server", flags.url,
      "Query this server (http://HOST:PORT) instead of a file; MAP is then the name of a map, "
      "or - for all maps");
  command
      ->add_option("--token-file", flags.token_file,
                   "File with the server's token; default: environment variable WAYSTONE_TOKEN")
      ->needs("--server");
}

void CheckServerFlags(const ServerFlags& flags) {
  try {
    const Client checked(flags.url);
  } catch (const ClientError&) {
    throw MapError(ErrorCode::kUsage, "--server " + flags.url +
                                          " is no address of a server; give http://HOST:PORT with "
                                          "a port from 1 to 65535");
  }
  TokenOf(flags);
}

Json AskServer(const ServerFlags& flags, const std::string& map, const std::string& name,
               const std::string& bytes, const Json& request) {
  try {
    const Client client(flags.url, {.token = TokenOf(flags)});
    Json answer = client.Localize(Photo{name, bytes}, map == "-" ? "" : map, request);
    CheckAnswer(answer);
    answer["image"] = name;  // forms and servers keep neither all characters nor any length
    return answer;
  } catch (const ClientError& error) {
    throw MapError(CodeOf(error), flags.url + ": " + error.what());
  }
}

}  // namespace waystone
