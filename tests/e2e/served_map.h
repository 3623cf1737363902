// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <filesystem>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "cli/system/child_process.h"
#include "tests/e2e/shared_map.h"

// After Eigen, for which the macro _res of the resolver's header spells trouble, whoever includes
// it later.
#include <httplib.h>

namespace waystone {

// An answer; where there is none, as of a server that died, this test alone ends.
inline httplib::Result Checked(httplib::Result result) {
  if (!result) throw std::runtime_error("no answer: " + to_string(result.error()));
  return result;
}

// A server of the shared map, and a client.
class Served {
 public:
  explicit Served(const std::vector<std::string>& flags = {},
                  const std::filesystem::path& maps = TheMap().map) {
    std::vector<std::string> arguments = {WAYSTONE_PROGRAM, "serve", maps, "--port", "0"};
    arguments.insert(arguments.end(), flags.begin(), flags.end());
    process_ = std::make_unique<ChildProcess>(arguments, true);
    first_line_ = process_->ReadLine();
    second_line_ = process_->ReadLine();
    const size_t at = first_line_.find("http://");
    EXPECT_NE(at, std::string::npos) << first_line_;
    url_ = first_line_.substr(at);
  }

  httplib::Client NewClient() const {
    httplib::Client client(url_);
    client.set_read_timeout(30);
    return client;
  }
  const std::string& url() const { return url_; }
  const std::string& curl_line() const { return second_line_; }
  ChildProcess& process() { return *process_; }

 private:
  std::unique_ptr<ChildProcess> process_;
  std::string first_line_;
  std::string second_line_;
  std::string url_;
};

}  // namespace waystone
