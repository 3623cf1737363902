// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "api/json.h"
#include "cli/system/child_process.h"
#include "tests/e2e/served_map.h"
#include "tests/e2e/shared_map.h"

// After Eigen, for which the macro _res of the resolver's header spells trouble, whoever includes
// it later.
#include <httplib.h>

namespace waystone {

constexpr int kRegistryPatienceS = 60;

// A server of a registry's maps.
class RegistryServer {
 public:
  RegistryServer(const std::string& registry, const std::filesystem::path& cache,
                 const std::vector<std::string>& flags = {}, const std::string& watch_s = "0.1",
                 const std::string& port = "0") {
    std::vector<std::string> arguments = {WAYSTONE_PROGRAM, "serve", "--registry", registry,
                                          "--cache",        cache,   "--port",     port,
                                          "--watch",        watch_s};
    arguments.insert(arguments.end(), flags.begin(), flags.end());
    process_ = std::make_unique<ChildProcess>(arguments, true);
    const std::string line = process_->ReadLine();
    const size_t at = line.find("http://");
    EXPECT_NE(at, std::string::npos) << line;
    url_ = line.substr(at);
  }
  httplib::Client NewClient() const {
    httplib::Client client(url_);
    client.set_read_timeout(30);
    return client;
  }
  int Status(const std::string& path) const {
    const auto result = NewClient().Get(path);
    return result ? result->status : 0;
  }
  Json Get(const std::string& path) const {
    return Json::parse(Checked(NewClient().Get(path))->body);
  }
  Json Localize(const std::string& map) const {
    return Json::parse(Checked(NewClient().Post("/v1/maps/" + map + "/localize",
                                                ReadFile(TheMap().inside), "image/jpeg"))
                           ->body);
  }
  double Metric(const std::string& name) const {
    const std::string text = Checked(NewClient().Get("/metrics"))->body;
    const size_t at = text.find("\n" + name + " ");
    return at == std::string::npos ? -1 : std::stod(text.substr(at + name.size() + 2));
  }
  ChildProcess& process() { return *process_; }
  // "127.0.0.1:4711".
  std::string address() const { return url_.substr(url_.find("//") + 2); }

 private:
  std::unique_ptr<ChildProcess> process_;
  std::string url_;
};

inline bool Until(const std::function<bool()>& holds) {
  for (int i = 0; i < 100 * kRegistryPatienceS && !holds(); ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  return holds();
}

}  // namespace waystone
