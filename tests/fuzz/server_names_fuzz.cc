// SPDX-License-Identifier: Apache-2.0
#include "server/http/server_names.h"
#include "tests/fuzz/fuzz_targets.h"

namespace waystone {
namespace {

std::string WriteAuthority(const Authority& name) {
  const bool v6 = name.host.find(':') != std::string::npos;
  return (v6 ? "[" + name.host + "]" : name.host) +
         (name.port ? ":" + std::to_string(*name.port) : "");
}

}  // namespace

// The input is the header Host and, on the second line, Origin. A name is written and read to the
// same; a server of this machine alone answers to nothing but names of this machine.
bool FuzzServerNames(FuzzInput input) {
  const auto [host, rest] = SplitLine(input);
  const std::string host_header(host);
  const std::string origin(TextOf(rest));
  const auto name = ParseAuthority(host_header);
  if (name) {
    Require(ParseAuthority(WriteAuthority(*name)) == name,
            "a name is written and read to the same");
  }
  HttpRequest request;
  request.method = "POST";
  request.port = 8080;
  request.header = [&](const std::string& header) -> std::optional<std::string> {
    if (header == "Host") return host_header;
    if (header == "Origin" && !origin.empty()) return origin;
    return std::nullopt;
  };
  const ServerNames names;
  const bool admitted = ReadOrRefuse([&] {
                          names.Check(request);
                          return true;
                        }).has_value();
  Require(!admitted || (name && IsLoopback(name->host)), "only loopback names are admitted");
  return admitted;
}

}  // namespace waystone
