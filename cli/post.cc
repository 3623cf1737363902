// SPDX-License-Identifier: Apache-2.0
#include "cli/post.h"

#include <httplib.h>

#include "core/base/error.h"

namespace waystone {
namespace {

constexpr int kAnswerTimeoutS = 30;

}  // namespace

std::string Post(const std::string& server, const std::string& path,
                 const std::vector<uint8_t>& bytes, const std::string& content_type) {
  httplib::Client client(server);
  client.set_read_timeout(kAnswerTimeoutS);
  const httplib::Result result =
      client.Post(path, reinterpret_cast<const char*>(bytes.data()), bytes.size(), content_type);
  if (!result) throw MapError(ErrorCode::kInternal, "the server at " + server + " doesn't answer");
  return result->body;
}

}  // namespace waystone
