// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <ostream>
#include <string>
#include <vector>

#include "server/http/message.h"

namespace waystone {

// A request to a server of the maps "photos" and "panoramas".
struct SentRequest {
  std::string name;
  std::string method;
  std::string path;
  std::string type;
  std::string body;
  int status = 200;  // of the answer

  HttpRequest ToRequest() const;
};

inline void PrintTo(const SentRequest& request, std::ostream* out) { *out << request.name; }

// Photos and panoramas in each kind of body, requests that can't be read, and what pages show.
std::vector<SentRequest> SentRequests();

// A photo as raw HTTP, with these parameters.
std::string PhotoQuery(const std::string& parameters);

}  // namespace waystone
